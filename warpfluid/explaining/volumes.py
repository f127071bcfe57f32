"""What a file of volumes holds."""

import re
from pathlib import Path

import numpy as np

from warpfluid.files.grids import GridFacts
from warpfluid.files.sequences import format_frames
from warpfluid.volumes import ENDINGS, file_facts, find_volumes, lattice_of, read_grids

KINDS = {".vdb": "OpenVDB", ".nvdb": "NanoVDB", ".vti": "VTK image data", ".npz": "NumPy arrays"}
KNOWN = ("density", "temperature", "flame", "flames", "fuel", "heat", "color", "velocity", "vel", "v")
LARGE = 2**31  # bytes of a grid in memory that a machine may not have
LAST = re.compile(r"\d+(?=\D*$)")


def explain_volume(path: Path) -> dict:
    """Return what a file of volumes holds: grids, places, ranges, and what may go wrong with them.

    Raises:
        ValueError: If it is damaged.
        OSError: If it cannot be read.
    """
    facts = file_facts(path)
    grids = [_grid(path, grid) for grid in facts]
    names = [grid.name for grid in facts]
    warnings = [f"{grid['name']}: {text}" for grid in grids for text in grid.pop("warnings")]
    if "density" not in names:
        warnings.append("there is no grid density, which programs look for: name it with export --grid NAME")
    if path.suffix in (".vdb", ".nvdb", ".vti") and not any(grid.up for grid in facts):
        warnings.append("the file tells no up axis: y is assumed, say --source-up z if it lies on its back")
    if len({grid.lattice for grid in facts}) > 1:
        warnings.append("the grids differ in voxel size or place: they are read one by one, with --grid or --grids")
    return {
        "kind": KINDS[path.suffix],
        "grids": grids,
        "sequence": _sequence(path),
        "warnings": warnings,
    }


def _grid(path: Path, grid: GridFacts) -> dict:
    """Return what is known of a grid, with its values."""
    lattice = lattice_of(grid, grid.whole, "y")
    shape = lattice.shape if lattice else (0, 0, 0)
    components = 3 if grid.kind == "vec3s" else 1
    memory = int(np.prod(shape, dtype=float) * 4 * components)
    told = {
        "name": grid.name,
        "type": grid.kind + (" (half)" if grid.half else ""),
        "class": grid.about.get("class"),
        "size": list(shape),
        "box": grid.box.tolist() if grid.box is not None else None,
        "active": grid.active,
        "voxel_size": grid.voxel_size,
        "origin": list(lattice.origin) if lattice else None,
        "up": grid.up,
        "memory": memory,
    }
    warnings = [] if grid.name in KNOWN else ["a name that Blender and Houdini give no meaning"]
    if grid.voxel_size is None:
        warnings.append("its voxels are no cubes, or turned: resample it")
    if not grid.readable:
        return told | {"warnings": [*warnings, f"values of type {grid.kind} are not read"]}
    if memory > LARGE:
        return told | {"warnings": [*warnings, f"{memory / 2**30:.1f} GiB in memory: its values were not looked at"]}
    if grid.whole is None:
        return told | {"range": None, "warnings": [*warnings, "it is empty"]}
    values = read_grids(path, [grid.name]).grids[grid.name]
    return told | _values(values, warnings, density=grid.name == "density")


def _values(values: np.ndarray, warnings: list[str], *, density: bool) -> dict:
    """Return range and sum of values, and what is wrong with them."""
    finite = np.isfinite(values)
    bad = int(finite.size - np.count_nonzero(finite))
    sound = values[finite] if bad else values
    if bad:
        warnings.append(f"{bad} values are NaN or infinite: export --repair writes 0 there")
    negative = int(np.count_nonzero(sound < 0)) if density else 0
    if negative:
        warnings.append(f"{negative} values are negative: export --repair writes 0 there")
    if not sound.size or not sound.any():
        warnings.append("all values are 0")
    told = {
        "range": [float(sound.min()), float(sound.max())] if sound.size else None,
        "sum": float(sound.sum(dtype=np.float64)),
        "not_finite": bad,
        "warnings": warnings,
    }
    if values.ndim == 4:
        speed = np.sqrt((np.where(finite, values, 0).astype(np.float64) ** 2).sum(axis=3))
        told["longest"] = float(speed.max(initial=0))
    return told


def _sequence(path: Path) -> dict | None:
    """Return the frames of the sequence that a file belongs to; None for one that stands alone."""
    pattern = path.with_name(LAST.sub("#", path.stem) + path.suffix)
    if pattern.name == path.name or path.suffix not in ENDINGS:
        return None
    try:
        frames = list(find_volumes(pattern))
    except ValueError:
        return None
    whole = set(range(frames[0], frames[-1] + 1))
    missing = sorted(whole - set(frames))
    told = {"pattern": pattern.name, "frames": format_frames(frames), "count": len(frames)}
    return told | ({"missing": format_frames(missing)} if missing else {}) if len(frames) > 1 else None
