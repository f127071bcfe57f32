"""A camera that moves, read from a file of keys.

The file is a list of keys, each a frame and what the camera has there; what a key leaves out is not keyed there:

    [{"frame": 1, "angle": 0, "distance": 20}, {"frame": 48, "angle": 90}, {"frame": 96, "target": [0, 4, 0]}]
"""

import json
import math
from pathlib import Path

SIZES = {
    "angle": 1,
    "elevation": 1,
    "distance": 1,
    "field_of_view": 1,
    "zoom": 1,
    "target": 3,
    "eye_distance": 1,
    "convergence": 1,
}
LARGEST_FILE = 1 << 24  # bytes


def read_camera_path(name: str | Path) -> dict[str, str]:
    """Read the keys of a camera.

    Args:
        name: The file, .json.

    Returns:
        For each number that is keyed, the text that ``Keyed`` reads: ``1:0;48:90``.

    Raises:
        ValueError: If it is no such file; its name, the key and what was expected are named.
        OSError: If it cannot be read.
    """
    path = Path(name)
    if path.stat().st_size > LARGEST_FILE:
        raise ValueError(f"{path} is larger than {LARGEST_FILE >> 20} MiB; no file of camera keys is")
    try:
        keys = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path} is no JSON file: {error}") from None
    if not isinstance(keys, list) or not keys:
        raise ValueError(f'{path} holds no list of keys such as [{{"frame": 1, "angle": 0}}, ...]')
    found: dict[str, dict[float, str]] = {}
    for i, key in enumerate(keys, 1):
        for field, frame, text in _parts(key, f"{path}, key {i}"):
            if found.setdefault(field, {}).setdefault(frame, text) != text:
                raise ValueError(f"{path}, key {i}: {field} has another value at frame {frame:g}")
    return {
        field: ";".join(f"{frame!r}:{text}" for frame, text in sorted(values.items()))
        for field, values in found.items()
    }


def _parts(key, where: str) -> list[tuple[str, float, str]]:
    """Return name, frame and text of every number in a key."""
    if not isinstance(key, dict) or not _is_number(key.get("frame")):
        raise ValueError(f'{where} has no frame; expected {{"frame": 1, "angle": 0, ...}}')
    parts = []
    for name, value in key.items():
        if name == "frame":
            continue
        if name not in SIZES:
            raise ValueError(f"{where} has {name!r}; a camera has {', '.join(SIZES)}")
        numbers = value if isinstance(value, list) else [value]
        if len(numbers) != SIZES[name] or not all(map(_is_number, numbers)):
            raise ValueError(f"{where}: {name} is {value!r}, expected {_expected(SIZES[name])}")
        parts.append((name, float(key["frame"]), ",".join(repr(float(number)) for number in numbers)))
    return parts


def _expected(size: int) -> str:
    return "a number" if size == 1 else f"a list of {size} numbers"


def _is_number(value) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e18 and math.isfinite(value)
