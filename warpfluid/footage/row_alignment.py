"""When, how high, how large and how bright a view must be played for its row sums to be those of another.

Light that no medium absorbs has the same total in every image row of every view, at every moment. The picture of these
totals over time is cross-correlated with that of the other view on a grid of offsets, shifts and sizes; the best of
them are refined, and whatever is done to the view must be worth its while: a steady flame fits at any time.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from warpfluid.footage.row_pair import LARGEST_SHIFT, Match, RowPair, correlations

FEWEST_FRAMES = 8
SIZES = 1 + 0.03 * np.arange(-4, 5)  # tried first
LARGEST_SIZE = 0.15  # more or less
MOST_ROWS = 400  # finer ones are averaged
CONTENDERS = 5  # other offsets in time that are refined
WORTH = 0.05  # share of the disagreement that a move must take away
NOISE = 3e-3  # disagreement that it must take away besides: what a video's coding leaves fits better here or there
FLAT = 0.03  # standard deviation of row sums over their mean
LEAST_CORRELATION = 0.85
MOST_DISAGREEMENT = 0.35
NOTHING = {"time": 0.0, "shift": 0.0, "scale": 1.0}


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
    pair = RowPair(*(_averaged(values, bins) for values in (reference, sums)))
    fixed = fixed | ({"shift": fixed["shift"] / bins} if "shift" in fixed else {})
    models = [{"shift", "scale"}, {"shift"}, {"scale"}, set()]
    found = min(
        (_refine(pair, start, fixed, free) for start in _contenders(pair, fixed) for free in models), key=_score
    )
    if subframe and "time" not in fixed:
        parts = [_refine(pair, found, fixed, free | {"time"}) for free in models if "shift" in free or not free]
        found = min([found, *parts], key=_score)
    _check_found(found, pair)
    return replace(pair.whole(found), shift=found.shift * bins)


def _contenders(pair: RowPair, fixed: dict[str, float]) -> list[Match]:
    """Return the best matches of whole steps and rows, each at its own time."""
    steps, rows = pair.reference.shape
    shifts, best = _shifts(pair, fixed), {}
    for scale in [fixed["scale"]] if "scale" in fixed else SIZES:
        alike = correlations(pair.reference, pair.inner, *pair.moved(Match(scale=scale)))
        for time in _times(pair, fixed):
            line = alike[steps - 1 + time, rows - 1 + shifts]
            if line.max() > best.get(time, (-1.0,))[0]:
                shift = fixed.get("shift", float(shifts[line.argmax()]))
                best[time] = float(line.max()), Match(time=time, shift=shift, scale=float(scale))
    ranked = sorted(best, key=lambda time: (time != 0, -best[time][0]))  # to leave the time alone is always tried
    return [best[time][1] for time in ranked[: CONTENDERS + 1]]


def _times(pair: RowPair, fixed: dict[str, float]) -> Iterator[int]:
    return iter([round(fixed["time"])] if "time" in fixed else range(-pair.latest, pair.latest + 1))


def _shifts(pair: RowPair, fixed: dict[str, float]) -> np.ndarray:
    if "shift" in fixed:
        return np.array([round(fixed["shift"])])
    return np.arange(-int(pair.highest), int(pair.highest) + 1)


def _refine(pair: RowPair, start: Match, fixed: dict[str, float], free: set[str]) -> Match:
    """Return the match with the least disagreement near a first one, in what is free; the rest is left undone.

    Args:
        pair: What is compared.
        start: Its time stays unless that is free.
        fixed: What is known.
        free: Names that may change, those that are not known.
    """
    from scipy.optimize import minimize

    start = replace(start, **{name: NOTHING[name] for name in {"shift", "scale"} - free} | fixed)
    free = sorted(free - set(fixed))
    units = {"shift": 1.0, "scale": 2 / len(pair.inner), "time": 0.5}  # of about one row each
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


def _score(match: Match) -> float:
    """Return the disagreement, and a little for everything that is done to the view: it must be worth its while."""
    done = sum(getattr(match, name) != nothing for name, nothing in NOTHING.items())
    return match.disagreement * (1 + WORTH * done) + NOISE * done


def _averaged(values: np.ndarray, bins: int) -> np.ndarray:
    """Average rows in groups; what does not fill the last one is left out at both ends."""
    kept = values.shape[1] // bins * bins
    start = (values.shape[1] - kept) // 2
    return values[:, start : start + kept].reshape(len(values), -1, bins).mean(axis=2)


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


def _check_found(match: Match, pair: RowPair) -> None:
    """Refuse a match that is none."""
    at_end = abs(match.shift) >= pair.highest or abs(match.scale - 1) >= LARGEST_SIZE
    if match.correlation < LEAST_CORRELATION or match.disagreement > MOST_DISAGREEMENT or at_end:
        raise ValueError(
            f"the best found leaves its rows {match.disagreement:.0%} apart (at most {MOST_DISAGREEMENT:.0%}), "
            f"correlation {match.correlation:.2f} (at least {LEAST_CORRELATION}), within {pair.latest} frames, "
            f"{LARGEST_SHIFT:.0%} of the height and {LARGEST_SIZE:.0%} of the size"
        )
