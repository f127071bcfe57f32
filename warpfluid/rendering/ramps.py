"""Colour ramps: what a grey value looks like on a screen."""

from functools import cache

import numpy as np

# Grey level [0-255]: red, green, blue. Between the stops colours run straight; in fire and smoke no channel
# ever falls, so brighter is always lighter. Jet is the classic map the paper shows its slices in.
RAMPS: dict[str, dict[float, tuple[int, int, int]]] = {
    "fire": {
        0: (0, 0, 0),
        16: (19, 2, 1),
        40: (66, 8, 3),
        72: (132, 23, 6),
        104: (191, 52, 8),
        136: (230, 94, 14),
        168: (248, 145, 33),
        200: (253, 194, 76),
        228: (255, 227, 142),
        255: (255, 250, 232),
    },
    "smoke": {
        0: (0, 0, 0),
        32: (38, 40, 43),
        80: (91, 94, 98),
        144: (156, 158, 161),
        208: (213, 213, 213),
        255: (250, 248, 245),
    },
    "explosion": {
        0: (0, 0, 0),
        48: (38, 33, 30),
        104: (92, 68, 54),
        144: (158, 92, 54),
        184: (232, 140, 60),
        220: (255, 208, 110),
        255: (255, 250, 232),
    },
    "blackbody": {
        0: (0, 0, 0),
        24: (40, 3, 0),
        64: (118, 20, 0),
        104: (190, 62, 4),
        144: (240, 118, 22),
        184: (255, 176, 78),
        220: (255, 218, 150),
        255: (255, 246, 226),
    },
    "water": {
        0: (0, 0, 0),
        40: (8, 34, 50),
        104: (42, 104, 138),
        168: (126, 184, 210),
        216: (206, 232, 243),
        255: (248, 252, 255),
    },
    "jet": {
        0: (0, 0, 128),
        31.875: (0, 0, 255),
        95.625: (0, 255, 255),
        159.375: (255, 255, 0),
        223.125: (255, 0, 0),
        255: (128, 0, 0),
    },
    "gray": {0: (0, 0, 0), 255: (255, 255, 255)},
}
STEPS = 8  # entries of the table a grey level; every stop is one of them


def apply_ramp(images: np.ndarray, name: str, white: float = 255.0) -> np.ndarray:
    """Colour grey images.

    Args:
        images: Grey values, any shape; what lies outside 0 to ``white`` takes the ramp's ends.
        name: One of ``RAMPS``: fire, smoke, explosion, blackbody, water, jet, gray.
        white: Grey value that gets the ramp's last colour.

    Returns:
        The colours, uint8, the shape of ``images`` and a last axis of red, green, blue.

    Raises:
        ValueError: If there is no such ramp, or ``white`` is not positive.
    """
    if name not in RAMPS:
        raise ValueError(f"ramp is {name!r}; choose one of {', '.join(RAMPS)}")
    if not white > 0:
        raise ValueError(f"white is {white}; a positive grey value is needed")
    table = _table(name)
    grey = np.clip(np.nan_to_num(np.asarray(images, np.float32)), 0, np.float32(white))
    return table[np.rint(grey * np.float32((len(table) - 1) / white)).astype(np.intp)]


@cache
def _table(name: str) -> np.ndarray:
    """Return a ramp's colours at every eighth of a grey level, shape (2041, 3)."""
    levels = np.arange(255 * STEPS + 1) / STEPS
    stops, colours = list(RAMPS[name]), np.array(list(RAMPS[name].values()))
    table = np.stack([np.interp(levels, stops, channel) for channel in colours.T], axis=-1)
    table = np.rint(table).astype(np.uint8)
    table.flags.writeable = False  # it is shared between calls
    return table
