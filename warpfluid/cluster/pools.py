"""Choosing who works: this process, processes of this machine, or a Dask cluster."""

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from warpfluid.cluster.here import Here
from warpfluid.cluster.spread import Job, Pool
from warpfluid.cluster.workforce import PROCESS_BYTES, make_workforce
from warpfluid.device import compile_kernels, gpus
from warpfluid.options import MachineOptions
from warpfluid.options.machine import parse_jobs

if TYPE_CHECKING:
    from warpfluid.cluster.farm import Farm


@dataclass(frozen=True, kw_only=True)
class Asked:
    """Who is asked to work.

    Attributes:
        jobs: Number of processes, or ``auto``.
        device: As the command line names it; ``auto`` means every GPU there is.
        cluster: Address of a Dask scheduler, whose workers do it instead.
        farm: The cluster at that address, once it is reached.

    Raises:
        ValueError: If there can be no such workers.
    """

    jobs: str = "1"
    device: str = "auto"
    cluster: str | None = None
    farm: "Farm | None" = None

    def __post_init__(self):
        MachineOptions(jobs=self.jobs, device=self.device, cluster=self.cluster)

    @property
    def is_alone(self) -> bool:
        """Whether this process shall do all by itself."""
        return self.jobs == "1" and not self.cluster


@contextlib.contextmanager
def reach(asked: Asked, *, need: int, folder: Path, say: Callable[[str], None]) -> Iterator[Asked]:
    """Yield who is asked to work, once they are known to be there: nothing made earlier is touched before.

    Args:
        asked: Who shall work.
        need: Memory of a task [byte].
        folder: Where results will go.
        say: Called with what the user should know.

    Raises:
        ValueError: If there is no such cluster, or none of its workers can be used.
    """
    if not asked.cluster:
        yield asked
        return
    from warpfluid.cluster.farm import Farm

    need = PROCESS_BYTES + (0 if asked.device.startswith("cuda") else need)
    with Farm(asked.cluster, folder=folder, need=need, say=say) as farm:
        yield replace(asked, farm=farm)


def open_pool(
    job: Job,
    asked: Asked,
    device,
    *,
    tasks: int,
    need: int,
    progress: Callable[..., None],
    say: Callable[[str], None],
) -> Pool:
    """Return workers for a job, their kernels compiled.

    Args:
        job: What is done with a task.
        asked: Who shall work, reached.
        device: The Warp device that one worker would use.
        tasks: How many there are that can be done side by side.
        need: Memory of a task [byte].
        progress: Called as the jobs go.
        say: Called with what the user should know.
    """
    if asked.farm:
        from warpfluid.cluster.scheduler import Scheduler

        return Scheduler(job, asked.farm, asked.device, progress)
    jobs = parse_jobs(asked.jobs)
    if jobs == 1:
        return Here(job, device, progress)
    devices = tuple(gpus()) if device.is_cuda and asked.device == "auto" else (device,)
    cache = compile_kernels(devices) if tasks > 1 else ""
    workforce = make_workforce(jobs, devices, tasks=tasks, need=need, cache=cache)
    for note in workforce.notes:
        say(f"note    {note}")
    count = len(workforce.devices)
    if count == 1:
        return Here(job, device, progress)
    from warpfluid.cluster.processes import Processes

    places = ", ".join(dict.fromkeys(workforce.devices))
    say(f"workers {count} processes with {workforce.threads} threads each on {places}")
    return Processes(job, workforce, progress)
