"""Section 3 of the paper: volumes from sparse views."""
