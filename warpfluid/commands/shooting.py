"""The pictures of ``warpfluid render``, made by one process or many, and written down as they come."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from warpfluid.cluster.pools import Asked, open_pool
from warpfluid.cluster.spread import Pool, single, spread
from warpfluid.errors import CannotWriteError, describe
from warpfluid.progress import Progress
from warpfluid.rendering.job import PictureJob
from warpfluid.rendering.records import PictureRecords
from warpfluid.rendering.shots import Shot


@dataclass(frozen=True, kw_only=True)
class Work:
    """Everything that takes part.

    Attributes:
        job: Makes the pictures.
        shots: All of them.
        log: Progress.
        records: What numbered pictures were made with.
        hashes: Of the volumes by frame, for the records.
        failed: What went wrong, by picture.
        made: What was written, a record each.
    """

    job: PictureJob
    shots: list[Shot]
    log: Progress
    records: PictureRecords | None = None
    hashes: dict[str, str] = field(default_factory=dict)
    failed: dict[str, str] = field(default_factory=dict)
    made: list[dict] = field(default_factory=list)


def shoot(work: Work, shots: list[Shot], crew: Asked, device, need: int) -> None:
    """Make pictures; what fails is noted.

    Args:
        work: What takes part.
        shots: The pictures to make.
        crew: Who shall do it, reached.
        device: The Warp device that one worker would use.
        need: Memory of a picture [byte].

    Raises:
        KeyboardInterrupt: If it is stopped; it says how to go on.
    """
    job, say = work.job, work.log.line
    try:
        with open_pool(job, crew, device, tasks=len(shots), need=need, progress=_nothing, say=say) as pool:
            (_film if job.target.is_film else _stills)(work, shots, pool)
    except KeyboardInterrupt as stop:
        way_out = "; the same command with --resume goes on" if job.target.is_numbered else ""
        raise KeyboardInterrupt(f"stopped after {len(work.made)} of {len(shots)} pictures{way_out}") from stop


def _nothing(*_) -> None:
    """A picture tells nothing before it is made."""


def _stills(work: Work, shots: list[Shot], pool: Pool) -> None:
    """Write a file a picture."""
    count = 0
    try:
        for shot, outcome in spread(map(single, shots), pool):
            count += 1
            if _note(work, shot, outcome) and work.records:
                work.records.add(outcome, work.hashes)
    except CannotWriteError as error:
        work.failed[work.records.path.name] = describe(error)
    except ConnectionError as error:
        work.failed["the cluster"] = describe(error)
    if count < len(shots):
        work.failed["the other pictures"] = "not made"


def _film(work: Work, shots: list[Shot], pool: Pool) -> None:
    """Write all pictures into one file."""
    target, studio = work.job.target, work.job.studio
    try:
        target.film(_in_order(work, shots, pool), studio.options.fps or studio.rate)
    except (ValueError, OSError) as error:
        work.failed[str(target.path)] = describe(error)
        work.made.clear()


def _in_order(work: Work, shots: list[Shot], pool: Pool) -> Iterator[np.ndarray]:
    """Yield the pictures of a film one after the other, in whatever order they are made."""
    there, place = {}, 0
    try:
        for shot, outcome in spread(map(single, shots), pool):
            there[shot.number] = outcome.pop("screen", None)
            _note(work, shot, outcome)
            while place < len(shots) and shots[place].number in there:
                screen = there.pop(shots[place].number)
                place += 1
                if screen is not None:
                    yield screen
    except ConnectionError as error:
        work.failed["the cluster"] = describe(error)
        raise ValueError("not made") from error
    if not work.made:
        raise ValueError("none of its pictures could be made")


def _note(work: Work, shot: Shot, outcome: dict) -> bool:
    """Record what came of a picture, and say it; return whether it is made."""
    if "error" in outcome:
        work.failed[f"picture {shot.number}"] = outcome["error"]
        work.log.stack(outcome.get("stack"))
        return False
    work.made.append(outcome)
    work.log.line(f"picture {shot.number}  frame {shot.frame}, {outcome['seconds']:.1f} s, {outcome['file']}")
    return True
