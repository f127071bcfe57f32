"""What the examples of rendering share: small runs, and pictures of them by the command itself."""

import shlex
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

import numpy as np
from gallery import folder

from warpfluid.cli import main
from warpfluid.files.exr import write_exr
from warpfluid.files.images import read_image
from warpfluid.rendering.display import quantize
from warpfluid.rendering.probe import sphere

RUNS = {
    "fire": "simulate --preset fire --size 64x96 --frames 1-12 --no-turntable --no-report",
    "smoke": "simulate --preset smoke --size 64x96 --frames 1-60 --no-turntable --no-report",
    "explosion": "simulate --preset explosion --size 72x96 --frames 1-30 --no-turntable --no-report",
    "splash": "simulate --preset splash --size 64x96 --frames 1-30 --no-turntable --no-report",
    "demo": "demo",
}


@cache
def run(name: str) -> Path:
    """Return a run, made if the folder of the second argument does not hold it already."""
    place = Path(sys.argv[2]) if len(sys.argv) > 2 else folder()
    if not (place / name / "run.toml").exists():
        command = [sys.executable, "-m", "warpfluid", *shlex.split(RUNS[name]), "-o", str(place / name)]
        subprocess.run(command, check=True)
    return place / name


def render(name: str, frame: int, words: str, *, size: tuple[int, int] = (200, 268)) -> np.ndarray:
    """Return a frame of a run as a picture, uint8, with the flags of ``words``."""
    with tempfile.TemporaryDirectory() as made:
        path = f"{made}/picture.png"
        flags = shlex.split(f"--frames {frame} --resolution {size[0]}x{size[1]} {words} -o {path} --quiet")
        if main(["render", str(run(name)), *flags]):
            raise SystemExit(f"render {name} {words} failed")
        return quantize(read_image(path))


@cache
def evening() -> Path:
    """Return a light probe: a low sun on one side of a sky that is orange there and blue elsewhere, dark ground."""
    directions, _ = sphere((64, 128))
    sun = np.array([0.9, 0.25, 0.35]) / np.linalg.norm([0.9, 0.25, 0.35])
    towards, height = directions @ sun, directions[..., 1]
    blue = np.array([0.10, 0.18, 0.36]) * (0.5 + 0.5 * np.maximum(height, 0))[..., None]
    glow = np.array([1.2, 0.5, 0.18]) * np.exp(4 * (towards - 1))[..., None]
    disc = np.array([1.0, 0.72, 0.45]) * 160.0 * (towards > np.cos(np.deg2rad(4)))[..., None]
    sky = np.where((height > 0)[..., None], blue + glow + disc, np.array([0.05, 0.045, 0.04]))
    path = folder() / "evening.exr"
    write_exr(path, {"RGB": sky.astype(np.float32)})
    return path
