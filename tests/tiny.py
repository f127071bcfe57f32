"""Footage of 24 x 20 pixels and the command line in this process, for the tests of commands."""

import json
from pathlib import Path

import numpy as np

from warpfluid import cli
from warpfluid.files.images import write_png

QUICK = {"--iterations": "1", "--angles": "12", "--cg-steps": "2", "--lsm-steps": "2", "--device": "cpu"}
BARE = ("--no-turntable", "--no-report")


def flame(frame=0, angle=0, width=24, height=20):
    """Return a picture of two blobs that move, uint8 (rows, columns); all views have the same light in a row."""
    rows, columns = np.mgrid[:height, :width]
    picture = np.zeros((height, width))
    for k, place in enumerate((0.35, 0.65)):
        u = width * (place + 0.05 * np.sin(frame + k + angle))
        picture += 110 * np.exp(-((columns - u) ** 2 + (rows - height / 2 - k) ** 2) / 12)
    picture[[0, -1]] = 0
    return np.where(picture > 3, picture, 0).astype(np.uint8)


def footage(folder: Path, frames=range(1, 4), make=flame, angle=0) -> str:
    """Write a picture a frame; return the folder's name."""
    folder.mkdir()
    for frame in frames:
        write_png(folder / f"fire.{frame:04d}.png", make(frame, angle))
    return str(folder)


def pair(folder: Path, frames=range(1, 4)) -> list[str]:
    """Write a front and a side; return the flags that name them."""
    front, side = (footage(folder / name, frames, angle=k) for k, name in enumerate(("front", "side")))
    return ["--front", front, "--side", side]


def quick(*flags) -> list[str]:
    """Return the flags, and those of a quick run that are not among them."""
    return [*flags, *(text for item in QUICK.items() if item[0] not in flags for text in item)]


def run(*arguments) -> int:
    """Run a command in this process and return its exit code."""
    return cli.main([str(argument) for argument in arguments])


def volumes(folder: Path) -> dict[str, bytes]:
    """Return the volumes of a run by name, byte for byte."""
    return {path.name: path.read_bytes() for path in sorted(folder.glob("*.vdb"))}


def numbers(folder: Path) -> list[int]:
    """Return the frame of every line of the records; each line must be whole."""
    return [json.loads(line)["frame"] for line in (folder / "frames.jsonl").read_text().splitlines()]


METHOD_FLAGS = tuple(quick("--quiet"))
