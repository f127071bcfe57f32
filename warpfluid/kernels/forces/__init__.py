"""What pushes and stirs a fluid."""
