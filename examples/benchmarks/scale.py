"""
Cost against size
=================

Seconds of all cores and peak memory of each command as its work grows: width, angles and frames of ``reconstruct``,
width of ``simulate``, ``render`` and ``export``; the exponent of a line through the logarithms; and beside it what
``inspect`` and the checks of memory expect. Each row is a process of its own, on footage of rising puffs made here, as
high as wide. Seconds of cores are fair where other work runs beside; on two quiet cores a run takes about half of
them. At most two iterations are made, four frames simulated, one picture rendered and one frame exported.

    python examples/benchmarks/scale.py [--quick] [--only reconstruct-width ...]
"""

import argparse
import contextlib
import json
import math
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from machine import describe
from scale_inputs import ITERATIONS, PICTURE, command

from warpfluid import cli

TABLES = {
    "reconstruct-width": ("width", (64, 96, 128, 192, 256, 384, 512), (64, 96, 128)),
    "reconstruct-angles": ("angles", (90, 180, 360, 720), (45, 90)),
    "reconstruct-frames": ("frames", (1, 4, 15, 60, 240), (1, 4)),
    "simulate-width": ("width", (64, 96, 128, 192, 256), (48, 64)),
    "render-width": ("width", (64, 128, 256, 384, 512), (48, 64)),
    "export-width": ("width", (64, 128, 256, 384, 512), (48, 64)),
}
WORKERS = "workers"
USUAL = {"width": 128, "angles": 180, "frames": 1}
FRAMES_WIDTH = 64  # of the table over frames
GIGABYTE = 1e9
LARGEST = 3  # sizes that tell how a cost grows


def expected(kind: str, line: list[str], size: dict) -> dict:
    """Return what warpfluid expects of a command: seconds on two cores, where it tells them, and bytes."""
    voxels = size["width"] ** 3
    if kind.startswith("simulate"):
        from warpfluid.options import SimulateOptions
        from warpfluid.simulation.need import bytes_needed

        smoke = SimulateOptions(swirl=1.0, turbulence_strength=1.0)
        return {"bytes": bytes_needed(voxels, smoke, followed=False, solids=False)}
    if kind.startswith("render"):
        from warpfluid.rendering import job

        return {"bytes": voxels * (job.BYTES_A_VOXEL + job.BYTES_A_FIELD) + math.prod(PICTURE) * job.BYTES_A_PIXEL}
    if kind.startswith("export"):
        from warpfluid.volumes.room import BYTES_A_NUMBER

        return {"bytes": voxels * BYTES_A_NUMBER}
    from warpfluid.footage.inspection import inspect_shot
    from warpfluid.footage.shot import open_shot
    from warpfluid.options import ReconstructOptions

    options = ReconstructOptions(iterations=ITERATIONS, angles=size["angles"])
    found = inspect_shot(open_shot([f"0={line[2]}", f"90={line[4]}"]), options)
    seconds = found.seconds_a_frame + (size["frames"] - 1) * found.seconds_a_carried_frame
    return {"seconds": seconds, "bytes": found.memory_bytes, "hull": found.hull_share}


def seconds_of_cores() -> float:
    """Return user and system time of this process and those that it waited for."""
    used = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(part.ru_utime + part.ru_stime for part in used)


def measure_here(kind: str, size: dict) -> dict:
    """Run one command in this process and return what it took, after a small one that loads what is needed."""
    with tempfile.TemporaryDirectory() as small, tempfile.TemporaryDirectory() as name:
        run(command(kind, USUAL | {"width": 32, "angles": 9, "frames": min(size["frames"], 2)}, Path(small)))
        line = command(kind, size, Path(name))
        base = forget_peak()
        begin, cores = time.perf_counter(), seconds_of_cores()
        run(line)
        taken = {"wall": time.perf_counter() - begin, "cores": seconds_of_cores() - cores}
        peak = _status("VmHWM")
        written = sum(path.stat().st_size for path in Path(name).rglob("density*.vdb"))
        return taken | {"bytes": peak - base, "written": written, "expected": expected(kind, line, size)}


def run(line: list[str]) -> None:
    """Run a command, its own words unsaid."""
    with open(os.devnull, "w") as nowhere, contextlib.redirect_stdout(nowhere):
        code = cli.main([*line, "--quiet", "--device", "cpu"])
    if code:
        raise SystemExit(f"{' '.join(line)} ended with {code}")


def measure(kind: str, size: dict) -> dict:
    """Run one command in a process of its own and return what it took."""
    line = [sys.executable, __file__, "--one", kind, json.dumps(size)]
    done = subprocess.run(line, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{kind} {size}: {done.stderr}")
    return json.loads(done.stdout.splitlines()[-1])


def exponent(sizes: list[int], values: list[float]) -> float:
    """Return the slope of a line through the logarithms of the largest sizes: small ones are mostly start."""
    return float(np.polyfit(np.log(sizes[-LARGEST:]), np.log(np.maximum(values[-LARGEST:], 1e-9)), 1)[0])


def report(kind: str, *, quick: bool) -> None:
    """Measure a table and print it."""
    varied, sizes, few = TABLES[kind]
    sizes = few if quick else sizes
    usual = USUAL | ({"width": FRAMES_WIDTH} if varied == "frames" else {})
    others = [f"{name} {usual[name]}" for name in usual if name != varied and kind.startswith("reconstruct")]
    print(f"\n{kind}" + (f": {', '.join(others)}" if others else ""))
    print(f"{varied:>8}  {'s of cores':>10}  {'s on clock':>10}  {'memory GB':>9}  expected: s of cores, memory GB")
    found = []
    for value in sizes:
        found.append(measure(kind, usual | {varied: value}))
        print(f"{value:8}  {_row(found[-1])}", flush=True)
    for name, key in (("seconds", "cores"), ("memory", "bytes")):
        print(f"{name} grow with the power {exponent(list(sizes), [row[key] for row in found]):.1f} of {varied}")


def _row(found: dict) -> str:
    """Return a measurement in words, with the ratios of what was expected to what was found."""
    text = f"{found['cores']:10.2f}  {found['wall']:10.2f}  {found['bytes'] / GIGABYTE:9.3f}"
    wanted = found["expected"]
    if "seconds" in wanted:
        text += f"  {2 * wanted['seconds']:8.2f} ({2 * wanted['seconds'] / found['cores']:.2f} x)"
    if "bytes" in wanted:
        text += f"  {wanted['bytes'] / GIGABYTE:8.3f} ({wanted['bytes'] / max(found['bytes'], 1):.2f} x)"
    return text


def report_workers(frames: int, width: int) -> None:
    """Print what frames side by side cost against one after the other, for each number of processes."""
    print(f"\n{frames} frames alone, {width} wide: {os.cpu_count()} cores, divided among the processes")
    print(f"{'processes':>9}  {'s of cores':>10}  {'s on clock':>10}  work of one over work of these")
    first = None
    for jobs in range(1, (os.cpu_count() or 1) + 1):
        found = measure("reconstruct-frames", USUAL | {"width": width, "frames": frames, "jobs": jobs})
        first = first or found
        ratio = first["cores"] / found["cores"]
        print(f"{jobs:9}  {found['cores']:10.2f}  {found['wall']:10.2f}  {ratio:.2f}", flush=True)


def forget_peak() -> int:
    """Let the kernel forget the most memory this process has held; return what it holds now [byte]. Linux only."""
    Path("/proc/self/clear_refs").write_text("5")
    return _status("VmRSS")


def _status(name: str) -> int:
    """Return a line of this process's state, which Linux counts in kB [byte]."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith(f"{name}:"))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--quick", action="store_true", help="small sizes only")
    parser.add_argument("--only", nargs="+", choices=[*TABLES, WORKERS], help="some of the tables")
    parser.add_argument("--one", nargs=2, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.one:
        print(json.dumps(measure_here(arguments.one[0], json.loads(arguments.one[1]))))
        return
    from warpfluid.device import pick_device

    print(describe(pick_device("cpu")))
    for kind in arguments.only or [*TABLES, WORKERS]:
        if kind == WORKERS:
            report_workers(*(2, 48) if arguments.quick else (12, 96))
        else:
            report(kind, quick=arguments.quick)


if __name__ == "__main__":
    main()
