"""The things that are compared, as volumes of one size and one unit."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from warpfluid.errors import Problems
from warpfluid.files.sequences import format_frames
from warpfluid.footage.origin import find_origin
from warpfluid.rendering.surfaces import Surface
from warpfluid.report.film import surfaces_in
from warpfluid.run import Run
from warpfluid.settings import make_simulate_settings
from warpfluid.simulation.animation import is_edited
from warpfluid.simulation.outlines import Outlines
from warpfluid.volumes import VolumeSequence, squared


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One column of the table.

    Attributes:
        name: What people call it, another one for each.
        volumes: Where it is.
        shape: Voxels of its volumes (x, z, y), as deep as wide.
    """

    name: str
    volumes: VolumeSequence
    shape: tuple[int, int, int]

    @property
    def foreign(self) -> bool:
        """Whether it began in another program, whose unit of density is not known."""
        return find_origin(self.volumes.document) is None

    @property
    def edited(self) -> bool:
        """Whether an artist added something, so that it is not meant to be the footage any more.

        Raises:
            ValueError: If its settings are damaged.
        """
        document = self.volumes.document or {}
        if "simulate" not in document:
            return False
        settings = make_simulate_settings(None, None, None, {}, document=document)
        return is_edited(settings.simulate, settings.scene)

    def volume(self, frame: int) -> np.ndarray:
        """Return the density of a frame in grey levels, shape (x, z, y).

        Raises:
            ValueError: If its file is damaged or has another size.
            OSError: If it cannot be read.
        """
        volume = squared(self.volumes.density(frame))
        if volume.shape != self.shape:
            raise ValueError(
                f"{self.volumes.files[frame]}: the volume has another size than frame {self.volumes.frames[0]}"
            )
        return volume

    def surfaces(self, frame: int) -> list[Surface]:
        """Return the bodies and obstacles of a frame; only a simulation has any.

        Raises:
            ValueError: If what the run says of them is damaged.
            OSError: If it cannot be read.
        """
        return surfaces_in(self._outlines, frame, self.shape) if self._outlines else []

    @cached_property
    def _outlines(self) -> Outlines | None:
        return Outlines(Run(Path(self.volumes.name).expanduser())) if self.volumes.document else None

    def total(self, frames: Sequence[int]) -> float:
        """Return the density of some frames together."""
        return float(sum(self.volume(frame).sum(dtype=np.float64) for frame in frames))

    def scaled(self, factor: float) -> "Entry":
        """Return the same with another unit of density."""
        return replace(self, volumes=replace(self.volumes, scale=self.volumes.scale * factor))


def make_entries(sequences: Sequence[VolumeSequence]) -> list[Entry]:
    """Give every sequence a name of its own, and check that all have one size.

    Raises:
        ValueError: If the sizes differ, or a volume is damaged.
        OSError: If a volume cannot be read.
    """
    problems = Problems()
    names = short_names([sequence.name for sequence in sequences])
    sizes = [problems.attempt(lambda s=s: squared(s.density(s.frames[0])).shape) for s in sequences]
    problems.raise_if_any()
    entries = [Entry(name=n, volumes=s, shape=z) for n, s, z in zip(names, sequences, sizes, strict=True)]
    if len(set(sizes)) > 1:
        found = ", ".join(f"{e.name} {e.shape[0]} x {e.shape[2]} x {e.shape[1]}" for e in entries)
        raise ValueError(
            f"the volumes have unlike boxes ({found} voxels): reconstruct at one --resolution, "
            "simulate with one --resolution-scale and --detail, export without --crop"
        )
    return entries


def common_frames(entries: Sequence[Entry], asked: Sequence[int] | None) -> tuple[int, ...]:
    """Return the frames that all entries have, or those asked for.

    Raises:
        ValueError: If there are none, or an entry lacks one that is asked for.
    """
    common = set.intersection(*(set(entry.volumes.frames) for entry in entries))
    spans = ", ".join(f"{entry.name} has {format_frames(entry.volumes.frames)}" for entry in entries)
    missing = sorted(set(asked or ()) - common)
    if missing:
        raise ValueError(f"frame {format_frames(missing)} is not in all of them ({spans}): choose with --frames")
    if not common:
        raise ValueError(f"there is no frame in common ({spans}): number their files alike")
    return tuple(sorted(asked or common))


def same_units(entries: Sequence[Entry], frames: Sequence[int], wanted: float | None) -> list[Entry]:
    """Bring volumes of other programs to grey levels, each by one factor for all frames.

    Args:
        entries: All that are compared; runs have grey levels already.
        frames: Frames whose totals are made equal.
        wanted: Total of the footage over these frames; by default that of the first run, or of the first entry.
    """
    if not any(entry.foreign for entry in entries):
        return list(entries)
    first_run = next((entry for entry in entries if not entry.foreign), entries[0])
    wanted = first_run.total(frames) if wanted is None else wanted
    totals = [entry.total(frames) if entry.foreign else 0.0 for entry in entries]
    return [e.scaled(wanted / total) if total > 0 else e for e, total in zip(entries, totals, strict=True)]


def short_names(paths: Sequence[str]) -> list[str]:
    """Return the last part of every path, with more of it or a number where that is not unique."""
    parts = [Path(path).expanduser().resolve().parts[1:] or (str(path),) for path in paths]
    for length in range(1, max(map(len, parts)) + 1):
        names = ["/".join(part[-length:]) for part in parts]
        if len(set(names)) == len(names):
            return names
    return [f"{name} ({i})" for i, name in enumerate(names, 1)]
