"""What a benchmark ran on, and how its times are taken."""

import contextlib
import datetime
import platform
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from statistics import median
from unittest import mock

import numpy as np

import warpfluid
from warpfluid.kernels.launch import thread_count


def describe(device) -> str:
    """Return the machine, the versions and the date in one line."""
    import warp as wp

    name = device.name if device.is_cuda else _processor()
    return (
        f"{name}, {thread_count()} CPU threads; warpfluid {warpfluid.__version__}, Warp {wp.__version__}, "
        f"NumPy {np.__version__}, Python {platform.python_version()}; {datetime.date.today()}"
    )


def seconds(job: Callable[[], object]) -> float:
    """Return how long a job takes, once."""
    begin = time.perf_counter()
    job()
    return time.perf_counter() - begin


def interleaved(jobs: dict[str, Callable[[], object]], repeats: int) -> dict[str, float]:
    """Return the median seconds of every job.

    The jobs take turns, so that other work on the machine hits all of them alike. Each runs once before.
    """
    for job in jobs.values():
        job()
    times = {name: [] for name in jobs}
    for _ in range(repeats):
        for name, job in jobs.items():
            times[name].append(seconds(job))
    return {name: median(taken) for name, taken in times.items()}


@contextlib.contextmanager
def timed_parts(device, parts: Iterable[tuple]) -> Iterator[dict[str, float]]:
    """Time the parts of the work within, by wrapping the functions that do it.

    Args:
        device: Waited for before and after each call.
        parts: Where each function is, its name, and the part it belongs to.
    """
    import warp as wp

    taken: dict[str, float] = defaultdict(float)

    def timed(part: str, function: Callable) -> Callable:
        def call(*arguments, **options):
            wp.synchronize_device(device)
            begin = time.perf_counter()
            result = function(*arguments, **options)
            wp.synchronize_device(device)
            taken[part] += time.perf_counter() - begin
            return result

        return call

    with contextlib.ExitStack() as patches:
        for owner, name, part in parts:
            patches.enter_context(mock.patch.object(owner, name, timed(part, getattr(owner, name))))
        yield taken


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(named, platform.processor() or platform.machine())
