"""What a simulation starts from and follows: a run, volumes of another program, or an empty box."""

import re
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from warpfluid.files.npz import read_npz
from warpfluid.files.vdb import read_vdb
from warpfluid.options import OutputOptions
from warpfluid.run import SETTINGS, Run

ANGLES_DEG = (0.0, 90.0)  # that volumes of other programs are seen from
FULL = 0.99  # quantile of the density that counts as full
WIDE = 4.0  # heights of a box are this many widths of a usual plume
ENDINGS = (".vdb", ".npz")
_NUMBER = re.compile(r"(?:%0?\d*d|#+|\*)")
_LAST = re.compile(r"\d+(?=\D*$)")


@dataclass(frozen=True, kw_only=True)
class Source:
    """A sequence of volumes.

    Attributes:
        name: What the user called it.
        files: The volumes by frame; none for an empty box.
        shape: Voxels of a volume as it is simulated (x, z, y), as deep as wide.
        angles_deg: Angles of the views that its volumes show.
        scale: What brings its densities to grey levels.
        resolution_scale: Voxels of the simulation for one of its own, along each axis.
        output: How its files are stored, for more of the kind.
        reference: Full density, in grey levels a voxel.
    """

    name: str
    files: dict[int, Path]
    shape: tuple[int, int, int]
    angles_deg: tuple[float, ...] = ANGLES_DEG
    scale: float = 1.0
    resolution_scale: float = 1.0
    output: OutputOptions = field(default_factory=OutputOptions)
    reference: float = 1.0

    @property
    def frames(self) -> tuple[int, ...]:
        """Its frames, rising."""
        return tuple(self.files)

    def volume(self, frame: int) -> np.ndarray:
        """Return a volume in grey levels, shape (x, z, y).

        Raises:
            ValueError: If its file is damaged, holds no density or has another size.
            OSError: If it cannot be read.
        """
        volume = _read(self.files[frame]) * np.float32(self.scale)
        volume = _fit(_resample(volume, self.resolution_scale), self.shape)
        if volume is None:
            raise ValueError(f"{self.files[frame]}: the volume is larger than that of frame {self.frames[0]}")
        return volume

    def identities(self) -> dict[str, str]:
        """Return what tells whether a file has changed, by frame: its size and the time of its last change."""
        found = {frame: path.stat() for frame, path in self.files.items()}
        return {str(frame): f"{facts.st_size}-{facts.st_mtime_ns}" for frame, facts in found.items()}


def open_source(name: str | None, *, size: tuple[int, int] | None, resolution_scale: float = 1.0) -> Source:
    """Find what a simulation starts from.

    Args:
        name: A run; a folder, a pattern (``smoke.####.vdb``) or a file of volumes, .vdb or .npz; None for an empty box.
        size: Width and height of an empty box [voxel].
        resolution_scale: Voxels of the simulation for one of the source, along each axis.

    Raises:
        ValueError: If there is nothing to start from.
        OSError: If it cannot be read.
    """
    if name is None:
        width, height = (max(4, round(n * resolution_scale)) for n in size or (96, 144))
        return Source(name="", files={}, shape=(width, width, height), reference=WIDE * 255 / height)
    path = Path(name).expanduser()
    facts = {"name": name, "resolution_scale": resolution_scale}
    if (path / SETTINGS).is_file():
        run = Run(path)
        document = run.settings()
        angles = document.get("made-with", {}).get("angles") or [view_angle(view) for view in document["views"]]
        facts |= {"angles_deg": tuple(map(float, angles)), "output": OutputOptions(**document.get("output", {}))}
        files = {frame: run.volume_path(frame) for frame in run.records()}
        if not files:
            raise ValueError(f"{path} has no finished frame: reconstruct it first")
    else:
        files = find_volumes(path)
    first = _read(next(iter(files.values())))
    scale = 1.0 if "output" in facts else 255 / max(float(first.sum(axis=1).max()), 1e-30)
    volume = _resample(first * np.float32(scale), resolution_scale)
    width = max(volume.shape[:2])
    lit = volume[volume > 0]
    source = Source(files=files, shape=(width, width, volume.shape[2]), scale=scale, **facts)
    return replace(source, reference=float(np.quantile(lit, FULL)) if lit.size else WIDE * 255 / volume.shape[2])


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


def view_angle(view: str) -> float:
    """Return the angle of ``ANGLE=PATH``."""
    return float(view.partition("=")[0])


def _read(path: Path) -> np.ndarray:
    """Return a file's density, shape (x, z, y)."""
    density = read_npz(path)[0] if path.suffix == ".npz" else read_vdb(path, ["density"]).grids["density"]
    if density.ndim != 3:
        raise ValueError(f"{path}: density has shape {density.shape}, expected one number a voxel")
    if not np.isfinite(density).all() or density.min() < 0:
        raise ValueError(f"{path}: the density is negative or not finite, it must be 0 or more")
    return np.ascontiguousarray(density.transpose(0, 2, 1), np.float32)


def _resample(volume: np.ndarray, factor: float) -> np.ndarray:
    """Return a volume with more or fewer voxels and the same ray sums."""
    if factor == 1:
        return volume
    from scipy.ndimage import zoom

    return np.maximum(zoom(volume, factor, order=1, mode="nearest", grid_mode=True), 0) / np.float32(factor)


def _fit(volume: np.ndarray, shape: tuple[int, int, int]) -> np.ndarray | None:
    """Return a volume in the middle of a box, on its floor; None if it is larger."""
    room = [n - m for n, m in zip(shape, volume.shape, strict=True)]
    if min(room) < 0:
        return None
    return np.pad(
        volume, [(room[0] // 2, room[0] - room[0] // 2), (room[1] // 2, room[1] - room[1] // 2), (0, room[2])]
    )
