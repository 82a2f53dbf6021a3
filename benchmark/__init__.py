"""How right, how exact and how fast: case sets, measures, and the command that prints them."""
