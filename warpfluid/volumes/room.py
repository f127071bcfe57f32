"""Whether there is memory for the frames of a sequence, as their headers tell before any value is read."""

from collections.abc import Callable

import numpy as np

from warpfluid.files.grids import GridFacts
from warpfluid.memory import check_memory

BYTES_A_NUMBER = 12  # as it is read, turned, and handed on
WAY_OUT = "at most {size} voxels fit: make smaller ones where they come from, or use a larger machine"

Shape = tuple[int, int, int]


def box_shape(facts: list[GridFacts], lattice, name: str) -> Shape | None:
    """Return the voxels (x, y, z) of a frame as it is read; None where its file does not tell.

    Args:
        facts: Of the grids of a file.
        lattice: Where all frames of the sequence lie; None if each lies where it likes.
        name: The grid that is the density.
    """
    if lattice is not None:
        return lattice.shape
    whole = next((grid.whole for grid in facts if grid.name == name), None)
    return None if whole is None else tuple(int(n) for n in whole[1] - whole[0] + 1)


def check_room(shape: Shape | None, numbers: int = 1, bytes_of: Callable[[Shape], float] | None = None, device=None):
    """Refuse volumes that there is no memory for.

    Args:
        shape: Voxels (x, y, z) of a frame; None is not refused.
        numbers: That are read, a voxel.
        bytes_of: Returns the memory that volumes of a shape take; what reading them takes when omitted.
        device: Where they are worked on, a Warp device; this machine when omitted.

    Raises:
        ValueError: If the memory does not suffice; it names the largest size that would do.
    """
    if shape is not None:
        read = bytes_of or (lambda size: float(np.prod(size, dtype=float)) * numbers * BYTES_A_NUMBER)
        check_memory(read, shape, device, what="volumes of this size", way_out=WAY_OUT)
