"""What the six sides of the box are: open to still air, closed by a wall, or joined to the side across."""

import warp as wp

OPEN, CLOSED, WRAP = 0, 1, 2
SIX = wp.types.vector(length=6, dtype=int)  # of x low, x high, z low, z high, y low, y high
