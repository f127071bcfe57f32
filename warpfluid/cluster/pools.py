"""Choosing who works: this process, processes of this machine, or a Dask cluster."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from warpfluid.cluster.here import Here
from warpfluid.cluster.spread import Job, Pool
from warpfluid.cluster.workforce import make_workforce, parse_jobs
from warpfluid.device import compile_kernels, gpus


@dataclass(frozen=True, kw_only=True)
class Asked:
    """Who is asked to work.

    Attributes:
        jobs: Number of processes, or ``auto``.
        device: As the command line names it; ``auto`` means every GPU there is.
        cluster: Address of a Dask scheduler, whose workers do it instead.

    Raises:
        ValueError: If there can be no such workers.
    """

    jobs: str = "1"
    device: str = "auto"
    cluster: str | None = None

    def __post_init__(self):
        parse_jobs(self.jobs)
        if self.cluster and self.jobs != "1":
            raise ValueError("--jobs is for this machine and --cluster for others: choose one of them")

    @property
    def is_alone(self) -> bool:
        """Whether this process shall do all by itself."""
        return self.jobs == "1" and not self.cluster


def open_pool(
    job: Job,
    asked: Asked,
    device,
    *,
    tasks: int,
    need: int,
    folder: Path,
    progress: Callable[..., None],
    say: Callable[[str], None],
) -> Pool:
    """Return workers for a job, their kernels compiled.

    Args:
        job: What is done with a task.
        asked: Who shall work.
        device: The Warp device that one worker would use.
        tasks: How many there are that can be done side by side.
        need: Memory of a task [byte].
        folder: Where results go.
        progress: Called as the jobs go.
        say: Called with what the user should know.
    """
    if asked.cluster:
        from warpfluid.cluster.scheduler import Scheduler

        facts = {"device": asked.device, "folder": folder, "need": need, "progress": progress, "say": say}
        return Scheduler(job, asked.cluster, **facts)
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
