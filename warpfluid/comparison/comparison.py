"""A whole comparison: frames spread over a sequence, means, and what they are measured against."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field

from warpfluid.comparison.entries import Entry
from warpfluid.comparison.measure import (
    ASIDE_DEG,
    Numbers,
    against_footage,
    against_truth,
    alone,
    as_given,
    aside,
    mean_numbers,
    unseen_angles,
    upright,
    views_of,
    with_left_over,
)
from warpfluid.comparison.motion import motion_against_footage, motion_against_truth
from warpfluid.footage.origin import Footage


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """What was measured.

    Attributes:
        against: ``truth``, ``footage`` or ``nothing``.
        frames: Frames that all have.
        measured: Those whose pictures were measured.
        given_deg: Angles of the views that the volumes were made of.
        unseen_deg: Angles that were scored.
        values: Means by name and metric, in the order of the table.
        floors: The names of values that are floors.
        yardstick: The floor that others are told as multiples of; None for none.
        edited: The names of those that are not meant to be the footage.
        notes: Sentences on what was decided.
    """

    against: str
    frames: tuple[int, ...]
    measured: tuple[int, ...]
    given_deg: tuple[float, ...]
    unseen_deg: tuple[float, ...]
    values: dict[str, Numbers]
    floors: tuple[str, ...] = ()
    yardstick: str | None = None
    edited: tuple[str, ...] = ()
    notes: tuple[str, ...] = field(default_factory=tuple)

    @property
    def ranks(self) -> bool:
        """Whether the nearest is the best: footage says nothing of how well it was edited."""
        return not (self.against == "footage" and self.edited)

    def to_dict(self) -> dict:
        """Return everything as plain numbers, strings, lists and dictionaries."""
        return asdict(self)


def compare_entries(
    entries: Sequence[Entry],
    frames: Sequence[int],
    measured: Sequence[int],
    *,
    truth: Entry | None = None,
    footage: Footage | None = None,
    unseen_deg: Sequence[float] | None = None,
    device=None,
    progress: Callable[[int], None] = lambda frame: None,
) -> Comparison:
    """Measure entries against the truth, or else against the footage.

    Args:
        entries: What is compared, of one size and in one unit.
        frames: Frames that all have.
        measured: Those whose pictures are measured; motion is measured between others, too.
        truth: The true volumes; they count before the footage.
        footage: What the first entry was made of.
        unseen_deg: Angles that are scored; by default all around, without those that were given.
        device: Where to compute.
        progress: Called with every frame that is measured.
    """
    given = footage.angles_deg if footage else entries[0].volumes.angles_deg
    unseen = tuple(unseen_deg or unseen_angles(given))
    found = []
    for frame in measured:
        progress(frame)
        found.append(_measure(entries, frame, frames, truth, footage, given, unseen, device))
    values = {**{entry.name: {} for entry in entries}, **mean_numbers(found)}
    values = with_left_over(values, _motion(entries, frames, truth, footage, unseen, device))
    floors = tuple(name for name in values if name not in {entry.name for entry in entries})
    yardstick = next((name for name in (aside(ASIDE_DEG[-1]), *floors) if name in floors), None)
    against = ("truth" if truth else "footage" if footage else "nothing") if floors else "nothing"
    return Comparison(
        against=against,
        frames=tuple(frames),
        measured=tuple(measured),
        given_deg=tuple(given),
        unseen_deg=unseen,
        values=values,
        floors=floors,
        yardstick=yardstick,
        edited=tuple(entry.name for entry in entries if entry.edited),
    )


def other_moment(frame: int, frames: Sequence[int]) -> int:
    """Return a frame that is far from another one: half of the sequence later, or earlier."""
    place = list(frames).index(frame)
    return frames[(place + len(frames) // 2) % len(frames)]


def _measure(entries, frame: int, frames, truth, footage, given, unseen, device) -> dict[str, Numbers]:
    """Measure one frame."""
    volumes = {entry.name: entry.volume(frame) for entry in entries}
    images = footage.images(frame) if footage else None
    shoulder = footage.shoulder if footage else 0.0
    found = {}
    if truth:
        true = truth.volume(frame)
        found = against_truth(volumes, true, given, unseen, device=device)
        seen, shoulder = (views_of(true, given, device=device), 0.0) if images is None else (upright(images), shoulder)
    elif images is not None:
        other = other_moment(frame, frames)
        far = footage.images(other) if other != frame else None
        facts = {"shoulder": shoulder, "other_frame": far, "device": device}
        found, seen = against_footage(volumes, images, given, unseen, **facts), upright(images)
    if not found:
        return alone(volumes, given)
    for name, volume in volumes.items():
        found[name] = as_given(volume, seen, given, shoulder=shoulder, device=device) | found[name]
    return found


def _motion(entries, frames, truth, footage, unseen, device) -> dict[str, float]:
    """Measure the motion of all entries."""
    volumes = {entry.name: entry.volume for entry in entries}
    if truth:
        return motion_against_truth(volumes, truth.volume, frames, unseen, device=device)
    if footage:
        facts = {"shoulder": footage.shoulder, "device": device}
        return motion_against_footage(volumes, footage.images, frames, unseen, **facts)
    return {}
