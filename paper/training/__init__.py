"""Training of the paper's networks: `make weights-paper`."""
