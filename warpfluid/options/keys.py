"""Numbers that may change: over the frames, or over the fluid.

``6`` is constant, ``1:6;50:2.5`` is 6 at frame 1 and falls to 2.5 at frame 50, and ``density 0:0;1:4`` is 0 where there
is nothing and rises to 4 at full density.
"""

import math

import numpy as np

FIELDS = ("density", "temperature", "speed")  # full density is 1; units a second


class Keyed:
    """A number or a vector, constant or keyed over frames.

    Args:
        value: A number; or text: a number, ``x,y,z`` for a vector, or keys ``FRAME:VALUE`` separated by semicolons.
        size: 1 for a number, 3 for a vector.

    Raises:
        ValueError: If the text is none of these.
    """

    def __init__(self, value: float | str, size: int = 1):
        keys = [value] if isinstance(value, int | float) else str(value).split(";")
        pairs = [_split(str(key), first=len(keys) == 1) for key in keys]
        self.frames = np.array([frame for frame, _ in pairs])
        self.values = np.array([_numbers(text, size) for _, text in pairs])
        if (np.diff(self.frames) <= 0).any():
            raise ValueError("the frames of its keys must rise")

    def at(self, frame: float) -> float | np.ndarray:
        """Return the value at a frame: linear between keys, constant before the first and after the last."""
        found = np.array([np.interp(frame, self.frames, column) for column in self.values.T])
        return float(found[0]) if found.size == 1 else found


class Ramp:
    """A number that depends on a field of the fluid.

    Args:
        text: The field, one of ``FIELDS``, then ``VALUE OF THE FIELD:NUMBER`` pairs separated by semicolons.

    Attributes:
        field: Its name.
        inputs: Values of the field, rising.
        values: The number at each; linear between them, constant before the first and after the last.

    Raises:
        ValueError: If the text is none of this.
    """

    def __init__(self, text: str):
        self.field, _, pairs = text.strip().partition(" ")
        if self.field not in FIELDS:
            raise ValueError(f"{self.field!r} is no field, expected one of {', '.join(FIELDS)}")
        keyed = Keyed(pairs)
        self.inputs, self.values = keyed.frames, keyed.values[:, 0]


def is_ramp(value) -> bool:
    """Return whether a number's place is taken by what begins as a ramp does, with the name of a field."""
    return isinstance(value, str) and value.strip().partition(" ")[0] in FIELDS


def _split(key: str, first: bool) -> tuple[float, str]:
    frame, colon, value = key.rpartition(":")
    if not colon and not first:
        raise ValueError(f"{key!r} has no frame")
    return (_number(frame) if colon else 0.0), value


def _numbers(text: str, size: int) -> list[float]:
    numbers = [_number(part) for part in text.split(",")]
    if len(numbers) != size:
        raise ValueError(f"{text!r} is {len(numbers)} numbers")
    return numbers


def _number(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"{text} is not finite")
    return number
