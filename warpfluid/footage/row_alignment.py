"""When, how high, how large and how bright a view must be played for its row sums to be those of another.

Light that no medium absorbs has the same total in every image row of every view, at every moment. The picture of these
totals over time is cross-correlated with that of the other view on a grid of offsets, shifts and sizes; the best of
them are refined, and of what fits as well the simplest is taken: a steady flame fits at any time.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from warpfluid.footage.row_sums import disagreement, rms

FEWEST_FRAMES = 8
LARGEST_TIME = 60  # frames, and half of those there are
LARGEST_SHIFT = 0.15  # of the height
SIZES = 1 + 0.03 * np.arange(-4, 5)  # tried first
LARGEST_SIZE = 0.15  # more or less
MOST_ROWS = 400  # finer ones are averaged
CONTENDERS = 5  # other offsets in time that are refined
EDGE = 0.04  # of the height at either end is left out: there pictures are cut and faded
FLAT = 0.03  # standard deviation of row sums over their mean
LEAST_CORRELATION = 0.85
MOST_DISAGREEMENT = 0.35
AS_GOOD, ALMOST_NOTHING = 1.01, 5e-4  # of the disagreement: what is so near is as good
NOTHING = {"time": 0.0, "shift": 0.0, "scale": 1.0}


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


def match_row_sums(
    reference: np.ndarray, sums: np.ndarray, fixed: dict[str, float] | None = None, *, subframe: bool = False
) -> Match:
    """Return how row sums are best brought to those of another view.

    Args:
        reference: Row sums of the first view, shape (step, v).
        sums: Those of another view, same shape.
        fixed: ``time``, ``shift`` or ``scale`` where they are known.
        subframe: Find parts of steps, too.

    Raises:
        ValueError: If there is nothing to go by: too few steps, rows all alike, or no agreement.
    """
    fixed = fixed or {}
    _check(reference, sums)
    bins = max(1, -(-reference.shape[1] // MOST_ROWS))
    pair = _Pair(*(_averaged(values, bins) for values in (reference, sums)))
    fixed = fixed | ({"shift": fixed["shift"] / bins} if "shift" in fixed else {})
    found = [_refine(pair, start, fixed) for start in _contenders(pair, fixed)]
    found = _simplest(found, lambda match: abs(match.time))
    if subframe and "time" not in fixed:
        found = _simplest([found, _refine(pair, found, fixed, subframe=True)], lambda match: match.time % 1 != 0)
    plain = [_refine(pair, found, {"time": found.time} | kept | fixed) for kept in _plainer()]
    found = _simplest([found, *plain], lambda match: (match.scale != 1) + (match.shift != 0))
    _check_found(found, pair)
    return replace(pair.whole(found), shift=found.shift * bins)


class _Pair:
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


def _contenders(pair: _Pair, fixed: dict[str, float]) -> list[Match]:
    """Return the best matches of whole steps and rows, each at its own time."""
    steps, rows = pair.reference.shape
    shifts, best = _shifts(pair, fixed), {}
    for scale in [fixed["scale"]] if "scale" in fixed else SIZES:
        alike = _correlations(pair.reference, pair.inner, *pair.moved(Match(scale=scale)))
        for time in _times(pair, fixed):
            line = alike[steps - 1 + time, rows - 1 + shifts]
            if line.max() > best.get(time, (-1.0,))[0]:
                shift = fixed.get("shift", float(shifts[line.argmax()]))
                best[time] = float(line.max()), Match(time=time, shift=shift, scale=float(scale))
    ranked = sorted(best, key=lambda time: (time != 0, -best[time][0]))  # to leave the time alone is always tried
    return [best[time][1] for time in ranked[: CONTENDERS + 1]]


def _correlations(a: np.ndarray, inner: np.ndarray, b: np.ndarray, there: np.ndarray) -> np.ndarray:
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


def _times(pair: _Pair, fixed: dict[str, float]) -> Iterator[int]:
    return iter([round(fixed["time"])] if "time" in fixed else range(-pair.latest, pair.latest + 1))


def _shifts(pair: _Pair, fixed: dict[str, float]) -> np.ndarray:
    if "shift" in fixed:
        return np.array([round(fixed["shift"])])
    return np.arange(-int(pair.highest), int(pair.highest) + 1)


def _refine(pair: _Pair, start: Match, fixed: dict[str, float], *, subframe: bool = False) -> Match:
    """Return the match with the least disagreement near a first one; its time stays unless parts are wanted."""
    from scipy.optimize import minimize

    start = replace(start, **fixed)
    size = len(pair.reference[0]) / 2  # rows that move by one when the scale changes by 1 / size
    free = [name for name in ("shift", "scale") if name not in fixed] + ["time"] * subframe
    units = {"shift": 1.0, "scale": 1 / size, "time": 0.5}
    if not free:
        return pair.measured(start)

    def at(steps: np.ndarray) -> Match:
        moves = {name: getattr(start, name) + units[name] * float(s) for name, s in zip(free, steps, strict=True)}
        return replace(start, **moves)

    def cost(steps: np.ndarray) -> float:
        match = at(steps)
        out = abs(match.shift) > pair.highest + 1 or abs(match.scale - 1) > LARGEST_SIZE + 0.01
        return 2.0 if out or abs(match.time - start.time) > 1 else pair.measured(match).disagreement

    simplex = np.vstack([np.zeros(len(free)), np.eye(len(free))])
    limits = {"xatol": 0.004, "fatol": 1e-7, "initial_simplex": simplex, "maxiter": 120}
    return pair.measured(at(minimize(cost, simplex[0], method="Nelder-Mead", options=limits).x))


def _plainer() -> list[dict[str, float]]:
    """Return what is tried without: a change of size, a shift, both."""
    shift, scale = ({name: NOTHING[name]} for name in ("shift", "scale"))
    return [scale, shift, shift | scale]


def _simplest(matches: list[Match], rank) -> Match:
    """Return the match of the lowest rank among those that fit about as well as the best."""
    enough = AS_GOOD * min(match.disagreement for match in matches) + ALMOST_NOTHING
    return min(
        (m for m in matches if m.disagreement <= enough),
        key=lambda match: (rank(match), match.disagreement),
    )


def _averaged(values: np.ndarray, bins: int) -> np.ndarray:
    """Average rows in groups; what does not fill the last one is left out at both ends."""
    kept = values.shape[1] // bins * bins
    start = (values.shape[1] - kept) // 2
    return values[:, start : start + kept].reshape(len(values), -1, bins).mean(axis=2)


def _correlation(a: np.ndarray, b: np.ndarray) -> float:
    """Return the correlation of numbers, 0 where either are all alike."""
    a, b = a - a.mean(), b - b.mean()
    size = rms(a) * rms(b)
    return float((a * b).mean() / size) if size > 0 else 0.0


def _check(reference: np.ndarray, sums: np.ndarray) -> None:
    """Refuse row sums that tell nothing."""
    if len(sums) < FEWEST_FRAMES:
        raise ValueError(f"{len(sums)} frames are too few to compare, at least {FEWEST_FRAMES} are needed")
    for values, name in ((reference, "the first view"), (sums, "it")):
        if values.std() <= FLAT * values.mean():
            raise ValueError(
                f"the rows of {name} are all alike, within {values.std() / max(values.mean(), 1e-9):.0%}: "
                "take the background off with --black-level or --background"
            )


def _check_found(match: Match, pair: _Pair) -> None:
    """Refuse a match that is none."""
    at_end = abs(match.shift) >= pair.highest or abs(match.scale - 1) >= LARGEST_SIZE
    if match.correlation < LEAST_CORRELATION or match.disagreement > MOST_DISAGREEMENT or at_end:
        raise ValueError(
            f"the best that was found leaves its rows {match.disagreement:.0%} apart (at most {MOST_DISAGREEMENT:.0%} is "
            f"taken), correlation {match.correlation:.2f} (at least {LEAST_CORRELATION}), within {pair.latest} frames, "
            f"{LARGEST_SHIFT:.0%} of the height and {LARGEST_SIZE:.0%} of the size"
        )
