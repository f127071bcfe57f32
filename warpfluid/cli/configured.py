"""What flags, the environment and a configuration file say together, and one refusal for all that is wrong with it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
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
        problems: What is wrong so far.
    """

    document: dict
    common: Common
    jobs: str = "1"
    cluster: str | None = None
    problems: Problems = field(default_factory=Problems)

    @property
    def who(self) -> dict:
        """Who computes, for commands that may spread."""
        return {"common": self.common, "jobs": self.jobs, "cluster": self.cluster}

    def options(self, kind: type, section: str, flags):
        """Return options of a table of the file and of flags; None, and the problem noted, if they are wrong."""
        from warpfluid.settings import make_options

        return self.problems.attempt(make_options, kind, self.document.get(section, {}), flags)

    def refuse(self, *checks: Callable[[], object]) -> None:
        """If anything is wrong, look for what else is, and refuse all of it.

        Args:
            checks: Called only then; each raises what it finds.

        Raises:
            ValueError: If anything is wrong; one line each.
        """
        if self.problems:
            for check in (*checks, partial(_check_device, self.common.device)):
                self.problems.attempt(check)
        self.problems.raise_if_any()


def configure(
    common: Common, config: Path | None = None, *, jobs: str | None = None, cluster: str | None = None
) -> Configured:
    """Read the configuration file, and choose who computes: flags over the environment over the file.

    Args:
        common: What most commands take.
        config: A configuration file or ``run.toml``.
        jobs: The flag; None where not given.
        cluster: The same.
    """
    from warpfluid.kernels.launch import thread_count
    from warpfluid.settings import make_machine, read_settings

    problems, given = Problems(), {"device": common.device, "jobs": jobs, "cluster": cluster}
    problems.attempt(thread_count)
    document = (problems.attempt(read_settings, config.expanduser()) if config else None) or {}
    machine = problems.attempt(make_machine, given, document)
    chosen = Configured(document=document, common=common, problems=problems)
    if machine is None:
        return chosen
    common = replace(common, device=machine.device)
    return replace(chosen, common=common, jobs=str(machine.jobs), cluster=machine.cluster)


def check_volumes(*names: str | None) -> None:
    """Refuse volumes that there are not."""
    from warpfluid.volumes import open_volumes

    problems = Problems()
    for name in names:
        if name is not None:
            problems.attempt(open_volumes, name)
    problems.raise_if_any()


def check_views(views: Sequence[str]) -> None:
    """Refuse footage that there is not."""
    from warpfluid.files.footage import open_footage
    from warpfluid.footage.sources import parse_view

    problems = Problems()
    for view in views:
        angle, path = problems.attempt(parse_view, view) or (0.0, None)
        if path is not None:
            problems.attempt(open_footage, path, where=f"view {angle:g}: ")
    problems.raise_if_any()


def check_run(out: Path | None, *, resume: bool, overwrite: bool) -> None:
    """Refuse a folder that can take no run."""
    from warpfluid.run import Run

    if out is None:
        raise ValueError("no folder is given for the run: add -o FOLDER; a ; before it needs quotes, '1:0;48:90'")
    Run(out).check_free(resume=resume, overwrite=overwrite)


def _check_device(name: str | None) -> None:
    """Refuse a device that there is not."""
    from warpfluid.device import pick_device

    pick_device(name)
