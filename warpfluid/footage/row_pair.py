"""Row sums of two views over time, as two pictures of which one can be moved: how alike they are."""

from dataclasses import dataclass, replace

import numpy as np

from warpfluid.footage.row_sums import disagreement, rms

LARGEST_TIME = 60  # frames, and half of those there are
LARGEST_SHIFT = 0.15  # of the height
EDGE = 0.04  # of the height at either end is left out: there pictures are cut and faded
AS_GOOD, ALMOST_NOTHING = 1.01, 5e-4  # of the disagreement: what is so near is as good


@dataclass(frozen=True, kw_only=True)
class Match:
    """How row sums are brought to those of another view.

    Attributes:
        time: Play it later by this [step].
        shift: Move it up by this [row].
        scale: Draw it this much larger, about its middle.
        gain: Multiply its light by this.
        disagreement: Rms of the difference over the rms of both.
        correlation: Of both behind the match.
    """

    time: float = 0.0
    shift: float = 0.0
    scale: float = 1.0
    gain: float = 1.0
    disagreement: float = 2.0
    correlation: float = 0.0


class RowPair:
    """Two pictures of row sums over time, and how they compare when one of them is moved.

    What noise or haze adds to all rows alike does not count: the measure is the correlation.
    """

    def __init__(self, reference: np.ndarray, sums: np.ndarray):
        from scipy import ndimage

        self.reference, self.sums = reference, sums
        self._coefficients = ndimage.spline_filter(sums, mode="mirror")
        steps, rows = reference.shape
        self.middle, self.highest = (rows - 1) / 2, LARGEST_SHIFT * rows
        self.latest = min(LARGEST_TIME, steps // 2)
        self.edge = round(EDGE * rows)
        self.inner = np.zeros(rows, bool)
        self.inner[self.edge : rows - self.edge] = True

    def moved(self, match: Match) -> tuple[np.ndarray, np.ndarray]:
        """Return the other row sums when they are played as the match says, and which of them are there."""
        from scipy import ndimage

        steps, rows = self.reference.shape
        when = np.arange(steps) - match.time
        where = (np.arange(rows) - self.middle - match.shift) / match.scale + self.middle
        low, high = self.edge - 0.5, rows - self.edge - 0.5
        there = ((when > -0.01) & (when < steps - 0.99))[:, None] & ((where > low) & (where < high) & self.inner)
        places = np.meshgrid(when, where, indexing="ij")
        values = ndimage.map_coordinates(self._coefficients, places, mode="mirror", prefilter=False)
        return match.scale * np.maximum(values, 0), there

    def measured(self, match: Match) -> Match:
        """Return a match with its gain and what is left, but for what is added to all rows alike."""
        values, there = self.moved(match)
        a, b = self.reference[there], values[there]
        alike, spread = _correlation(a, b), b.std()
        if not spread > 0:
            return match
        left = float(np.sqrt(2 * max(1 - alike, 0.0)))
        return replace(match, gain=float(a.std() / spread), disagreement=left, correlation=alike)

    def whole(self, match: Match) -> Match:
        """Return a match with what is left of the row sums as they are; a gain near 1 that tells nothing becomes 1."""
        values, there = self.moved(match)
        a, b = self.reference[there], values[there]
        apart = [disagreement(a - a.mean(), gain * (b - b.mean())) for gain in (match.gain, 1.0)]
        gain = 1.0 if apart[1] <= AS_GOOD * apart[0] + 10 * ALMOST_NOTHING else match.gain
        return replace(match, gain=gain, disagreement=disagreement(a, gain * b))


def correlations(a: np.ndarray, inner: np.ndarray, b: np.ndarray, there: np.ndarray) -> np.ndarray:
    """Return the correlation of what two pictures have in common when the second is moved by every whole amount.

    Args:
        a: Shape (step, v).
        inner: Which of its rows count, shape (v,).
        b: Shape of the first.
        there: Where the second one is known.

    Returns:
        Shape (2 steps - 1, 2 v - 1); moved by nothing in the middle.
    """
    from scipy.signal import correlate

    def summed(x, y):
        return correlate(x, y, method="fft")

    size = np.sqrt(max(rms(a), 1e-9) * max(rms(b), 1e-9))
    a, b = np.where(inner, a, 0) / size, np.where(there, b, 0) / size
    ones, known = np.where(inner, np.ones_like(a), 0), there.astype(float)
    count = np.maximum(summed(ones, known), 1)
    mean_a, mean_b = summed(a, known) / count, summed(ones, b) / count
    both = summed(a, b) / count - mean_a * mean_b
    spread_a, spread_b = summed(a**2, known) / count - mean_a**2, summed(ones, b**2) / count - mean_b**2
    least = 1e-9 * (np.mean(a**2) + np.mean(b**2))
    return both / np.sqrt(np.maximum(spread_a, least) * np.maximum(spread_b, least))


def _correlation(a: np.ndarray, b: np.ndarray) -> float:
    """Return the correlation of numbers, 0 where either are all alike."""
    a, b = a - a.mean(), b - b.mean()
    size = rms(a) * rms(b)
    return float((a * b).mean() / size) if size > 0 else 0.0
