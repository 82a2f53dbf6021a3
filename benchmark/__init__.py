"""How right, how exact and how fast: case sets, methods, measures, raw records, and the report of them."""
