"""How the footage of a view is brought in line with the others: when it plays, where, how large, how bright."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields, replace

from warpfluid.options import InputOptions

SAME_ANGLE_DEG = 1e-3
RANGES = {"time": (-1e6, 1e6), "shift": (-1e5, 1e5), "scale": (0.5, 2.0), "gain": (0.01, 100.0)}


@dataclass(frozen=True, kw_only=True)
class Alignment:
    """What is done to a view before anything is made of it; the files stay as they are.

    Attributes:
        time: It plays later by this [frame].
        shift: Its pictures move up by this [pixel of the footage].
        scale: They are drawn this much larger, about their middle.
        gain: Their light is multiplied by this.
    """

    time: float = 0.0
    shift: float = 0.0
    scale: float = 1.0
    gain: float = 1.0

    def sentence(self) -> str:
        """Return it in words: 3 frames later, 2 pixels up, x 1.02 in size, x 1.25 in light."""
        parts = []
        if self.time:
            parts.append(f"{count_of(self.time, 'frame')} {'later' if self.time > 0 else 'earlier'}")
        if self.shift:
            parts.append(f"{count_of(self.shift, 'pixel')} {'up' if self.shift > 0 else 'down'}")
        if self.scale != 1:
            parts.append(f"x {self.scale:g} in size")
        if self.gain != 1:
            parts.append(f"x {self.gain:g} in light")
        return ", ".join(parts) or "as it is"


@dataclass(frozen=True, kw_only=True)
class ViewAlignment:
    """The alignment of a view, and what a search found of it.

    Attributes:
        angle_deg: The view.
        reference_deg: The view that it is compared with.
        alignment: What is done.
        disagreement: Rms of the difference of the row sums over their rms as they were; None if nothing was searched.
        disagreement_after: The same behind the alignment.
        correlation: Of the row sums behind it.
    """

    angle_deg: float
    reference_deg: float
    alignment: Alignment
    disagreement: float | None = None
    disagreement_after: float | None = None
    correlation: float | None = None

    def line(self) -> str:
        """Return a summary in plain text."""
        text = f"view {self.angle_deg:g}: {self.alignment.sentence()}"
        if self.disagreement is None:
            return text
        return (
            f"{text}; rows {self.disagreement:.1%} apart from view {self.reference_deg:g} before, "
            f"{self.disagreement_after:.1%} after, correlation {self.correlation:.3f}"
        )


def given_numbers(options: InputOptions, angles_deg: Sequence[float]) -> list[dict[str, float]]:
    """Return what is given by hand for every view, by the names of ``Alignment``.

    Args:
        options: Their ``view_time``, ``view_shift``, ``view_scale`` and ``view_gain`` count.
        angles_deg: One a view.

    Raises:
        ValueError: If a text is wrong, or names a view that is not there; one line each.
    """
    found, problems = [{} for _ in angles_deg], []
    for name in RANGES:
        text = getattr(options, f"view_{name}") or ""
        for item in filter(None, map(str.strip, text.split(","))):
            try:
                angle, number = _parse(name, item)
                found[_view_at(angle, angles_deg, name)][name] = number
            except ValueError as error:
                problems.append(str(error))
    if problems:
        raise ValueError("\n".join(problems))
    return found


def with_numbers(
    options: InputOptions, angles_deg: Sequence[float], numbers: Sequence[dict[str, float]]
) -> InputOptions:
    """Return options that give numbers by hand and search for nothing; the opposite of ``given_numbers``."""
    texts = {}
    for field in fields(Alignment):
        pairs = [(a, n[field.name]) for a, n in zip(angles_deg, numbers, strict=True) if field.name in n]
        texts[f"view_{field.name}"] = ",".join(f"{a:.15g}={number:.15g}" for a, number in pairs) or None
    return replace(options, align="none", **texts)


def flags(found: Sequence[ViewAlignment]) -> str:
    """Return the flags that give by hand what a search found."""
    numbers = [asdict(view.alignment) for view in found]
    options = with_numbers(InputOptions(), [view.angle_deg for view in found], numbers)
    return " ".join(f"--view-{name} {getattr(options, f'view_{name}')}" for name in RANGES)


def _parse(name: str, item: str) -> tuple[float, float]:
    """Return angle and number of ``ANGLE=NUMBER``."""
    angle, _, number = item.partition("=")
    try:
        angle_deg, value = float(angle), float(number)
    except ValueError:
        raise ValueError(
            f"--view-{name} {item!r} is not ANGLE=NUMBER, such as 90=1.5, or 90=1.5,-60=1.2 for two views"
        ) from None
    low, high = RANGES[name]
    if not (math.isfinite(value) and low <= value <= high):
        raise ValueError(f"--view-{name} {item} is out of range, expected {low:g} to {high:g}")
    return angle_deg, value


def _view_at(angle_deg: float, angles_deg: Sequence[float], name: str) -> int:
    """Return which view has an angle."""
    for index, angle in enumerate(angles_deg):
        if abs(angle - angle_deg) < SAME_ANGLE_DEG:
            return index
    there = " and ".join(f"{angle:g}" for angle in angles_deg)
    raise ValueError(f"--view-{name} names view {angle_deg:g}, which is not there: the views are {there}")


def count_of(number: float, noun: str) -> str:
    """Return how many of a thing, whatever the direction: 1 frame, 2.3 pixels."""
    return f"{abs(number):g} {noun}{'s' * (abs(number) != 1)}"
