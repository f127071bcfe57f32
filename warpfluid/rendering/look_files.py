"""Files of looks: those of the package and those of a user, with all that is wrong with one told at once.

A look is a JSON object::

    {"about": "Hot gas",
     "emission": {"input": {"flame": 1, "density": 3}, "stops": [[0, 0], [1, 4]], "blackbody": [1200, 3000]},
     "opacity": {"input": "density", "stops": [[0, 0], [1, 1]], "scale": 2, "bias": 0.2},
     "color": {"stops": [[0, [0.5, 0.5, 0.55]]]},
     "anisotropy": 0.3}
"""

import json
import math
import os
from importlib.resources import files
from pathlib import Path

import numpy as np

from warpfluid.errors import Problems
from warpfluid.rendering.looks import FIELDS, RAMPS, Look, Ramp

LARGEST = 1e300  # number in a look
KEYS = {"input", "stops", "bias", "scale", "blackbody", "times"}


def look_names() -> list[str]:
    """Return the names of the looks that come with the package."""
    return sorted(path.name.removesuffix(".json") for path in _folder().iterdir() if path.name.endswith(".json"))


def read_look(name: str) -> Look:
    """Return a look.

    Args:
        name: One of the package's, or a file that ends in ``.json``.

    Raises:
        ValueError: If there is none of that name, or anything in its file is wrong; one line each.
        OSError: If the file cannot be read.
    """
    is_file = name.lower().endswith(".json")
    if not is_file and name not in look_names():
        raise ValueError(f"look is {name!r}, expected one of {', '.join(look_names())}, or a file that ends in .json")
    text = Path(os.path.expanduser(name)).read_bytes() if is_file else (_folder() / f"{name}.json").read_bytes()
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{name} is no JSON: {error}") from error
    return make_look(document, name)


def make_look(document: object, name: str) -> Look:
    """Return the look that a document describes.

    Args:
        document: What the JSON says.
        name: What to call it, in errors too.

    Raises:
        ValueError: If anything is wrong; one line each.
    """
    problems = Problems()
    if not isinstance(document, dict) or not set(document) & set(RAMPS):
        raise ValueError(f"{name} is no look: an object with at least one of {', '.join(RAMPS)} is needed")
    for key in sorted(set(document) - {*RAMPS, "about", "anisotropy"}):
        problems.append(f"{name}: {key!r} is unknown, expected are about, anisotropy, {', '.join(RAMPS)}")
    about, anisotropy = document.get("about", ""), document.get("anisotropy", 0.0)
    if not isinstance(about, str):
        problems.append(f"{name}: about is {about!r}, expected text")
    if not _is_number(anisotropy, -0.95, 0.95):
        problems.append(f"{name}: anisotropy is {anisotropy!r}, expected -0.95 to 0.95")
    ramps = {
        ramp: problems.attempt(_ramp, document[ramp], ramp, where=f"{name}: {ramp}: ")
        for ramp in RAMPS
        if ramp in document
    }
    problems.raise_if_any()
    return Look(name=name, about=about, ramps=ramps, anisotropy=float(anisotropy))


def _folder():
    return files("warpfluid") / "looks"


def _ramp(table: object, name: str) -> Ramp:
    """Return a ramp, or raise everything that is wrong with it."""
    if not isinstance(table, dict) or "stops" not in table:
        raise ValueError("an object with input and stops is needed")
    problems = Problems(f"{key!r} is unknown, expected are {', '.join(sorted(KEYS))}" for key in set(table) - KEYS)
    inputs = problems.attempt(_inputs, table.get("input", "density"))
    stops = problems.attempt(_stops, table["stops"], 1.0 if name == "color" else math.inf)
    if name == "opacity" and stops and (stops[1] != stops[1][:, :1]).any():
        problems.append("stops have colours, but fluid hides all colours alike: write one number each")
    bias, scale, kelvin = table.get("bias", 0.0), table.get("scale", 1.0), table.get("blackbody")
    if not _is_number(bias, -0.99, 0.99):
        problems.append(f"bias is {bias!r}, expected -0.99 to 0.99")
    if not _is_number(scale, 0, 1e6) or (name == "color" and scale > 1):
        problems.append(f"scale is {scale!r}, expected 0 to {1 if name == 'color' else '1e6'}")
    if kelvin is not None and not (
        isinstance(kelvin, list) and len(kelvin) == 2 and all(_is_number(k, 500, 20000) for k in kelvin)
    ):
        problems.append(f"blackbody is {kelvin!r}, expected two temperatures of 500 to 20000 K, such as [1000, 3000]")
    elif kelvin is not None and name != "emission":
        problems.append("blackbody is for emission only")
    if table.get("times") not in (None, "density"):
        problems.append(f"times is {table['times']!r}, expected density")
    problems.raise_if_any()
    positions, values = stops
    return Ramp(
        inputs=inputs,
        positions=positions,
        values=values,
        bias=float(bias),
        scale=float(scale),
        times=table.get("times"),
        kelvin=tuple(kelvin) if kelvin else None,
    )


def _inputs(value: object) -> dict[str, float]:
    """Return the inputs of a ramp with the amounts at its end."""
    inputs = {value: 1.0} if isinstance(value, str) else value
    if not isinstance(inputs, dict) or not inputs or not set(inputs) <= set(FIELDS):
        raise ValueError(
            f"input is {value!r}, expected one of {', '.join(FIELDS)}, or amounts at the ramp's end such as "
            '{"flame": 1, "density": 3}, the first that a volume has being taken'
        )
    for name, amount in inputs.items():
        if not _is_number(amount, 1e-6, 1e6):
            raise ValueError(f"input {name} ends at {amount!r}, expected 1e-6 to 1e6")
    return {**inputs, "density": inputs.get("density", 1.0)}  # it stands in where there is nothing else


def _stops(value: object, most: float) -> tuple[np.ndarray, np.ndarray]:
    """Return positions and values of stops."""
    form = "[position, value] with positions rising from 0 to 1, and values a number or [red, green, blue]"
    if not isinstance(value, list) or not value or not all(isinstance(s, list) and len(s) == 2 for s in value):
        raise ValueError(f"stops are a list of {form}")
    colors = [color if isinstance(color, list) else [color] * 3 for _, color in value]
    if not all(_is_number(position, 0, 1) for position, _ in value) or not all(
        len(color) == 3 and all(_is_number(part, 0, most) for part in color) for color in colors
    ):
        limit = f", here 0 to {most:g}" if most < math.inf else " of 0 or more"
        raise ValueError(f"stops are a list of {form}{limit}")
    positions = np.array([position for position, _ in value], np.float64)
    if (np.diff(positions) <= 0).any():
        raise ValueError(f"positions of stops must rise, they are {', '.join(f'{p:g}' for p in positions)}")
    return positions, np.array(colors, np.float64)


def _is_number(value: object, low: float, high: float) -> bool:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return is_number and abs(value) <= LARGEST and low <= value <= high
