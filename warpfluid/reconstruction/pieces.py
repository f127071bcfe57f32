"""Which frame starts from which: a coherent shot is one chain, or pieces that overlap.

In a chain every frame waits for the one before. Cut into pieces, a shot spreads over many workers: a piece starts some
frames early, so that its volume is nearer to the other's when its own frames begin. Where it is cut depends on the
frames' numbers alone, never on the workers, or the volumes would.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass

from warpfluid.footage.shot import Shot
from warpfluid.options import ReconstructOptions

FARTHEST = 2  # pictures that a frame is carried over; across a wider gap motion cannot be measured


@dataclass(frozen=True)
class FrameTask:
    """A frame to reconstruct.

    Attributes:
        frame: Its number.
        before: The frame of the run that it starts from.
        lead: Frames that are made before it and not kept; the first one starts anew.
    """

    frame: int
    before: int | None = None
    lead: tuple[int, ...] = ()

    @property
    def origin(self) -> int | None:
        """The frame whose volume is carried on."""
        return self.lead[-1] if self.lead else self.before


@dataclass(frozen=True)
class Pieces:
    """How the frames of a shot hang together.

    Attributes:
        first: The first frame of the footage, from which pieces are counted.
        step: Frames from one picture to the next.
        length: Pictures of a piece; None for one that holds all.
        overlap: Pictures that a piece starts early.
        coherent: Whether frames build on each other at all.
    """

    first: int
    step: int
    length: int | None
    overlap: int
    coherent: bool

    def piece(self, frame: int) -> int:
        """Return the number of the piece that a frame belongs to."""
        return (frame - self.first) // (self.length * self.step) if self.length else 0

    def chains(self, frames: Iterable[int]) -> list[list[int]]:
        """Return the frames in groups that need not wait for each other."""
        groups: list[list[int]] = []
        for frame in sorted(frames):
            last = groups[-1][-1] if groups else None
            if last is not None and self.coherent and self._near(last, frame) and self.piece(last) == self.piece(frame):
                groups[-1].append(frame)
            else:
                groups.append([frame])
        return groups

    def task(self, frame: int, known: Collection[int], done: Collection[int]) -> FrameTask:
        """Return how a frame is to be made.

        Args:
            frame: Its number.
            known: Frames that the run has or will have.
            done: Those that it has.
        """
        if not self.coherent:
            return FrameTask(frame)
        earlier = sorted((number for number in known if number < frame), reverse=True)
        if not earlier or not self._near(earlier[0], frame):
            return FrameTask(frame)
        if self.piece(earlier[0]) == self.piece(frame):
            return FrameTask(frame, earlier[0] if earlier[0] in done else None)
        lead, later = [], frame
        for number in earlier[: self.overlap]:
            if not self._near(number, later):
                break
            lead.append(number)
            later = number
        return FrameTask(frame, lead=tuple(reversed(lead)))

    def to_make(self, frames: Collection[int], known: Collection[int], records: Mapping[int, dict]) -> list[int]:
        """Return which frames are missing or would be made otherwise now, provided that all succeed.

        Args:
            frames: Those that matter.
            known: Frames that the run has or will have.
            records: Of the frames that it has.
        """
        found, changed = [], set()
        for frame in sorted(known):
            task = self.task(frame, known, known)
            if frame in records and (task.before in changed or not is_made_so(task, records)):
                changed.add(frame)
            if frame in frames and (frame in changed or frame not in records):
                found.append(frame)
        return found

    def _near(self, one: int, other: int) -> bool:
        return other - one <= FARTHEST * self.step


def make_pieces(shot: Shot, options: ReconstructOptions) -> Pieces:
    """Return how the frames of a shot hang together under some options."""
    return Pieces(
        first=max(source.frames[0] for source in shot.sources),
        step=shot.step,
        length=options.piece,
        overlap=options.overlap,
        coherent=options.coherence == "flow" and options.method == "appearance-transfer",
    )


def is_made_so(task: FrameTask, records: Mapping[int, dict]) -> bool:
    """Return whether a frame that is there was made from what the task says, and that is still the same.

    Args:
        task: How it is made now.
        records: Of the frames that the run has.
    """
    record, before = records[task.frame], records.get(task.before)
    if record.get("before") != task.origin or record.get("lead") != list(task.lead):
        return False
    return before is None or record.get("origin") == before["volume"]


def frame_chain(
    pieces: Pieces,
    group: Iterable[int],
    frames: Collection[int],
    known: Collection[int],
    records: dict[int, dict],
    forget: Callable[[list[int]], None],
) -> Iterator[FrameTask]:
    """Yield the tasks of a chain, and be sent what came of each.

    A frame whose predecessor failed started anew, and stays when that one fails again. When it is made at last,
    all that build on it are made again.

    Args:
        pieces: How frames hang together.
        group: Frames that build on each other, rising; some of them may be there.
        frames: Those to make.
        known: Frames that the run has or will have.
        records: Of the frames that it has; what is made is added.
        forget: Called with frames that are there and will be made again.
    """
    for place, frame in enumerate(group):
        task = pieces.task(frame, known, records)
        if frame not in frames or (frame in records and is_made_so(task, records)):
            continue
        if frame in records:
            again = [number for number in _heirs(group[place:], records) if number in frames]
            forget(again)
            for number in again:
                del records[number]
        outcome = yield task
        if "error" not in outcome:
            records[frame] = outcome


def _heirs(group: list[int], records: Mapping[int, dict]) -> list[int]:
    """Return the first frame of a group, and those that are there and build on it or on such."""
    found = [group[0]]
    for frame in group[1:]:
        if frame in records and records[frame].get("before") == found[-1]:
            found.append(frame)
    return found
