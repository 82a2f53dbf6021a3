"""What several of the paper's methods are made of."""
