"""Colours and opacities that make a graphics library's picture look like ours.

A library draws a volume by laying its samples over one another, each with a colour and an opacity that its density
gives; we add up light first and colour the sum. With opacities fixed, the library's picture depends on the colours
linearly, so the colours that come nearest to ours in one view solve a small least-squares problem.
"""

from typing import NamedTuple

import numpy as np

from warpfluid.preview.packing import coarsen
from warpfluid.rendering.ramps import apply_ramp

STOPS = 32
WIDTH = 64  # voxels that the comparison is made with
DEPTHS = (1.5, 2.0, 3.0, 4.0, 6.0)  # optical depths of a white ray that are tried
SMOOTHNESS = 0.02  # how alike the colours of neighbouring stops are
BRIGHT = 0.999  # share of the lit voxels that the stops reach over
BEYOND = 4.0  # times the last stop, to which opacity goes on rising


class Transfer(NamedTuple):
    """What a library draws densities with.

    Attributes:
        levels: Densities of the stops [grey levels a voxel], rising, shape (n,).
        colors: Red, green and blue, 0 to 1, shape (n, 3).
        opacities: Share of the light behind that a voxel hides, shape (n,).
        error: Root mean square of what is left between the pictures, 0 to 1.
    """

    levels: np.ndarray
    colors: np.ndarray
    opacities: np.ndarray
    error: float


def match_look(density: np.ndarray, look: str, *, white: float = 255.0) -> Transfer:
    """Find colours and opacities for a volume.

    Args:
        density: Shape (x, z, y).
        look: Name of a colour ramp.
        white: Ray sum that is the brightest colour.
    """
    factor = max(1.0, max(density.shape[:2]) / WIDTH)
    small = coarsen(density, tuple(max(1, round(n / factor)) for n in density.shape))[:, ::-1]  # the front first
    edge = density.shape[1] / small.shape[1]
    lit = small[small > 0]
    top = float(np.quantile(lit, BRIGHT)) if lit.size else 1.0
    ours = apply_ramp((small.sum(axis=1) * edge).ravel(), look, white) / 255.0
    return min((_fit(small * edge, top * edge, edge, ours, depth / white) for depth in DEPTHS), key=lambda t: t.error)


def _fit(sums: np.ndarray, top: float, edge: float, ours: np.ndarray, extinction: float) -> Transfer:
    """Fit colours to our picture for one extinction; ``sums`` are the ray sums of every voxel on its own."""
    from scipy.optimize import lsq_linear

    weights = _weights(sums, top, extinction)
    smooth = SMOOTHNESS * np.sqrt(len(ours)) * np.diff(np.eye(STOPS), axis=0)
    system, none = np.concatenate([weights, smooth]), np.zeros(STOPS - 1)
    colors = [lsq_linear(system, np.concatenate([channel, none]), (0, 1)).x for channel in ours.T]
    colors = np.stack(colors, axis=1)
    levels = top / edge * np.linspace(0, 1, STOPS) ** 2
    levels, colors = np.append(levels, BEYOND * levels[-1]), np.append(colors, colors[-1:], axis=0)
    error = float(np.sqrt(np.mean((weights @ colors[:STOPS] - ours) ** 2)))
    return Transfer(levels, colors, 1 - np.exp(-extinction * levels), error)


def _weights(sums: np.ndarray, top: float, extinction: float) -> np.ndarray:
    """Return by how much the colour of every stop shows in every pixel, shape (pixel, stop)."""
    depth = extinction * sums
    shown = np.exp(depth - np.cumsum(depth, axis=1)) * (1 - np.exp(-depth))
    place = np.sqrt(np.clip(sums / top, 0, 1)) * (STOPS - 1)
    below = np.minimum(place.astype(np.intp), STOPS - 2)
    pixels = np.arange(sums.shape[0] * sums.shape[2]).reshape(sums.shape[0], 1, sums.shape[2]) * STOPS
    total = pixels.size * STOPS
    lower = np.bincount((pixels + below).ravel(), (shown * (1 - (place - below))).ravel(), total)
    upper = np.bincount((pixels + below + 1).ravel(), (shown * (place - below)).ravel(), total)
    return (lower + upper).reshape(pixels.size, STOPS)
