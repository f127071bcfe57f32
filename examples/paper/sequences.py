"""What the figures of sequences share: footage of scenes, runs of the command line, and what is measured in them."""

import io
import shlex
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout

import numpy as np
from common import arguments, project
from scenes import sequence

from warpfluid.cli import main
from warpfluid.files.images import write_png
from warpfluid.run import Run

SECTORS = 12  # directions of a window's spectrum


def footage(kind: str, frames: Sequence[int], angles_deg: Sequence[int]) -> str:
    """Film a scene from some angles; return the flags that name the films."""
    folder = arguments().out / "footage"
    folder.mkdir(exist_ok=True)
    for frame, volume in zip(frames, sequence(kind, tuple(frames)), strict=True):
        for angle, image in zip(angles_deg, project(volume, angles_deg), strict=True):
            grey = np.clip(np.rint(image.T[::-1] * 257), 0, 65535).astype(np.uint16)
            write_png(folder / f"{kind}-{angle}.{frame:04d}.png", grey)
    films = (f"--view {angle}={shlex.quote(str(folder / f'{kind}-{angle}.####.png'))}" for angle in angles_deg)
    return f"{' '.join(films)} --frames {frames[0]}-{frames[-1]}"


def run(name: str, words: str) -> Run:
    """Return a run of the command line, made if it is not there yet.

    Args:
        name: Of its folder.
        words: Command and flags, without the folder.
    """
    folder = arguments().out / "runs" / name
    if not (folder / "done").exists():
        more = ["-o", str(folder), "--overwrite", "--no-turntable", "--no-report", "--device", "cpu", "-q"]
        _do([*shlex.split(words), *more])
        (folder / "done").touch()
    return Run(folder)


def picture(made: Run, frame: int, words: str) -> np.ndarray:
    """Return a frame of a run as ``warpfluid render`` shows it with the flags of ``words``, uint8."""
    from warpfluid.files.images import read_image

    path = arguments().out / "runs" / "picture.png"
    flags = [*shlex.split(words), "--frames", str(frame), "-o", str(path), "--overwrite", "-q", "--device", "cpu"]
    _do(["render", str(made.folder), *flags])
    return np.clip(np.rint(read_image(path)[..., :3] * 255), 0, 255).astype(np.uint8)


def _do(words: list[str]) -> None:
    """Run a command without its words, and stop where it fails."""
    with redirect_stdout(io.StringIO()):
        code = main(words)
    if code:
        sys.exit(f"this failed: warpfluid {shlex.join(words)}")


def straight_lines(volume: np.ndarray) -> float:
    """Measure straight lines of any direction in horizontal slices, however short.

    Windows of a third of the width overlap by half; a window's score is the share of its spectrum in the strongest of
    twelve directions, times twelve. Windows count by their energy. Bent lines still are straight in a window.
    """
    size = max(8, volume.shape[0] // 3)
    step, window = size // 2, np.outer(np.hanning(size), np.hanning(size))
    fx, fz = np.fft.fftfreq(size)[:, None], np.fft.fftfreq(size)
    length, direction = np.hypot(fx, fz), np.degrees(np.arctan2(fz, fx + 0 * fz)) % 180
    ring = (length > 0.1) & (length < 0.4)
    sector = np.rint(direction[ring] / (180 / SECTORS)).astype(int) % SECTORS
    room = np.bincount(sector, minlength=SECTORS)
    places = range(0, volume.shape[0] - size + 1, step)
    total = weight = 0.0
    for x in places:
        for z in places:
            part = volume[x : x + size, z : z + size].astype(np.float64)
            part = (part - part.mean(axis=(0, 1))) * window[..., None]
            power = (np.abs(np.fft.fft2(part, axes=(0, 1))) ** 2)[ring]
            found = np.stack([power[sector == k].sum(axis=0) / room[k] for k in range(SECTORS)])
            total += found.max(axis=0).sum()
            weight += found.mean(axis=0).sum()
    return total / max(weight, 1e-12)
