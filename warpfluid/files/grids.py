"""What files of volumes have in common: grids on a lattice, and what can be told of them without their values."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True)
class GridFile:
    """The grids of a file on one lattice.

    Attributes:
        grids: Arrays by name, float32, shape (x, y, z) or (x, y, z, 3), all of one size.
        voxel_size: Side of a voxel [world unit].
        origin: Where the centre of voxel (0, 0, 0) lies [world unit].
        metadata: Facts stored with the file, by name; ``creator`` is the program that wrote it.
    """

    grids: dict[str, np.ndarray]
    voxel_size: float
    origin: tuple[float, float, float]
    metadata: dict[str, float | int | str | bool | tuple]


@dataclass(frozen=True, kw_only=True)
class GridFacts:
    """What a file tells of a grid before its values are read.

    Attributes:
        name: What it is called.
        kind: Type of its values: ``float``, ``vec3s``, ...
        half: Whether they are stored in 16 bits.
        voxel_size: Side of a voxel [world unit]; None where voxels are no cubes, or are turned.
        shift: Where the voxel of index (0, 0, 0) lies in the file's axes [world unit].
        box: First and last index of active voxels in the file's axes, shape (2, 3); None if there is none.
        whole: The same of the array that was written, where the file says so; else that of ``box``.
        active: Number of active voxels, if known.
        up: The file's up axis if it says so, ``y`` or ``z``.
        about: What else is stored with it, by name.
    """

    name: str
    kind: str
    half: bool
    voxel_size: float | None
    shift: tuple[float, float, float]
    box: np.ndarray | None
    whole: np.ndarray | None
    active: int | None
    up: str | None
    about: dict

    @property
    def readable(self) -> bool:
        """Whether it can be read: numbers or vectors on an upright lattice of cubes."""
        return self.kind in ("float", "vec3s") and self.voxel_size is not None

    @property
    def lattice(self) -> tuple:
        """What grids share that are read together."""
        return self.up, self.voxel_size, self.shift
