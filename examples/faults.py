"""
Runs that are killed, again and again
=====================================

Two processes reconstruct 24 tiny frames. At random moments a worker, or the whole run, gets ``kill -9``; a run that is
gone is continued. However often that happens, no frame that counts as finished may be half, and the volumes in the end
must be those of a run that was left alone, bit for bit. It needs Linux: ``python examples/faults.py 50``.
With ``--disk``, as root, it fills a file system of a few megabytes instead, makes room, and goes on.
"""

# %%
# The footage: two blobs of light that move.

import contextlib
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from warpfluid.files.images import write_png
from warpfluid.run import Run

FRAMES, WIDTH, HEIGHT = range(1, 25), 24, 36
QUICK = {"iterations": 2, "angles": 12, "cg-steps": 2, "lsm-steps": 2, "device": "cpu", "piece": 6, "overlap": 2}
METHOD = [word for name, value in QUICK.items() for word in (f"--{name}", str(value))]
BARE = ["--no-turntable", "--no-report", "--quiet"]


def draw(folder: Path) -> list[str]:
    """Write the footage of two views; return the flags that name them."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    for name, angle in (("front", 0), ("side", 1)):
        (folder / name).mkdir()
        for frame in FRAMES:
            u = WIDTH * (0.5 + 0.15 * np.sin(0.3 * frame + angle))
            light = 200 * np.exp(-((columns - u) ** 2 + (rows - HEIGHT / 2) ** 2) / 20)
            write_png(folder / name / f"{frame:04d}.png", np.where(light > 3, light, 0).astype(np.uint8))
    return ["--front", str(folder / "front"), "--side", str(folder / "side")]


# %%
# A run is started, or continued if it has begun.


def start(folder: Path, views: list[str], jobs: int = 2) -> subprocess.Popen:
    """Start a run, or continue it."""
    words = [*views, *METHOD, *BARE, "-o", str(folder), "--jobs", str(jobs), "--resume"]
    return subprocess.Popen([sys.executable, "-m", "warpfluid", "reconstruct", *words], stdout=subprocess.DEVNULL)


def volumes(folder: Path) -> dict[str, bytes]:
    """Return the volumes of a run, byte for byte."""
    return {path.name: path.read_bytes() for path in sorted(folder.glob("*.vdb"))}


def workers(run: subprocess.Popen) -> list[int]:
    """Return the process ids of a run's workers."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, parent = path.read_text().rsplit(")", 1)[1].split()[:2]
            if int(parent) == run.pid and state != "Z" and b"spawn_main" in (path.parent / "cmdline").read_bytes():
                found.append(int(path.parent.name))
    return found


def kill_once(run: subprocess.Popen, chance: random.Random) -> str:
    """Kill a worker or the run, at a moment that nobody chose; say which."""
    time.sleep(chance.expovariate(0.7))
    victims = workers(run)
    if run.poll() is not None or not victims:
        return ""
    if chance.random() < 0.4:
        run.kill()
        run.wait()
        return "run"
    with contextlib.suppress(ProcessLookupError):
        os.kill(chance.choice(victims), signal.SIGKILL)
        return "worker"
    return ""


# %%
# Kill until the number is reached; whenever a run ends, compare it, and begin another one.


def check(folder: Path, whole: dict[str, bytes]) -> None:
    """Compare a run that has ended with one that was left alone."""
    if volumes(folder) != whole or list(Run(folder).records()) != list(FRAMES):
        raise SystemExit(f"{folder} differs")


def kill_many(folder: Path, views: list[str], whole: dict[str, bytes], count: int, chance: random.Random) -> None:
    """Kill workers and runs, and check what comes of it."""
    kills = {"run": 0, "worker": 0}
    ended, begin = 0, time.perf_counter()
    run = start(folder / "0", views)
    while sum(kills.values()) < count or run.poll() is None:
        if run.poll() is not None:
            if run.returncode == 0:
                check(folder / str(ended), whole)
                ended += 1
            elif run.returncode != -signal.SIGKILL:
                print(f"a run gave up with exit code {run.returncode}; it is continued")
            run = start(folder / str(ended), views)
        if sum(kills.values()) < count:
            victim = kill_once(run, chance)
            kills |= {victim: kills[victim] + 1} if victim else {}
        else:
            run.wait()
        there = Run(folder / str(ended))
        if not all(there.is_whole(frame) for frame in there.records()):
            raise SystemExit("half a frame counts as whole")
    while start(folder / str(ended), views).wait() != 0:
        pass
    check(folder / str(ended), whole)
    seconds = time.perf_counter() - begin
    print(
        f"{kills['worker']} workers and {kills['run']} runs killed, {ended + 1} runs of the right bits, {seconds:.0f} s"
    )


# %%
# A file system that fills up: the run must end by itself, and go on when there is room.


def fill_disk(folder: Path, views: list[str], whole: dict[str, bytes]) -> None:
    """Run on a file system that is too small, make room, and go on."""
    disk = folder / "disk"
    disk.mkdir()
    room = sum(map(len, whole.values())) // 2
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={room + (1 << 20)}", "none", disk], check=True)
    try:
        (disk / "other").write_bytes(bytes(1 << 20))
        code, made = start(disk / "run", views).wait(), len(Run(disk / "run").records())
        (disk / "other").unlink()
        print(f"disk full after {made} of {len(FRAMES)} frames, exit code {code}")
        if code != 1 or start(disk / "run", views).wait() != 0:
            raise SystemExit("it did not end and go on as it should")
        check(disk / "run", whole)
    finally:
        subprocess.run(["umount", disk], check=True)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        footage = draw(Path(place))
        start(Path(place) / "alone", footage, jobs=1).wait()
        alone = volumes(Path(place) / "alone")
        if "--disk" in sys.argv:
            fill_disk(Path(place), footage, alone)
        else:
            kill_many(Path(place), footage, alone, int(sys.argv[1]) if sys.argv[1:] else 50, random.Random(1))
