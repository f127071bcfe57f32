"""From a picture in a file to an image of light on black.

The order is: crop, undo the tone curve, luminance, take the background off, scale to 0..255, take the black
level off, keep the largest region, move and enlarge, shrink, and turn to (u, v) with v up.
"""

import re
from dataclasses import dataclass

import numpy as np

from warpfluid.footage.resampling import move

LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)  # Rec. ITU-R BT.709
SMALLEST = 8  # pixels of a side; below this there is no pyramid to speak of
LIT = 1.0  # grey level above which a pixel holds light
ROW_RATIO = 4.0  # rows are scaled by at most this much, either way


@dataclass(frozen=True, kw_only=True, eq=False)
class Matting:
    """How the pictures of one view become images.

    Attributes:
        size: Width and height of the image [pixel].
        crop: Width, height, left and top of the part of the picture to use [pixel].
        decode: Tone curve to undo, ``none``, ``srgb`` or ``rec709``.
        background: Light of the empty set, shape (rows, columns), after the steps up to the luminance.
        white: Light that becomes 255.
        black_level: Grey level of the empty background [0-255].
        largest_component: Keep the largest lit region only.
        shift: How far the picture moves up [pixel of the footage].
        scale: How much larger it is drawn, about its middle.
    """

    size: tuple[int, int]
    crop: tuple[int, int, int, int] | None = None
    decode: str = "none"
    background: np.ndarray | None = None
    white: float = 1.0
    black_level: float = 0.0
    largest_component: bool = False
    shift: float = 0.0
    scale: float = 1.0

    def light(self, picture: np.ndarray) -> np.ndarray:
        """Return what the fluid adds to the background, shape (rows, columns), never negative."""
        if self.crop is not None:
            width, height, left, top = self.crop
            picture = picture[top : top + height, left : left + width]
        light = luminance(undo_tone_curve(picture, self.decode))
        if self.background is not None:
            light = light - self.background
        return np.maximum(light, 0.0)

    def image(self, picture: np.ndarray) -> np.ndarray:
        """Return the image of a picture, float32, shape (u, v), v up, 255 for white.

        Args:
            picture: Top row first, shape (rows, columns[, channels]), integer footage scaled to 0..1.
        """
        grey = self.light(picture) * np.float32(255.0 / self.white)
        if self.black_level > 0:
            grey = np.maximum(grey - self.black_level, 0.0) * np.float32(255.0 / (255.0 - self.black_level))
        if self.largest_component:
            grey = keep_largest_region(grey)
        return to_image(shrink(move(grey, self.shift, self.scale), self.size))


def parse_resolution(text: str) -> tuple[int, int | None]:
    """Return width and height of ``WIDTH`` or ``WIDTHxHEIGHT``; no height keeps the picture's proportions."""
    match = re.fullmatch(r"\s*(\d+)(?:\s*[xX]\s*(\d+))?\s*", text)
    sides = [int(side) for side in match.groups() if side] if match else []
    if not sides or min(sides) < SMALLEST:
        raise ValueError(
            f"--resolution {text!r} is not WIDTH or WIDTHxHEIGHT of {SMALLEST} pixels or more, such as 256 or 256x144"
        )
    return sides[0], sides[1] if len(sides) > 1 else None


def parse_crop(text: str) -> tuple[int, int, int, int]:
    """Return width, height, left and top of ``WIDTHxHEIGHT+LEFT+TOP``."""
    match = re.fullmatch(r"\s*(\d+)[xX](\d+)\+(\d+)\+(\d+)\s*", text)
    if not match or int(match[1]) * int(match[2]) == 0:
        raise ValueError(f"--crop {text!r} is not WIDTHxHEIGHT+LEFT+TOP, such as 640x720+320+0")
    return tuple(int(number) for number in match.groups())


def luminance(picture: np.ndarray) -> np.ndarray:
    """Return the Rec. 709 luminance of a picture as float32, shape (rows, columns); alpha is left out.

    Raises:
        ValueError: If the shape is not (rows, columns) or (rows, columns, 1, 3 or 4).
    """
    picture = np.asarray(picture)
    if picture.ndim == 2:
        return picture.astype(np.float32)
    if picture.ndim != 3 or picture.shape[2] not in (1, 3, 4):
        raise ValueError(
            f"pictures must have the shape (rows, columns) or (rows, columns, 1, 3 or 4), not {picture.shape}"
        )
    if picture.shape[2] == 1:
        return picture[..., 0].astype(np.float32)
    return picture[..., :3].astype(np.float32) @ LUMINANCE


def undo_tone_curve(picture: np.ndarray, curve: str) -> np.ndarray:
    """Return linear light for values of 0 to 1 behind the curve ``none``, ``srgb`` or ``rec709``."""
    if curve == "none":
        return picture
    picture = np.maximum(picture, 0)
    if curve == "srgb":  # IEC 61966-2-1
        return np.where(picture <= 0.04045, picture / 12.92, ((picture + 0.055) / 1.055) ** 2.4)
    if curve == "rec709":
        return np.where(picture < 0.081, picture / 4.5, ((picture + 0.099) / 1.099) ** (1 / 0.45))
    raise ValueError(f"decode is {curve!r}: use none, srgb or rec709")


def keep_largest_region(grey: np.ndarray) -> np.ndarray:
    """Return the picture with everything black but its largest connected lit region (corners connect)."""
    from scipy import ndimage

    labels, count = ndimage.label(grey > LIT, structure=np.ones((3, 3)))
    if count == 0:
        return np.zeros_like(grey)
    areas = np.bincount(labels.ravel())[1:]
    return np.where(labels == 1 + np.argmax(areas), grey, np.float32(0))


def shrink(picture: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Average a picture over the area of each new pixel, so that its mean stays exactly the same.

    Args:
        picture: Shape (rows, columns).
        size: New width and height [pixel], whole fractions or not.
    """
    width, height = size
    return average(average(picture, height).T, width).T


def to_image(picture: np.ndarray) -> np.ndarray:
    """Turn a picture, (rows, columns) and top row first, to an image (u, v), float32, v up and contiguous."""
    return np.ascontiguousarray(np.asarray(picture, np.float32)[::-1].T)


def equalize_rows(images: np.ndarray, lit_above: float = LIT) -> np.ndarray:
    """Give every view the same total in each image row, as light that no medium absorbs has.

    The total is the mean over the views in which the row is lit. A row that is dark in a view stays so, and
    no row is scaled by more than a factor of four.

    Args:
        images: Linear light, shape (view, u, v).
        lit_above: Level above which a pixel holds light.
    """
    sums = images.sum(axis=1, dtype=np.float64)
    lit = images.max(axis=1) > lit_above
    mean = np.where(lit, sums, 0).sum(axis=0) / np.maximum(lit.sum(axis=0), 1)
    ratio = np.divide(mean, sums, out=np.ones_like(sums), where=lit).clip(1 / ROW_RATIO, ROW_RATIO)
    return images * ratio[:, None, :].astype(np.float32)


def average(picture: np.ndarray, length: int) -> np.ndarray:
    """Average rows over equal intervals: differences of the running sum at the interval's ends."""
    rows = len(picture)
    if rows == length:
        return picture
    running = np.zeros((rows + 2, picture.shape[1]))  # one row more, so that the last end has a neighbour
    np.cumsum(picture, axis=0, dtype=np.float64, out=running[1:-1])
    running[-1] = running[-2]
    ends = np.linspace(0, rows, length + 1)
    whole = ends.astype(int)
    at_ends = running[whole] + (ends - whole)[:, None] * (running[whole + 1] - running[whole])
    return (np.diff(at_ends, axis=0) * (length / rows)).astype(np.float32)
