"""One frame as it is exported."""

from dataclasses import dataclass, replace

import numpy as np

from warpfluid.files.grids import GridFile
from warpfluid.files.vdb import lost_mass
from warpfluid.options import ExportOptions
from warpfluid.volumes import Lattice, VolumeSequence, file_facts, join, lattice_of, lit_part

DENSITY, VELOCITY = "density", "velocity"
VELOCITIES = (VELOCITY, "vel", "v")  # as other programs call it
FULL = 0.99  # quantile of what is lit that counts as full
FAINT = 0.01  # of the maximum; less is not lit


@dataclass(frozen=True)
class Prepared:
    """A frame that is ready to be written.

    Attributes:
        file: Its grids, shape (x, y, z) or (x, y, z, 3), and where they lie.
        facts: What is noted of it.
    """

    file: GridFile
    facts: dict


def prepare(sequence: VolumeSequence, frame: int, options: ExportOptions, lit: Lattice | None) -> Prepared:
    """Read a frame and make of it what is written.

    Args:
        sequence: The source.
        frame: Which one.
        options: What is asked for.
        lit: The box to cut to; None for the whole.

    Raises:
        ValueError: If its file is damaged, lacks a grid that is asked for, or holds values that are no numbers.
        OSError: If it cannot be read.
    """
    file = sequence.read(frame, _chosen(sequence, frame, options))
    grids, repaired = _sound(sequence, frame, file, options)
    lost = 0.0
    if DENSITY in grids:
        density = grids[DENSITY]
        limit = options.drop_below * float(density.max(initial=0))
        lost = lost_mass(density, limit)
        grids[DENSITY] = np.where(density > limit, density, np.float32(0)) * np.float32(options.density_scale)
    file = _resized(replace(file, grids=grids), options.voxel_size)
    if lit is not None:
        file = _resized_lattice(lit, options.voxel_size).place_file(file)
    named = {options.velocity_name if name in VELOCITIES else name: grid for name, grid in file.grids.items()}
    if len(named) < len(file.grids):
        raise ValueError(f"{sequence.files[frame]}: several grids are velocities: choose with --grids")
    facts = {"mass_dropped": lost, **({"repaired": repaired} if repaired else {}), **_seen(named)}
    return Prepared(replace(file, grids=named), facts)


def lit_box(sequence: VolumeSequence) -> Lattice | None:
    """Return the box of everything lit in any frame; None if nothing is.

    Raises:
        ValueError: If the frames do not fit together.
        OSError: If a file cannot be read.
    """
    parts = {}
    for frame, path in sequence.files.items():
        try:
            grids = file_facts(path)
            (density,) = [grid for grid in grids if grid.name == sequence.density_name]
        except ValueError:  # it fails again when it is exported, with a message of its own
            continue
        if density.active is None:
            parts[path] = lit_part(sequence.read(frame, [DENSITY]))
        else:
            parts[path] = lattice_of(density, density.box, sequence.up)
    return join(parts)


def _chosen(sequence: VolumeSequence, frame: int, options: ExportOptions) -> list[str]:
    """Return the grids to read."""
    there = sequence.grid_names(frame)
    if options.grids is None:
        return there
    asked = [name.strip() for name in options.grids.split(",") if name.strip()]
    missing = [name for name in asked if name not in there]
    if missing or not asked:
        have = f"it has {', '.join(there)}"
        raise ValueError(f"{sequence.files[frame]}: there is no grid {', '.join(missing)}, {have}: choose with --grids")
    return asked


def _sound(
    sequence: VolumeSequence, frame: int, file: GridFile, options: ExportOptions
) -> tuple[dict[str, np.ndarray], dict[str, int]]:
    """Return grids of numbers, and in how many places each was repaired."""
    grids, repaired = dict(file.grids), {}
    for name, grid in file.grids.items():
        wrong = ~np.isfinite(grid)
        if name == DENSITY:
            wrong |= ~(grid >= 0)
        voxels = wrong if grid.ndim == 3 else wrong.any(axis=3)
        count = int(np.count_nonzero(voxels))
        if not count:
            continue
        what = "negative or not finite" if name == DENSITY else "not finite"
        if not options.repair:
            where = f"{count} of {voxels.size} voxels"
            raise ValueError(f"{sequence.files[frame]}: the {name} is {what} in {where}: write 0 there with --repair")
        grids[name], repaired[name] = np.where(wrong, np.float32(0), grid), count
    return grids, repaired


def _resized(file: GridFile, size: float | None) -> GridFile:
    """Return the grids with voxels of another size; what is a length a second grows with them."""
    if size is None or size == file.voxel_size:
        return file
    factor = size / file.voxel_size
    grids = {n: g * np.float32(factor) if n in VELOCITIES else g for n, g in file.grids.items()}
    return replace(file, grids=grids, voxel_size=size, origin=tuple(factor * place for place in file.origin))


def _resized_lattice(lattice: Lattice, size: float | None) -> Lattice:
    if size is None:
        return lattice
    return Lattice(size, tuple(size / lattice.voxel_size * place for place in lattice.origin), lattice.shape)


def _seen(grids: dict[str, np.ndarray]) -> dict:
    """Return what materials need to know: how dense is full, and how much a frame holds."""
    full = {}
    for name, grid in grids.items():
        lit = grid[grid > FAINT * grid.max(initial=0)] if grid.ndim == 3 else np.zeros(0)
        if lit.size:
            full[name] = float(np.quantile(lit, FULL))
    brightest = float(grids[DENSITY].sum(axis=2).max()) if DENSITY in grids else 0.0
    return {
        "full": full,
        "brightest_ray": brightest,
        "grids": {n: "vec3s" if g.ndim == 4 else "float" for n, g in grids.items()},
    }
