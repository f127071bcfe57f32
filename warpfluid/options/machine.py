"""Who computes: a device, processes, or other machines."""

from dataclasses import dataclass
from typing import Annotated

from warpfluid.options.checks import check_options

AUTO = "auto"
MANY = 1024  # processes
VARIABLES = {
    "device": "WARPFLUID_DEVICE",
    "jobs": "WARPFLUID_JOBS",
    "cluster": "WARPFLUID_CLUSTER",
}  # of the environment


@dataclass(frozen=True, kw_only=True)
class MachineOptions:
    """Who computes; the result is the same."""

    device: Annotated[str, "cpu, cuda:N, or auto: the first GPU if there is one"] = AUTO
    jobs: Annotated[int | str, "Processes that work side by side: a number, or auto for one a core or a GPU"] = 1
    cluster: Annotated[str | None, "Let the workers of this Dask scheduler work, such as tcp://host:8786"] = None

    def __post_init__(self):
        check_options(self)
        parse_jobs(self.jobs)
        if self.cluster and str(self.jobs) != "1":
            raise ValueError("--jobs is for this machine and --cluster for others: choose one of them")


def parse_jobs(jobs: int | str) -> int | None:
    """Return a number of processes, None for as many as suit the machine.

    Raises:
        ValueError: If it is none.
    """
    if jobs == AUTO:
        return None
    text = "" if isinstance(jobs, bool) else str(jobs)
    if not (text.isascii() and text.isdigit() and 0 < int(text) <= MANY):
        raise ValueError(f"jobs is {jobs!r}, expected a number of processes from 1, or auto")
    return int(text)
