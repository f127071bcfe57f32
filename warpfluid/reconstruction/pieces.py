"""Which frame starts from which: a coherent shot is one chain, or pieces that overlap.

In a chain every frame waits for the one before. Cut into pieces, a shot spreads over many workers: a piece starts some
frames early, so that its volume is nearer to the other's when its own frames begin. Where it is cut depends on the
frames' numbers alone, never on the workers, or the volumes would.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping
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
        if not self.coherent:
            return [[frame] for frame in sorted(frames)]
        groups: dict[int, list[int]] = {}
        for frame in sorted(frames):
            groups.setdefault(self.piece(frame), []).append(frame)
        return list(groups.values())

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

    def stale(self, frames: Iterable[int], known: Collection[int], records: Mapping[int, dict]) -> list[int]:
        """Return frames that are there and were not made as they would be now, and those that build on such.

        A frame whose predecessor failed started anew; when that one is made at last, all after it are made again.

        Args:
            frames: Those that matter.
            known: Frames that the run has or will have.
            records: Of the frames that it has.
        """
        found = []
        for frame in sorted(set(frames) & set(records)):
            if "before" not in records[frame]:
                continue
            task = self.task(frame, known, known)
            before = task.lead[-1] if task.lead else task.before
            if records[frame]["before"] != before or task.before in found:
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


def frame_chain(pieces: Pieces, frames: Iterable[int], known: Collection[int], done: set[int]) -> Iterator[FrameTask]:
    """Yield the tasks of a chain, and be sent what came of each.

    Args:
        pieces: How frames hang together.
        frames: To make, rising.
        known: Frames that the run has or will have.
        done: Those that it has; what is made is added.
    """
    for frame in frames:
        outcome = yield pieces.task(frame, known, done)
        if "error" not in outcome:
            done.add(frame)
