"""How much memory there is, and what is too large for it."""

import contextlib
import math
import os
from collections.abc import Callable, Iterator
from pathlib import Path

GIGABYTE = 1e9
Size = tuple[int, ...]


def check_memory(bytes_of: Callable[[Size], float], size: Size, device=None, *, what: str, way_out: str) -> None:
    """Refuse work that there is no memory for, before any is done.

    Args:
        bytes_of: Returns the memory that the work takes at a size [byte]; it grows with the size.
        size: That is asked for, the width first [voxel or pixel].
        device: Where it will run, a Warp device; this machine when omitted.
        what: What needs the memory, in the plural.
        way_out: What to do, with ``{width}``, ``{size}`` or ``{scale}`` for the largest that fits.

    Raises:
        ValueError: If the memory does not suffice.
    """
    there = device.total_memory if device is not None and device.is_cuda else memory_limit()
    needed = bytes_of(size)
    if needed <= there:
        return
    place = "this machine" if device is None else device
    found = f"{what} need about {needed / GIGABYTE:.2g} GB of memory, {place} has {there / GIGABYTE:.2g} GB"
    fits = largest_size(bytes_of, size, there)
    if fits is None:
        raise ValueError(f"{found}: use a larger machine")
    scale = math.floor(1000 * fits[0] / size[0]) / 1000
    raise ValueError(f"{found}: {way_out.format(width=fits[0], size='x'.join(map(str, fits)), scale=scale)}")


def largest_size(bytes_of: Callable[[Size], float], size: Size, there: float) -> Size | None:
    """Return the largest size of the same proportions below one that is too large, None if there is none.

    Args:
        bytes_of: Returns the memory that work takes at a size [byte].
        size: One that is too large, the width first.
        there: Memory there is [byte].
    """

    def narrowed(width: int) -> Size:
        return width, *(max(1, round(width * n / size[0])) for n in size[1:])

    fits, too_large = 0, size[0]
    while too_large - fits > 1:
        middle = (fits + too_large) // 2
        fits, too_large = (middle, too_large) if bytes_of(narrowed(middle)) <= there else (fits, middle)
    return narrowed(fits) if fits else None


def machine_memory() -> float:
    """Return the memory of this machine [byte], without a limit where nothing tells."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, OSError, ValueError):  # not on Windows
        return float("inf")


def memory_limit() -> float:
    """Return the most memory that this process may ever take, by the machine, its control groups and ulimit [byte]."""
    limit = machine_memory()
    for group in _groups():
        with contextlib.suppress(OSError, ValueError):  # "max", or no such group
            limit = min(limit, float((group / "memory.max").read_text()))
    with contextlib.suppress(ImportError, OSError, ValueError):  # not on Windows
        import resource

        limits = (resource.getrlimit(kind)[0] for kind in (resource.RLIMIT_AS, resource.RLIMIT_DATA))
        limit = min([limit, *(float(bound) for bound in limits if bound != resource.RLIM_INFINITY)])
    return limit


def free_memory() -> float:
    """Return the memory that is free on this machine and within the limits of its control groups [byte]."""
    free = machine_memory()
    with contextlib.suppress(OSError, ValueError, IndexError, StopIteration):
        lines = Path("/proc/meminfo").read_text("ascii").splitlines()
        free = float(next(line.split()[1] for line in lines if line.startswith("MemAvailable:"))) * 1024
    return min([free, *map(_left, _groups())])


def _groups() -> Iterator[Path]:
    """Yield the control groups that this process is in, from the innermost."""
    try:
        own = Path("/proc/self/cgroup").read_text().splitlines()[-1].split(":", 2)[2].strip("/")
    except (OSError, IndexError):
        return
    for group in (Path(own), *Path(own).parents):
        yield Path("/sys/fs/cgroup") / group


def _left(group: Path) -> float:
    """Return what a control group may still take [byte]; files that are kept in memory make room."""
    try:
        limit = float((group / "memory.max").read_text())
        stat = dict(line.split() for line in (group / "memory.stat").read_text().splitlines())
        return limit - float((group / "memory.current").read_text()) + float(stat.get("inactive_file", 0))
    except (OSError, ValueError):  # "max", or no such group
        return float("inf")
