"""How a command ends: the result to stdout, what failed to stderr, the exit code."""

import json
import sys
from collections.abc import Callable, Collection, Mapping

from warpfluid.errors import describe
from warpfluid.progress import Progress
from warpfluid.run import Run

TRY_AGAIN = "what is not named here is whole; the same command with --resume tries again"


def conclude(run: Run, frames: Collection[int], failed: dict[str, str], *, as_json: bool) -> int:
    """Print what a run came to; return the exit code.

    Args:
        run: It.
        frames: Which were asked for.
        failed: What went wrong, by what it happened to.
        as_json: Print one JSON document.
    """
    records = {frame: record for frame, record in run.records().items() if frame in frames}
    if as_json:
        print(json.dumps({"folder": str(run.folder), "frames": list(records.values()), "failed": failed}))
    else:
        print(f"{run.folder}: {len(records)} of {len(frames)} frames")
    return name_failures(failed, TRY_AGAIN)


def do_all(jobs: Mapping[str, Callable[[], object]], log: Progress) -> dict[str, str]:
    """Write files, each by a function of its own; return what failed, by the file's name."""
    failed = {}
    for name, job in jobs.items():
        log.line(f"write   {name}")
        try:
            job()
        except (ValueError, OSError) as error:
            failed[name] = describe(error)
            log.stack()
    return failed


def name_failures(failed: dict[str, str], way_out: str) -> int:
    """Say what failed and what to do; return the exit code."""
    for name, error in failed.items():
        print(f"error: {name}: {error}", file=sys.stderr)
    if failed:
        print(way_out, file=sys.stderr)
    return 1 if failed else 0
