"""How many workers this machine can bear, where each computes, and with how many threads."""

from collections.abc import Callable
from dataclasses import dataclass

from warpfluid.kernels.launch import thread_count
from warpfluid.memory import free_memory

PROCESS_BYTES = 400 << 20  # a worker with its libraries and kernels, before it has any work


@dataclass(frozen=True, kw_only=True)
class Workforce:
    """Workers of one machine.

    Attributes:
        devices: Where each worker computes.
        threads: That each worker may use.
        cache: Folder of compiled kernels.
        notes: Sentences on why there are fewer workers than asked for.
    """

    devices: tuple[str, ...]
    threads: int
    cache: str = ""
    notes: tuple[str, ...] = ()


def make_workforce(
    jobs: int | None,
    devices: tuple,
    *,
    tasks: int,
    need: int,
    cache: str = "",
    free: Callable[[], float] = free_memory,
) -> Workforce:
    """Return workers that neither oversubscribe the cores nor the memory.

    Args:
        jobs: How many are asked for; None for one a core, or one a GPU.
        devices: Warp devices that they may share, all of one kind.
        tasks: How many there are that can be done side by side.
        need: Memory of a task [byte].
        cache: Folder of compiled kernels.
        free: Returns the memory that is free on the machine [byte].
    """
    cores, notes = thread_count(), []
    on_gpu = devices[0].is_cuda
    count = jobs or (len(set(_places(devices, len(devices), need))) if on_gpu else cores)
    if count > cores:
        notes.append(f"{count} processes are more than the {cores} cores: {cores} at once")
        count = cores
    if count > tasks:
        if jobs and tasks > 1:
            notes.append(f"no more than {tasks} of {count} processes find work at a time")
        count = max(tasks, 1)
    places = _places(devices, count, need)
    fit = min(len(places), max(int(free() // (PROCESS_BYTES + (0 if on_gpu else need))), 1))
    if count > fit:
        gigabytes = f"{(need + PROCESS_BYTES) / 1e9:.2g} GB"
        notes.append(f"{count} frames at once need {gigabytes} each, more than is free: {fit} at once")
    return Workforce(devices=places[:fit], threads=max(1, cores // fit), cache=cache, notes=tuple(notes))


def _places(devices: tuple, count: int, need: int) -> tuple[str, ...]:
    """Return where workers compute: GPU after GPU, as long as each has room for another task; one at least."""
    if not devices[0].is_cuda:
        return (str(devices[0]),) * count
    room = {str(device): int(device.free_memory // max(need, 1)) for device in devices}
    rounds = [name for turn in range(min(count, max(room.values()))) for name, tasks in room.items() if tasks > turn]
    return tuple(rounds[:count]) or (str(max(devices, key=lambda device: device.free_memory)),)
