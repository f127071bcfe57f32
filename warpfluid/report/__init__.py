"""What a finished run shows: a turntable, and one page with pictures, energy and numbers."""
