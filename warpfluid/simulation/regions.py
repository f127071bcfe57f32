"""Parts of the fluid without a way out: there, what flows out in total cannot be chosen."""

import numpy as np
import warp as wp
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from warpfluid.kernels.sides import CLOSED, OPEN, SIX, WRAP
from warpfluid.simulation.state import Faces


class Regions:
    """The closed regions of a box with solids.

    Attributes:
        voxels: Flat indices of the voxels in closed regions.
        labels: Number of the region that each is in.
        count: How many regions there are.
    """

    def __init__(self, open: Faces, sides: SIX):
        """Find what hangs together over open faces, and which of it has no open side.

        Args:
            open: Share of each face that is fluid.
            sides: What the sides of the box are.
        """
        passes = [_passes(faces.numpy(), axis, sides) for axis, faces in enumerate(open)]
        starts = ~passes[2][..., :-1]
        starts[..., 0] = True
        run = np.cumsum(starts, dtype=np.int32).reshape(starts.shape) - 1
        _, part = _connect(run, starts, passes, sides)
        count = part.max() + 1
        fluid, leaks = np.zeros(count, bool), np.zeros(count, bool)
        for axis, through in enumerate(passes):
            beside = np.moveaxis(run, axis, 0)
            for faces in (np.moveaxis(through, axis, 0)[:-1], np.moveaxis(through, axis, 0)[1:]):
                fluid[part[beside[faces]]] = True
            for end, side in ((0, sides[2 * axis]), (-1, sides[2 * axis + 1])):
                if side == OPEN:
                    leaks[part[np.take(run, end, axis)[np.take(through, end, axis)]]] = True
        closed = fluid & ~leaks
        self.count = int(closed.sum())
        self.voxels = np.flatnonzero(closed[part][run]) if self.count else np.empty(0, int)
        self.labels = (np.cumsum(closed) - 1)[part][run.ravel()[self.voxels]]

    def remove_means(self, field: wp.array) -> None:
        """Take the mean over each closed region from a field, in place."""
        if not self.count:
            return
        values = field.numpy().ravel()
        inside = values[self.voxels]
        total = np.bincount(self.labels, weights=inside, minlength=self.count)
        mean = total / np.bincount(self.labels, minlength=self.count)
        values[self.voxels] = inside - mean[self.labels]
        if field.device.is_cuda:
            field.assign(values.reshape(field.shape))


def remove_mean(field: wp.array) -> None:
    """Take the mean over the whole box from a field, in place."""
    values = field.numpy()
    values -= values.mean(dtype=np.float64).astype(np.float32)
    if field.device.is_cuda:
        field.assign(values)


def _passes(open: np.ndarray, axis: int, sides: SIX) -> np.ndarray:
    """Return which faces of an axis let fluid through."""
    passes = open > 0.0
    for end, side in ((0, sides[2 * axis]), (-1, sides[2 * axis + 1])):
        if side == CLOSED:
            np.moveaxis(passes, axis, 0)[end] = False
    return passes


def _connect(run: np.ndarray, starts: np.ndarray, passes: list[np.ndarray], sides: SIX) -> tuple[int, np.ndarray]:
    """Return the number of connected parts and the part of each run of voxels along y."""
    pairs = []
    for axis in (0, 1):
        through, ids, begins = (np.moveaxis(array, axis, 0) for array in (passes[axis], run, starts))
        pairs.append(_pairs(ids[:-1], ids[1:], begins[:-1] | begins[1:], through[1:-1]))
        if sides[2 * axis] == WRAP:
            pairs.append(_pairs(ids[-1], ids[0], begins[-1] | begins[0], through[0]))
    if sides[4] == WRAP:
        pairs.append(np.stack([run[..., -1], run[..., 0]])[:, passes[2][..., 0]])
    first, second = np.concatenate([pair.reshape(2, -1) for pair in pairs], axis=1)
    count = int(run[-1, -1, -1]) + 1
    graph = coo_array((np.ones(len(first), bool), (first, second)), shape=(count, count))
    return connected_components(graph, directed=False)


def _pairs(a: np.ndarray, b: np.ndarray, begins: np.ndarray, through: np.ndarray) -> np.ndarray:
    """Return the runs that touch over open faces, once for each stretch of such faces along y."""
    news = through.copy()
    news[..., 1:] &= begins[..., 1:] | ~through[..., :-1]
    return np.stack([a[news], b[news]])
