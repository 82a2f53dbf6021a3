"""How the shipped weights are made; nothing that serves imports it."""
