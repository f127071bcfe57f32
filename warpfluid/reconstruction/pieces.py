"""Which frame starts from which: a coherent shot is one chain, or pieces that fade into each other.

In a chain every frame waits for the one before. Cut into pieces, a shot spreads over many workers: a piece starts some
frames early. Over these the volumes of the piece before are drawn towards its own, more with every frame, so that what
no view sees does not jump where it begins. Where a shot is cut depends on the frames' numbers alone, never on the
workers, or the volumes would.
"""

from bisect import bisect_left
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
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
        towards: The lead of the next piece up to this frame, whose volume it is drawn to.
        weight: How far, 0-1.
    """

    frame: int
    before: int | None = None
    lead: tuple[int, ...] = ()
    towards: tuple[int, ...] = ()
    weight: float = 0.0

    def to_dict(self) -> dict:
        """Return what a record notes of it, to tell whether it would be made so again."""
        towards = {"towards": list(self.towards), "weight": self.weight} if self.towards else {}
        return {"before": self.lead[-1] if self.lead else self.before, "lead": list(self.lead), **towards}


@dataclass(frozen=True)
class Pieces:
    """How the frames of a shot hang together.

    Attributes:
        first: The frame from which pieces are counted; of a run, always the same.
        step: Frames from one picture to the next.
        length: Pictures of a piece; None for one that holds all.
        overlap: Pictures that a piece starts early, and over which the one before fades into it.
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

    def task(self, frame: int, known: Sequence[int], done: Collection[int]) -> FrameTask:
        """Return how a frame is to be made.

        Args:
            frame: Its number.
            known: Frames that the run has or will have, rising.
            done: Those that it has.
        """
        place = bisect_left(known, frame)
        before = known[place - 1] if place else None
        if not self.coherent or before is None or not self._near(before, frame):
            return FrameTask(frame)
        towards, weight = self._fade(frame, known)
        if self.piece(before) != self.piece(frame):
            lead = self._lead(frame, known)
            return FrameTask(frame, None, lead, towards, weight) if lead else FrameTask(frame)
        return FrameTask(frame, before, (), towards, weight) if before in done else FrameTask(frame)

    def _lead(self, frame: int, known: Sequence[int]) -> tuple[int, ...]:
        """Return the frames that lead up to the first frame of a piece."""
        place = begin = bisect_left(known, frame)
        while begin > max(place - self.overlap, 0) and self._near(known[begin - 1], known[begin]):
            begin -= 1
        return tuple(known[begin:place])

    def _fade(self, frame: int, known: Sequence[int]) -> tuple[tuple[int, ...], float]:
        """Return the lead of the next piece up to a frame, and how far the frame is drawn to its end.

        Frame after frame, weights of 1/(n + 1), 1/n, ... 1/2 make what is left of the own piece fall evenly.
        """
        if not self.length:
            return (), 0.0
        following = bisect_left(known, self.first + (self.piece(frame) + 1) * self.length * self.step)
        lead = self._lead(known[following], known) if following < len(known) else ()
        if frame not in lead:
            return (), 0.0
        place = lead.index(frame)
        return lead[: place + 1], 1 / (len(lead) - place + 1)

    def to_make(self, frames: Collection[int], known: Collection[int], records: Mapping[int, dict]) -> list[int]:
        """Return which frames are missing or would be made otherwise now, provided that all succeed.

        Args:
            frames: Those that matter.
            known: Frames that the run has or will have.
            records: Of the frames that it has.
        """
        found, changed, rising = [], set(), sorted(known)
        for frame in rising:
            task = self.task(frame, rising, known)
            noted = "lead" in records.get(frame, {})
            if noted and (task.before in changed or not is_made_so(task, records)):
                changed.add(frame)
            if frame in frames and (frame in changed or frame not in records):
                found.append(frame)
        return found

    def _near(self, one: int, other: int) -> bool:
        return other - one <= FARTHEST * self.step


def make_pieces(shot: Shot, options: ReconstructOptions, first: int | None = None) -> Pieces:
    """Return how the frames of a shot hang together under some options.

    Args:
        shot: The footage.
        options: The method.
        first: From where pieces of the run were counted when it began; by default its footage begins now.
    """
    return Pieces(
        first=first_picture(shot) if first is None else first,
        step=shot.step,
        length=options.piece,
        overlap=options.overlap,
        coherent=options.coherence == "flow" and options.method == "appearance-transfer",
    )


def first_picture(shot: Shot) -> int:
    """Return the first frame that every view has a picture of, whether it is asked for or not."""
    return max(source.frames[0] for source in shot.sources)


def keep_lasting(records: Mapping[int, dict], frames: Collection[int]) -> dict[int, dict]:
    """Return records by which no frame is made again that cannot be made as it was.

    What such a frame was made from is taken out of its record: it stays, and others may start from it.

    Args:
        records: Of the frames that the run has.
        frames: Those that still have their pictures.
    """
    made_from = ("before", "lead", "towards", "weight")
    kept = {}
    for frame, record in records.items():
        from_frames = {record.get("before"), *record.get("lead", ()), *record.get("towards", ())} - {None}
        lasts = from_frames <= set(frames)
        kept[frame] = record if lasts else {key: value for key, value in record.items() if key not in made_from}
    return kept


def is_made_so(task: FrameTask, records: Mapping[int, dict]) -> bool:
    """Return whether a frame that is there was made from what the task says, and that is still the same.

    Args:
        task: How it is made now.
        records: Of the frames that the run has.
    """
    record, before = records[task.frame], records.get(task.before, {})
    if "lead" not in record:  # of a run that began before this was noted, or see ``keep_lasting``
        return True
    noted = {name: record[name] for name in ("before", "lead", "towards", "weight") if name in record}
    return noted == task.to_dict() and record.get("origin") == before.get("volume", record.get("origin"))


def frame_chain(
    pieces: Pieces,
    group: Iterable[int],
    frames: Collection[int],
    known: Sequence[int],
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
        known: Frames that the run has or will have, rising.
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
