"""Results beside each other and beside the truth: numbers with their floors, a film, a sheet of stills."""
