"""What is installed and what this machine can do, for a report that helps when something does not work."""

from warpfluid.doctor.examining import complaints, examine
from warpfluid.doctor.windows import drawing
from warpfluid.doctor.words import lines

__all__ = ["complaints", "drawing", "examine", "lines"]
