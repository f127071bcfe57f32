"""Multiplication and flame sheet: volumes from pairs of views (Hasinoff and Kutulakos 2007; Section 5).

In every slice a pair of views gives the two marginals of the volume, and both methods couple them. ``multiplication``
is the coupling of largest entropy, front(x) side(z) / total for views at a right angle; for other angles and more
views, what multiplicative ART reaches from a constant. ``flame-sheet`` is the comonotone coupling of optimal
transport: all light lies on one curve a slice, x rising with z. More views blend the sheets of all pairs, each with its
mirror, by convex weights of least squares.
"""

from itertools import combinations

import numpy as np
import warp as wp
from scipy.optimize import nnls

from warpfluid.balance import Balancing
from warpfluid.options import ReconstructOptions
from warpfluid.reconstruction.inputs import Inputs

SWEEPS = 60  # of multiplicative ART
SUBDIVISION = 4  # of a sheet that does not follow the grid
CONVEX = 1e3  # weight of "the weights add up to 1" over the pictures' root mean square


def multiplication(inputs: Inputs, options: ReconstructOptions) -> wp.array:
    """Return the volume of largest entropy that the views allow, over the inputs' part of the box.

    Args:
        inputs: Measured views, or one and its stand-in.
        options: The footprint is used.
    """
    images, angles = _looks(inputs)
    if angles == (0.0, 90.0):
        front, side = _marginals(inputs, images)
        total = front.sum(axis=0)
        product = front[:, None] * (side / np.where(total > 0, total, 1))[None]
        return wp.array(product, dtype=float, device=inputs.hull.device)
    area = inputs.support.numpy().sum(axis=(0, 1))
    level = inputs.row_sums / np.maximum(area, 1)
    start = wp.array(inputs.support.numpy() * level, dtype=float, device=inputs.hull.device)
    return Balancing(images, inputs.projectors(angles, options.footprint)).apply(start, SWEEPS)


def flame_sheet(inputs: Inputs, options: ReconstructOptions) -> wp.array:
    """Return the sheet of a pair of views, or the blend of several pairs' sheets, over the inputs' part of the box.

    Args:
        inputs: Measured views, or one and its stand-in.
        options: The footprint is used.
    """
    images, angles = _looks(inputs)
    device = inputs.hull.device
    if angles == (0.0, 90.0):
        return wp.array(sheet(*_marginals(inputs, images)), dtype=float, device=device)
    if len(angles) == 2:
        volume = wp.array(_bent_sheet(inputs, images, angles), dtype=float, device=device)
        return Balancing(images, inputs.projectors(angles, options.footprint)).apply(volume, SWEEPS)
    projector = inputs.projector(angles, options.footprint)
    support = inputs.support.numpy()
    pairs = [(i, j, turn) for i, j in combinations(range(len(angles)), 2) for turn in (1, -1)]

    def make(i: int, j: int, turn: int) -> np.ndarray:
        """Return the sheet of a pair inside the hull of all, as bright as they are at every height."""
        inside = _bent_sheet(inputs, images[[i, j]], (angles[i], angles[j]), turn=turn) * support
        light = inside.sum(axis=(0, 1))
        return (inside * (inputs.row_sums / np.where(light > 0, light, 1))).astype(np.float32)

    rendered = [projector.project(make(*pair)).ravel() for pair in pairs]
    weights = blend_weights(np.stack(rendered, axis=1), images.ravel())
    volume = sum(np.float32(w) * make(*pair) for w, pair in zip(weights, pairs, strict=True) if w > 0)
    return wp.array(volume, dtype=float, device=device)


def sheet(front: np.ndarray, side: np.ndarray) -> np.ndarray:
    """Couple two marginals comonotonically in every slice.

    Args:
        front: Sums over z, non-negative, shape (x, y).
        side: Sums over x with the same totals, shape (z, y).

    Returns:
        The volume, shape (x, z, y): at most nx + nz - 1 cells of a slice are not 0.
    """
    volume = np.zeros((len(front), len(side), front.shape[1]))
    for y in range(front.shape[1]):
        total = front[:, y].sum(dtype=np.float64)
        if total <= 0 or not side[:, y].any():
            continue
        along, across = _cumulative(front[:, y], total), _cumulative(side[:, y], total)
        edges = np.unique(np.concatenate([along, across]))
        middle = (edges[1:] + edges[:-1]) / 2
        cells = [np.searchsorted(sums, middle, side="right") - 1 for sums in (along, across)]
        volume[(*cells, y)] = np.diff(edges)
    return volume.astype(np.float32)


def blend_weights(rendered: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Return the convex weights with which columns add up nearest to what is wanted (least squares).

    Args:
        rendered: What each part shows, shape (pixel, part).
        wanted: Shape (pixel,).

    Returns:
        Weights of at least 0 that add up to 1, shape (part,).
    """
    scale = np.sqrt(np.square(rendered, dtype=np.float64).mean()) * len(wanted) ** 0.5 * CONVEX
    rows = np.concatenate([rendered.astype(np.float64), np.full((1, rendered.shape[1]), scale)])
    weights = nnls(rows, np.append(wanted.astype(np.float64), scale))[0]
    return weights / weights.sum() if weights.any() else np.full(len(weights), 1 / len(weights))


def _looks(inputs: Inputs) -> tuple[np.ndarray, tuple[float, ...]]:
    """Return the views that count and their angles, ascending; one view is joined by its side."""
    images = inputs.images[: max(inputs.measured, 2)]
    if inputs.side is not None:
        images = np.stack([inputs.images[0], inputs.side])
    order = np.argsort(inputs.angles_deg[: len(images)])
    return np.ascontiguousarray(images[order]), tuple(inputs.angles_deg[i] for i in order)


def _marginals(inputs: Inputs, images: np.ndarray) -> list[np.ndarray]:
    """Return front and side over the inputs' part of the box, scaled to one total a height, in float64."""
    rows = [image[part].astype(np.float64) for image, part in zip(images, inputs.part, strict=True)]
    totals = [row.sum(axis=0) for row in rows]
    common = inputs.row_sums * np.all(totals, axis=0)
    return [row * (common / np.where(total > 0, total, 1)) for row, total in zip(rows, totals, strict=True)]


def _cumulative(row: np.ndarray, total: float) -> np.ndarray:
    """Return how much light lies before each edge of a row's pixels; the last is the total to the bit."""
    sums = np.concatenate([[0.0], np.cumsum(row, dtype=np.float64)])
    return total * (sums / sums[-1])


def _bent_sheet(inputs: Inputs, images: np.ndarray, angles_deg: tuple[float, float], *, turn: int = 1) -> np.ndarray:
    """Lay the sheet of a pair at any angles over the inputs' part of the box; -1 turns the second view around."""
    width, middle = inputs.box[0], (inputs.box[0] - 1) / 2
    radians = np.deg2rad(angles_deg)
    back = np.linalg.inv(np.stack([np.cos(radians), np.sin(radians)], axis=1))  # u of both views to x and z
    edges = np.arange(width + 1) - 0.5
    volume = np.zeros((*inputs.hull.shape,), np.float64)
    for y, total in enumerate(inputs.row_sums):
        rows = [images[0][:, y], images[1][::turn, y]]
        if total <= 0 or not all(row.any() for row in rows):
            continue
        along, across = (_cumulative(row, total) for row in rows)
        cuts = np.unique(np.concatenate([along, across]))
        fine = np.linspace(cuts[:-1], cuts[1:], SUBDIVISION + 1, axis=1)
        at = (fine[:, 1:] + fine[:, :-1]).ravel() / 2
        u = np.stack([np.interp(at, along, edges), turn * (np.interp(at, across, edges) - middle) + middle])
        place = back @ (u - middle) + middle - np.array(inputs.corner)[:, None]
        _splat(volume[..., y], place, np.diff(fine, axis=1).ravel())
    return volume


def _splat(level: np.ndarray, place: np.ndarray, light: np.ndarray) -> None:
    """Add light to the four voxels around each place, in place; what falls outside is lost."""
    low = np.floor(place).astype(int)
    share = place - low
    for dx in (0, 1):
        for dz in (0, 1):
            x, z = low[0] + dx, low[1] + dz
            weight = light * np.abs(1 - dx - share[0]) * np.abs(1 - dz - share[1])
            inside = (x >= 0) & (x < level.shape[0]) & (z >= 0) & (z < level.shape[1])
            np.add.at(level, (x[inside], z[inside]), weight[inside])
