"""Read volumes of any kind of file alike."""

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from warpfluid.files.grids import GridFacts, GridFile
from warpfluid.files.npz import npz_facts, read_npz, read_npz_grids
from warpfluid.files.nvdb import nvdb_facts, read_nvdb
from warpfluid.files.vdb import read_vdb, vdb_facts
from warpfluid.files.vdb.layout import from_file_axes
from warpfluid.files.vti import read_vti, vti_facts


def file_facts(path: Path) -> list[GridFacts]:
    """Return what is known of every grid of a file before its values are read.

    Raises:
        ValueError: If it is damaged, or no volume.
        OSError: If it cannot be read.
    """
    kinds = {".vdb": vdb_facts, ".nvdb": nvdb_facts, ".npz": npz_facts, ".vti": vti_facts}
    return _reader(path, kinds)(path)


def read_grids(path: Path, names: Collection[str] | None = None, *, up: Literal["y", "z"] = "y") -> GridFile:
    """Read the grids of a file, y up.

    Args:
        path: The file.
        names: The grids to read; all by default.
        up: The up axis of a file that does not tell.

    Raises:
        ValueError: If it is damaged, no volume, or has no such grid.
        OSError: If it cannot be read.
    """
    if path.suffix in (".vdb", ".nvdb"):
        return (read_vdb if path.suffix == ".vdb" else read_nvdb)(path, names, up=up)
    file = _reader(path, {".npz": read_npz_grids, ".vti": read_vti})(path)
    missing = sorted(set(names or ()) - set(file.grids))
    if missing:
        raise ValueError(f"{path}: the file has no grid {', '.join(missing)}; it has {', '.join(file.grids)}")
    kept = {name: grid for name, grid in file.grids.items() if names is None or name in names}
    if up == "y":
        return replace(file, grids=kept)
    x, y, z = file.origin
    deep = next(iter(kept.values())).shape[1]
    turned = {name: np.ascontiguousarray(from_file_axes(grid, "z")) for name, grid in kept.items()}
    return replace(file, grids=turned, origin=(x, z, 0 - (y + (deep - 1) * file.voxel_size)))


def read_density(path: Path, name: str = "density", *, up: Literal["y", "z"] = "y") -> np.ndarray:
    """Return the density of a file in its own unit, shape (x, z, y).

    Args:
        path: The file.
        name: The grid that is the density.
        up: The up axis of a file that does not tell.

    Raises:
        ValueError: If it is damaged, or holds no density, or one that is negative or not finite.
        OSError: If it cannot be read.
    """
    plain = path.suffix == ".npz" and name == "density" and up == "y"
    density = read_npz(path)[0] if plain else read_grids(path, [name], up=up).grids[name]
    return checked_density(path, density)


def checked_density(path: Path, density: np.ndarray) -> np.ndarray:
    """Return a density (x, y, z) as (x, z, y).

    Raises:
        ValueError: If it holds vectors, or is negative or not finite.
    """
    if density.ndim != 3:
        raise ValueError(f"{path}: density has shape {density.shape}, expected one number a voxel")
    bad = int(np.count_nonzero(~(density >= 0) | np.isinf(density)))
    if bad:
        where = f"{bad} of {density.size} voxels"
        raise ValueError(
            f"{path}: the density is negative or not finite in {where}; warpfluid export --repair writes 0 there"
        )
    return np.ascontiguousarray(density.transpose(0, 2, 1), np.float32)


def _reader(path: Path, kinds: dict):
    if path.suffix not in kinds:
        raise ValueError(f"{path}: {path.suffix or 'this'} is no kind of volume; expected {', '.join(kinds)}")
    return kinds[path.suffix]
