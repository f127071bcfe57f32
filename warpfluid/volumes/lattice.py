"""Where the volumes of a sequence lie.

Other programs cut a grid to what it holds, so every frame has another size and another place. All of them are put on
one lattice here, by the places that the files tell.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warpfluid.files.grids import GridFacts, GridFile
from warpfluid.files.limits import VOXELS_AN_ACTIVE

NEAR = 0.02  # of a voxel: what transforms in 32 bits get wrong
FREE = 2**29  # voxels of a lattice
VOXELS_A_BYTE = 512  # more of them for a byte of the files: what is sparse is small, but not that small
FAR = 2.0**40  # voxels; what lies further aside is outside anyway
SAME = 1e-4  # relative difference of voxel sizes that counts as none


@dataclass(frozen=True)
class Lattice:
    """Voxels in the world, y up.

    Attributes:
        voxel_size: Side of a voxel [world unit].
        origin: Centre of voxel (0, 0, 0) [world unit].
        shape: Voxels (x, y, z).
    """

    voxel_size: float
    origin: tuple[float, float, float]
    shape: tuple[int, int, int]

    def offset(self, origin: Iterable[float]) -> np.ndarray:
        """Return the voxel of this lattice at which another one begins, float, shape (3,)."""
        with np.errstate(over="ignore", invalid="ignore"):  # damaged files lie anywhere
            return (np.asarray(origin) - self.origin) / self.voxel_size

    def place(self, array: np.ndarray, origin: Iterable[float]) -> np.ndarray:
        """Return an array on this lattice: cut where it is larger, with 0 where it is smaller.

        Args:
            array: Shape (x, y, z) or (x, y, z, 3).
            origin: Centre of its first voxel [world unit].
        """
        first = np.nan_to_num(np.rint(self.offset(origin))).clip(-FAR, FAR).astype(int)
        if not first.any() and array.shape[:3] == self.shape:
            return array
        placed = np.zeros((*self.shape, *array.shape[3:]), array.dtype)
        low, high = np.maximum(first, 0), np.minimum(first + array.shape[:3], self.shape)
        if (high > low).all():
            into = tuple(slice(*span) for span in zip(low, high, strict=True))
            out_of = tuple(slice(*span) for span in zip(low - first, high - first, strict=True))
            placed[into] = array[out_of]
        return placed

    def place_file(self, file: GridFile) -> GridFile:
        """Return the grids of a file on this lattice."""
        grids = {name: self.place(grid, file.origin) for name, grid in file.grids.items()}
        return GridFile(grids=grids, voxel_size=self.voxel_size, origin=self.origin, metadata=file.metadata)


def lattice_of(facts: GridFacts, box: np.ndarray | None, up: str) -> Lattice | None:
    """Return where a box of a grid lies; None for no box.

    Args:
        facts: Of the grid.
        box: First and last index in the file's axes, shape (2, 3).
        up: The up axis where the file does not tell.
    """
    if box is None or facts.voxel_size is None:
        return None
    size, (x, y, z) = facts.voxel_size, facts.shift
    low, high = box.tolist()
    shape = [b - a + 1 for a, b in zip(low, high, strict=True)]
    if (facts.up or up) == "z":
        origin = (x + size * low[0], z + size * low[2], 0 - (y + size * high[1]))
        return Lattice(size, origin, (shape[0], shape[2], shape[1]))
    return Lattice(size, tuple(a + size * b for a, b in zip(facts.shift, low, strict=True)), tuple(shape))


def lit_part(file: GridFile) -> Lattice | None:
    """Return where the density of a file is not 0; None if it is nowhere."""
    lit = file.grids["density"] != 0
    if not lit.any():
        return None
    spans = [np.flatnonzero(lit.any(axis=tuple({0, 1, 2} - {axis})))[[0, -1]] for axis in range(3)]
    origin = tuple(place + file.voxel_size * int(span[0]) for place, span in zip(file.origin, spans, strict=True))
    return Lattice(file.voxel_size, origin, tuple(int(span[1] - span[0]) + 1 for span in spans))


def join(
    parts: Mapping[Path, Lattice | None], *, free: int = FREE, active: Mapping[Path, int] | None = None
) -> Lattice | None:
    """Return the lattice that holds all others; None if there is none.

    Args:
        parts: By the file that each is of.
        free: Voxels that may be empty, whatever the size of the files.
        active: Voxels of every file that are not empty, where that is known.

    Raises:
        ValueError: If voxels differ in size, or lie between those of others, or are too many.
    """
    there = {path: part for path, part in parts.items() if part is not None}
    if not there:
        return None
    first_path, first = next(iter(there.items()))
    lows, highs = [], []
    for path, part in there.items():
        if abs(part.voxel_size - first.voxel_size) > SAME * first.voxel_size:
            sizes = f"{part.voxel_size:g} and not {first.voxel_size:g}, as in {first_path.name}"
            raise ValueError(f"{path}: its voxels are {sizes}; resample the sequence to one size")
        offset = first.offset(part.origin)
        if np.abs(offset - np.rint(offset)).max() > NEAR:
            raise ValueError(f"{path}: its voxels lie between those of {first_path.name}; resample them to one lattice")
        lows.append(np.rint(offset))
        highs.append(np.rint(offset) + part.shape)
    low, high = np.min(lows, 0), np.max(highs, 0)
    most = {path: VOXELS_A_BYTE * path.stat().st_size for path in there}
    room = sum(min(VOXELS_AN_ACTIVE * (active or most).get(path, n), n) for path, n in most.items())
    if not np.prod(high - low) <= free + room:
        sides = " x ".join(f"{n:.0f}" for n in high - low)
        where = first_path.parent if len(there) > 1 else first_path
        raise ValueError(f"{where}: the volumes are spread over {sides} voxels; choose fewer frames")
    origin = tuple(a + first.voxel_size * b for a, b in zip(first.origin, low.tolist(), strict=True))
    return Lattice(first.voxel_size, origin, tuple(int(n) for n in high - low))
