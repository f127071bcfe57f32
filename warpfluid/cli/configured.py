"""What flags, the environment and a configuration file say together."""

from dataclasses import dataclass, replace
from pathlib import Path

from warpfluid.cli.flags import Common
from warpfluid.errors import Problems


@dataclass(frozen=True, kw_only=True)
class Configured:
    """What a command starts from.

    Attributes:
        document: What the configuration file says; empty without one.
        common: What most commands take, its device chosen.
        jobs: Number of processes, or ``auto``.
        cluster: Address of a Dask scheduler.
    """

    document: dict
    common: Common
    jobs: str
    cluster: str | None


def configure(
    common: Common, config: Path | None = None, *, jobs: str | None = None, cluster: str | None = None
) -> Configured:
    """Read the configuration file, and choose who computes: flags over the environment over the file.

    Args:
        common: What most commands take.
        config: A configuration file or ``run.toml``.
        jobs: The flag; None where not given.
        cluster: The same.

    Raises:
        ValueError: If anything is wrong; one line each.
    """
    from warpfluid.kernels.launch import thread_count
    from warpfluid.settings import make_machine, read_settings

    problems, given = Problems(), {"device": common.device, "jobs": jobs, "cluster": cluster}
    problems.attempt(thread_count)
    document = (problems.attempt(read_settings, config.expanduser()) if config else None) or {}
    machine = problems.attempt(make_machine, given, document)
    problems.raise_if_any()
    common = replace(common, device=machine.device)
    return Configured(document=document, common=common, jobs=str(machine.jobs), cluster=machine.cluster)
