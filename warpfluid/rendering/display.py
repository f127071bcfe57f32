"""From light to what a screen shows: exposure, a soft roll-off for what is too bright, and the curve of sRGB."""

import numpy as np

SPILL = 0.06  # share of the light above white that shows in the other channels, as in film: bright fire turns pale


def develop(light: np.ndarray, *, exposure: float = 0.0, rolloff: float = 0.6) -> np.ndarray:
    """Return light as the values of a screen.

    Below ``rolloff`` light is shown as it is. Above, an exponential of the same slope brings all the rest below 1, so
    that bright parts keep a drawing; 1 clips instead, which is exact below white.

    Args:
        light: Linear light, 1 is white, any shape with red, green, blue last.
        exposure: Stops by which it is made brighter.
        rolloff: Where the soft part begins, 0 to 1.

    Returns:
        Values of sRGB, 0 to 1, of the same shape.
    """
    light = np.maximum(np.asarray(light, np.float32) * np.float32(2.0**exposure), 0)
    if rolloff < 1:
        light = light + np.float32(SPILL) * np.maximum(light - 1, 0).sum(axis=-1, keepdims=True)
        room = np.float32(1 - rolloff)
        light = np.where(light > rolloff, 1 - room * np.exp(-np.maximum(light - rolloff, 0) / room), light)
    return encode_srgb(light)


def encode_srgb(light: np.ndarray) -> np.ndarray:
    """Return linear light as values of sRGB, both 0 to 1 (IEC 61966-2-1)."""
    light = np.clip(light, 0, 1)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 0.0031308) ** (1 / 2.4) - 0.055)


def decode_srgb(values: np.ndarray) -> np.ndarray:
    """Return values of sRGB as linear light, both 0 to 1."""
    values = np.clip(values, 0, 1)
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def quantize(values: np.ndarray, bits: int = 8) -> np.ndarray:
    """Return values from 0 to 1 as whole numbers of 8 or 16 bits."""
    most = 2**bits - 1
    return np.rint(np.clip(values, 0, 1) * most).astype(np.uint8 if bits == 8 else np.uint16)
