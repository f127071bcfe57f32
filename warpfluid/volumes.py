"""Sequences of volumes on disk: a run of ours, or files of another program."""

import re
from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from warpfluid.files.npz import read_npz
from warpfluid.files.vdb import read_vdb
from warpfluid.footage.sources import file_hash, parse_view
from warpfluid.options import OutputOptions
from warpfluid.run import SETTINGS, Run

ANGLES_DEG = (0.0, 90.0)  # that volumes of other programs are seen from
ENDINGS = (".vdb", ".npz")
WHITE = 255.0
_NUMBER = re.compile(r"(?:%0?\d*d|#+|\*)")
_LAST = re.compile(r"\d+(?=\D*$)")


@dataclass(frozen=True, kw_only=True)
class VolumeSequence:
    """Volumes by frame.

    Attributes:
        name: What the user called it.
        files: The volumes by frame, rising.
        angles_deg: Angles of the views that its volumes show.
        scale: What brings its densities to grey levels: 1 for a run; else the brightest ray of the first is white.
        output: How its files are stored, for more of the kind.
        document: What ``run.toml`` of a run says; None for volumes of another program.
    """

    name: str
    files: dict[int, Path]
    angles_deg: tuple[float, ...] = ANGLES_DEG
    scale: float = 1.0
    output: OutputOptions = field(default_factory=OutputOptions)
    document: dict | None = None

    @property
    def frames(self) -> tuple[int, ...]:
        """Its frames, rising."""
        return tuple(self.files)

    def density(self, frame: int) -> np.ndarray:
        """Return the density of a frame in grey levels a voxel, shape (x, z, y).

        Raises:
            ValueError: If its file is damaged, or holds no density, or one that is negative or not finite.
            OSError: If it cannot be read.
        """
        return read_density(self.files[frame]) * np.float32(self.scale)

    def fields(self, frame: int, names: Collection[str]) -> dict[str, np.ndarray]:
        """Return those of the named fields that a frame has, on one lattice.

        Density is in grey levels a voxel; velocity has shape (x, z, y, 3), components (x, z, y) [voxel/s];
        temperature, fuel and flame are as they are stored, shape (x, z, y).

        Raises:
            ValueError: If its file is damaged, or a field is not finite.
            OSError: If it cannot be read.
        """
        path = self.files[frame]
        if path.suffix == ".npz":
            return {"density": self.density(frame)} if "density" in names else {}
        file = read_vdb(path)
        found = {name: np.ascontiguousarray(file.grids[name].swapaxes(1, 2)) for name in names if name in file.grids}
        for name, grid in found.items():
            if not np.isfinite(grid).all():
                raise ValueError(f"{path}: the {name} is not finite")
        if "density" in found:
            found["density"] *= np.float32(self.scale)
        if "velocity" in found:
            found["velocity"] = np.ascontiguousarray(found["velocity"][..., [0, 2, 1]] / np.float32(file.voxel_size))
        return found

    def hashes(self) -> dict[str, str]:
        """Return what tells whether a file has changed, by frame."""
        return {str(frame): file_hash([path]) for frame, path in self.files.items()}


def open_volumes(name: str | Path) -> VolumeSequence:
    """Find a sequence of volumes.

    Args:
        name: A run; a folder, a pattern (``smoke.####.vdb``) or a file of volumes, .vdb or .npz.

    Raises:
        ValueError: If there are none.
        OSError: If they cannot be read.
    """
    path = Path(name).expanduser()
    if not (path / SETTINGS).is_file():
        files = find_volumes(path)
        brightest = float(read_density(next(iter(files.values()))).sum(axis=1).max())
        return VolumeSequence(name=str(name), files=files, scale=WHITE / max(brightest, 1e-30))
    run = Run(path)
    document = run.settings()
    files = {frame: run.volume_path(frame) for frame in run.records()}
    if not files:
        raise ValueError(f"{path} has no finished frame: reconstruct it first")
    angles = document.get("made-with", {}).get("angles") or [parse_view(view)[0] for view in document["views"]]
    output = OutputOptions(**document.get("output", {}))
    facts = {"angles_deg": tuple(map(float, angles)), "output": output, "document": document}
    return VolumeSequence(name=str(name), files=files, **facts)


def find_volumes(path: Path) -> dict[int, Path]:
    """Return volumes by frame, which is the last number in a file's name.

    Raises:
        ValueError: If there are none, or several of one frame.
    """
    if path.is_dir():
        found = sorted(file for file in path.iterdir() if file.suffix in ENDINGS and not file.name.startswith("."))
    elif path.is_file():
        found = [path]
    else:
        form = "".join("*" if _NUMBER.fullmatch(part) else part for part in re.split(f"({_NUMBER.pattern})", path.name))
        found = sorted(path.parent.glob(form)) if "*" in form and path.parent.is_dir() else []
    found = [file for file in found if file.suffix in ENDINGS]
    if not found:
        raise ValueError(f"{path} has no volumes: name a run, or a folder, pattern or file of .vdb or .npz volumes")
    names = sorted({_LAST.sub("####", file.stem) + file.suffix for file in found})
    if len(names) > 1:
        raise ValueError(f"{path} has several sequences, {', '.join(names[:4])}: choose one with a pattern")
    numbers = [int(match[0]) if (match := _LAST.search(file.stem)) else 1 for file in found]
    files = dict(sorted(zip(numbers, found, strict=True)))
    if len(files) < len(found):
        raise ValueError(f"{path} has several volumes of one frame: leave one of them")
    return files


def read_density(path: Path) -> np.ndarray:
    """Return the density of a file in its own unit, shape (x, z, y).

    Raises:
        ValueError: If it is damaged, or holds no density, or one that is negative or not finite.
        OSError: If it cannot be read.
    """
    density = read_npz(path)[0] if path.suffix == ".npz" else read_vdb(path, ["density"]).grids["density"]
    if density.ndim != 3:
        raise ValueError(f"{path}: density has shape {density.shape}, expected one number a voxel")
    if not np.isfinite(density).all() or density.min() < 0:
        raise ValueError(f"{path}: the density is negative or not finite, it must be 0 or more")
    return np.ascontiguousarray(density.transpose(0, 2, 1), np.float32)
