"""A sequence of volumes, whoever wrote it."""

import json
import os
from collections.abc import Collection
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np

from warpfluid.files.grids import GridFacts, GridFile
from warpfluid.footage.sources import file_hash, parse_view
from warpfluid.options import OutputOptions
from warpfluid.run import SETTINGS, Run
from warpfluid.volumes.find import find_volumes
from warpfluid.volumes.lattice import FREE, Lattice, join, lattice_of
from warpfluid.volumes.reading import checked_density, file_facts, read_density, read_grids
from warpfluid.volumes.room import box_shape, check_room

ANGLES_DEG = (0.0, 90.0)  # that volumes of other programs are seen from
DENSITY = "density"
EXPORT = "export.json"  # of ``warpfluid export``
WHITE = 255.0
OWN_FREE = 2**40  # voxels that may be empty in files of ours; memory ends sooner


@dataclass(frozen=True, kw_only=True)
class VolumeSequence:
    """Volumes by frame.

    Attributes:
        name: What the user called it.
        files: The volumes by frame, rising.
        angles_deg: Angles of the views that its volumes show.
        scale: What brings its densities to grey levels: 1 for volumes of footage; else the brightest ray of the first
            is white, and a run that followed such volumes remembers.
        output: How its files are stored, for more of the kind.
        document: What ``run.toml`` of a run says; None for volumes of another program.
        density_name: The grid that is the density.
        up: Up axis of files that do not tell.
        lattice: Where all of its volumes lie; None for a run, and where files do not tell their place.
        messages: What the user should know of how the files were understood.
    """

    name: str
    files: dict[int, Path]
    angles_deg: tuple[float, ...] = ANGLES_DEG
    scale: float = 1.0
    output: OutputOptions = field(default_factory=OutputOptions)
    document: dict | None = None
    density_name: str = DENSITY
    up: Literal["y", "z"] = "y"
    lattice: Lattice | None = None
    messages: tuple[str, ...] = ()

    @property
    def frames(self) -> tuple[int, ...]:
        """Its frames, rising."""
        return tuple(self.files)

    @property
    def shape(self) -> tuple[int, int, int] | None:
        """Voxels (x, y, z) of its first frame as it is read; None where the file does not tell."""
        return box_shape(_facts_or_none(next(iter(self.files.values()))), self.lattice, self.density_name)

    def density(self, frame: int) -> np.ndarray:
        """Return the density of a frame in grey levels a voxel, shape (x, z, y).

        Raises:
            ValueError: If its file is damaged, or holds no density, or one that is negative or not finite.
            OSError: If it cannot be read.
        """
        path = self.files[frame]
        if self.lattice is None:
            return read_density(path, self.density_name, up=self.up) * np.float32(self.scale)
        return checked_density(path, self.read(frame, [DENSITY]).grids[DENSITY]) * np.float32(self.scale)

    def fields(self, frame: int, names: Collection[str]) -> dict[str, np.ndarray]:
        """Return those of the named fields that a frame has, on one lattice.

        Density is in grey levels a voxel; velocity has shape (x, z, y, 3), components (x, z, y) [voxel/s];
        temperature, fuel and flame are as they are stored, shape (x, z, y).

        Raises:
            ValueError: If its file is damaged, or a field is not finite.
            OSError: If it cannot be read.
        """
        file = self.read(frame, [name for name in self.grid_names(frame) if name in names])
        found = {name: np.ascontiguousarray(grid.swapaxes(1, 2)) for name, grid in file.grids.items()}
        for name, grid in found.items():
            bad = np.count_nonzero(~np.isfinite(grid))
            if bad:
                path = self.files[frame]
                raise ValueError(f"{path}: the {name} is not finite in {bad} places; export --repair writes 0 there")
        if "density" in found:
            found["density"] = found["density"] * np.float32(self.scale)
        if "velocity" in found:
            found["velocity"] = np.ascontiguousarray(found["velocity"][..., [0, 2, 1]] / np.float32(file.voxel_size))
        return found

    def grid_names(self, frame: int) -> list[str]:
        """Return the grids of a frame that can be read together with its density, density first.

        Raises:
            ValueError: If its file is damaged, or has no density.
            OSError: If it cannot be read.
        """
        path = self.files[frame]
        facts = file_facts(path)
        density = next((grid for grid in facts if grid.name == self.density_name), None)
        if density is None:
            have = ", ".join(grid.name for grid in facts) or "no grid"
            raise ValueError(f"{path}: there is no grid {self.density_name}, it has {have}: choose one with --grid")
        fit = [grid.name for grid in facts if grid.readable and grid.lattice == density.lattice]
        return [DENSITY, *(name for name in fit if name not in (DENSITY, self.density_name))]

    def read(self, frame: int, names: Collection[str] | None = None) -> GridFile:
        """Read grids of a frame as they are stored, y up, shape (x, y, z) or (x, y, z, 3), on the common lattice.

        Args:
            frame: Which one.
            names: The grids to read, ``density`` among them whatever its name in the file; all by default.

        Raises:
            ValueError: If its file is damaged, or lacks a grid.
            OSError: If it cannot be read.
        """
        names = self.grid_names(frame) if names is None else names
        there = [self.density_name if name == DENSITY else name for name in names]
        file = read_grids(self.files[frame], there, up=self.up)
        renamed = {DENSITY if name == self.density_name else name: grid for name, grid in file.grids.items()}
        file = replace(file, grids={name: renamed[name] for name in names})
        return self.lattice.place_file(file) if self.lattice else file

    def hashes(self) -> dict[str, str]:
        """Return what tells whether a file has changed, by frame."""
        return {str(frame): file_hash([path]) for frame, path in self.files.items()}


def open_volumes(
    name: str | Path, *, grid: str | None = None, up: Literal["y", "z"] = "y", unchecked: bool = False
) -> VolumeSequence:
    """Find a sequence of volumes.

    Args:
        name: A run; a folder, a pattern (``smoke.####.vdb``) or a file of volumes, .vdb, .nvdb, .vti or .npz.
        grid: The grid that is the density; by default ``density``, or the only one of numbers.
        up: Up axis of files that do not tell.
        unchecked: Leave the scale at 1 and the values unread, which may be negative or not finite.

    Raises:
        ValueError: If there are none, they do not fit together or into memory, or the first one is not sound.
        OSError: If they cannot be read.
    """
    path = Path(os.path.expanduser(name))
    if (path / SETTINGS).is_file():
        sequence = _open_run(Run(path), str(name), grid)
        check_room(sequence.shape)
        return sequence
    files = find_volumes(path)
    first = next(iter(files.values()))
    density, messages = _find_density(first, file_facts(first), grid)
    noted = _noted(first.parent)
    up = noted.get("up", up) if up == "y" else up
    facts = {frame: _facts_or_none(file) for frame, file in files.items()}
    sequence = VolumeSequence(
        name=str(name),
        files=files,
        density_name=density,
        up=up,
        lattice=_common(files, facts, density, up),
        messages=messages,
        output=replace(OutputOptions(), look=noted.get("look") or OutputOptions().look),
    )
    check_room(sequence.shape)
    if unchecked:
        return sequence
    brightest = float(sequence.density(sequence.frames[0]).sum(axis=1).max())
    return replace(sequence, scale=WHITE / max(brightest, 1e-30))


def _open_run(run: Run, name: str, grid: str | None) -> VolumeSequence:
    document = run.settings()
    files = {frame: run.volume_path(frame) for frame in run.records()}
    if not files:
        raise ValueError(f"{run.folder} has no finished frame: reconstruct it first")
    made = document.get("made-with", {})
    angles = made.get("angles") or [parse_view(view)[0] for view in document.get("views", ())]
    output = OutputOptions(**document.get("output", {}))
    finer = document.get("simulate", {}).get("detail", 1)  # its files have more and smaller voxels
    return VolumeSequence(
        name=name,
        files=files,
        angles_deg=tuple(map(float, angles)) or ANGLES_DEG,
        scale=float(made.get("scale", 1.0)),
        output=replace(output, voxel_size=output.voxel_size / finer),
        document=document,
        density_name=grid or DENSITY,
    )


def _noted(folder: Path) -> dict:
    """Return what our own export says of its folder, and its files do not: the up axis, and the look of the source."""
    try:
        noted = json.loads((folder / EXPORT).read_text("utf-8"))
        return {"up": str(noted["up"]), "look": noted["look"]} if noted["up"] in ("y", "z") else {}
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return {}


def _facts_or_none(path: Path) -> list[GridFacts]:
    """Return what is known of a file's grids; of a damaged file nothing, for reading that frame tells what is wrong."""
    try:
        return file_facts(path)
    except ValueError:
        return []


def _find_density(path: Path, facts: list[GridFacts], asked: str | None) -> tuple[str, tuple[str, ...]]:
    """Return which grid is the density, and what to say about that."""
    numbers = [grid.name for grid in facts if grid.kind == "float"]
    have = ", ".join(grid.name for grid in facts) or "no grid"
    if asked:
        if asked not in [grid.name for grid in facts]:
            raise ValueError(f"{path}: there is no grid {asked}, it has {have}: choose one with --grid")
        return asked, ()
    if any(grid.name == DENSITY for grid in facts):
        return DENSITY, ()
    if len(numbers) == 1:
        return numbers[0], (f"{path.name} has no grid density: its grid {numbers[0]} is taken for it",)
    raise ValueError(f"{path}: there is no grid density, it has {have}: choose one with --grid")


def _common(files: dict[int, Path], facts: dict[int, list[GridFacts]], density: str, up: str) -> Lattice | None:
    """Return the lattice of all frames; of one voxel where none holds anything, None where files tell no place."""
    parts, active = {}, {}
    for frame, path in files.items():
        grid = next((grid for grid in facts[frame] if grid.name == density), None)
        if grid is None or not grid.readable:
            continue
        if grid.about.get("placed") is False:
            return None
        fit = [other for other in facts[frame] if other.readable and other.lattice == grid.lattice]
        boxes = [other.whole for other in fit if other.whole is not None]
        whole = np.array([np.min(boxes, 0)[0], np.max(boxes, 0)[1]]) if boxes else None
        parts[path] = lattice_of(grid, whole, up)
        if all(other.active is not None for other in fit):
            active[path] = sum(other.active for other in fit)
    found = join(parts, free=_free(facts.values()), active=active)
    return found or (Lattice(1.0, (0.0, 0.0, 0.0), (1, 1, 1)) if parts else None)


def _free(files: Collection[list[GridFacts]]) -> int:
    """Return how many voxels of a sequence may be empty: in ours, whose boxes were asked for, what memory holds."""
    return OWN_FREE if any(grid.up for grids in files for grid in grids) else FREE
