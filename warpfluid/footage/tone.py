"""The film-like tone curve that makes a flame's core white, and the light behind it.

The curve is I = 255 (1 - exp(-k L / 255)) / (1 - exp(-k)) of linear light L, k being the strength. Light adds up and
is scaled as linear light only: exposures are matched, and rows made equal, behind the curve.
"""

import numpy as np


def undo_shoulder(grey: np.ndarray, strength: float) -> np.ndarray:
    """Take a film-like tone curve off footage; black and 255 stay, and the curve shows nothing brighter."""
    return -255 / strength * np.log1p(np.expm1(-strength) * np.minimum(grey, 255) / 255) if strength else grey


def apply_shoulder(light: np.ndarray, strength: float) -> np.ndarray:
    """Put the tone curve that ``undo_shoulder`` takes off on linear light again."""
    return 255 * np.expm1(-strength * light / 255) / np.expm1(-strength) if strength else light
