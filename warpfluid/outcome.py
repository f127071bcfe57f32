"""How a command ends: the result to stdout, what failed to stderr, the exit code."""

import json
import sys
from collections.abc import Callable, Collection, Mapping

from warpfluid.errors import describe
from warpfluid.progress import Progress
from warpfluid.run import Run

TRY_AGAIN = "what is not named here is whole; the same command with --resume tries again"
EXACT = 150  # dB, above which nothing but the rounding of floats is left


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


def do_all(jobs: Mapping[str, Callable[[], object]], log: Progress, go_on: str) -> dict[str, str]:
    """Write what shows a run, each file by a function of its own; return what failed, by the file's name.

    Args:
        jobs: The functions, by the names of their files.
        log: Progress.
        go_on: Command that makes what is not there yet.

    Raises:
        KeyboardInterrupt: If it is stopped; it says how to go on.
    """
    failed, left = {}, list(jobs)
    for name, job in jobs.items():
        log.line(f"write   {name}")
        try:
            job()
            left.remove(name)
        except KeyboardInterrupt as stop:
            there = "stopped; the frames are there"
            raise KeyboardInterrupt(f"{there}; to make {' and '.join(left)}: {go_on}") from stop
        except (ValueError, OSError) as error:
            failed[name] = describe(error)
            log.stack()
    return failed


def exactness(decibels: Collection[float]) -> str:
    """Return in words how exactly a volume renders its views, by the worst of them [dB]."""
    worst = min(decibels)
    return "exact" if worst > EXACT else f"{worst:.1f} dB"


def name_failures(failed: dict[str, str], way_out: str) -> int:
    """Say what failed and what to do; return the exit code."""
    for name, error in failed.items():
        print(f"error: {name}: {error}", file=sys.stderr)
    if failed:
        print(way_out, file=sys.stderr)
    return 1 if failed else 0
