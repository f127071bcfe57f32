"""What the benchmark of scale works on: footage, volumes and command lines of a size."""

from pathlib import Path

import numpy as np

ITERATIONS = 2
RECONSTRUCT = ["--no-turntable", "--no-report", "--iterations", str(ITERATIONS), "--coherent-iterations", "1"]
PICTURE = (960, 540)


def puffs(width: int, frame: int, angle: int) -> np.ndarray:
    """Return a picture of puffs that rise and turn, uint8 (rows, columns); both views have the same light in a row."""
    rng = np.random.default_rng(4)
    place, light = np.arange(width) / (width - 1.0) - 0.5, np.zeros((width, width))
    for _ in range(40):
        phase, turn, radius, speed = rng.random(), rng.uniform(0, 2 * np.pi), rng.uniform(0.02, 0.06), rng.uniform(1, 2)
        height = (phase + 0.004 * speed * frame) % 1.0
        away = 0.12 * (0.4 + height) * np.sin(turn + 0.05 * frame + angle * np.pi / 180)
        across = np.exp(-(((place - away) / radius) ** 2) / 2)
        along = np.exp(-(((0.45 - 0.9 * height - place) / radius) ** 2) / 2)
        light += np.sin(np.pi * height) * along[:, None] * across
    return np.where(light > 0.03, np.minimum(120 * light, 255), 0).astype(np.uint8)


def footage(folder: Path, width: int, frames: int) -> list[str]:
    """Write both views; return the flags that name them."""
    from warpfluid.files.images import write_png

    flags = []
    for name, angle in (("front", 0), ("side", 90)):
        (folder / name).mkdir(exist_ok=True)
        for frame in range(1, frames + 1):
            write_png(folder / name / f"{frame:04d}.png", puffs(width, frame, angle))
        flags += [f"--{name}", str(folder / name)]
    return flags


def volume(folder: Path, width: int) -> str:
    """Write a cloud that fills a sixth of a box; return the name of its file."""
    import warpfluid as wf

    x, z, y = np.ogrid[-1 : 1 : 1j * width, -1 : 1 : 1j * width, -1 : 1 : 1j * width]
    lumps = 1 + 0.3 * (np.sin(17 * x + 2) * np.sin(13 * z) * np.sin(15 * y)).astype(np.float32)
    cloud = np.clip(1 - 1.4 * lumps * np.sqrt(x * x + z * z + y * y), 0, 1).astype(np.float32)
    wf.write_vdb(folder / "cloud.0001.vdb", {"density": cloud.transpose(0, 2, 1) * np.float32(400 / width)})
    return str(folder / "cloud.0001.vdb")


def command(kind: str, size: dict, folder: Path) -> list[str]:
    """Return the command line of a measurement, its input written."""
    width = size["width"]
    if kind.startswith("reconstruct"):
        views = footage(folder, width, size["frames"])
        alone = ["--coherence", "none", "--jobs", str(size["jobs"])] if "jobs" in size else []
        return ["reconstruct", *views, "--angles", str(size["angles"]), *RECONSTRUCT, *alone, "-o", str(folder / "run")]
    if kind.startswith("simulate"):
        box = ["--size", f"{width}x{width}", "--preset", "smoke", "--frames", "1-4", "--no-turntable", "--no-report"]
        return ["simulate", *box, "-o", str(folder / "run")]
    if kind.startswith("render"):
        picture = ["--look", "smoke", "--resolution", "{}x{}".format(*PICTURE)]
        return ["render", volume(folder, width), *picture, "-o", str(folder / "picture.png")]
    return ["export", volume(folder, width), "--format", "vdb", "-o", str(folder / "out")]
