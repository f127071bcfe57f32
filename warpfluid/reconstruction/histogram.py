"""Histograms as sorted values: interpolation between two views (Eq. 4) and matching (Fig. 5).

A histogram is kept without bins. Where the paper mixes the bins of two inputs, the mixture here is the pooled sample
with weights, which is the limit of infinitely many bins: no bin count to choose, and the black background, an atom at
zero that a binned inverse would smear, stays exact. Distributions are read at some thousand ranks, uniform in the
bulk and geometric towards both tails, where the few extreme coefficients make the visible filaments.
"""

import numpy as np

RANKS = 1024
NODES = 1024


def rank_grid(count: int, ranks: int = RANKS) -> np.ndarray:
    """Return about ``ranks`` ranks of 0 .. count - 1, dense towards both tails."""
    if count <= ranks:
        return np.arange(count)
    step = count / ranks
    tail = np.unique(np.rint(np.geomspace(1, step, 24)))
    grid = np.concatenate([[0], tail, np.arange(1, ranks) * step, count - 1 - tail, [count - 1]])
    return np.unique(np.clip(np.rint(grid).astype(int), 0, count - 1))


def density_mixture(p: np.ndarray, r: np.ndarray, parts: np.ndarray, levels: np.ndarray) -> np.ndarray:
    """Mix the densities of two samples, as Eq. 4 mixes bins.

    Args:
        p: First sample, sorted.
        r: Second sample, sorted.
        parts: Weight of the second sample in every mixture, 0 to 1.
        levels: Probabilities at which the mixtures are read.

    Returns:
        Quantiles, shape (parts, levels).
    """
    pool = np.concatenate([p, r])
    order = np.argsort(pool, kind="stable")
    pool, from_r = pool[order], order >= p.size
    below_p, below_r = np.cumsum(~from_r) / p.size, np.cumsum(from_r) / r.size
    out = np.empty((len(parts), len(levels)), np.float32)
    for row, part in zip(out, parts, strict=True):
        index = np.searchsorted((1 - part) * below_p + part * below_r, levels - 1e-9)
        row[:] = pool[np.minimum(index, pool.size - 1)]
    return out


def quantile_mixture(p: np.ndarray, r: np.ndarray, parts: np.ndarray, levels: np.ndarray) -> np.ndarray:
    """Mix the quantiles of two samples (1-D Wasserstein barycentre); shapes as in ``density_mixture``."""
    parts = np.asarray(parts, np.float32)[:, None]
    return ((1 - parts) * _quantiles(p, levels) + parts * _quantiles(r, levels)).astype(np.float32)


def hybrid_mixture(p: np.ndarray, r: np.ndarray, parts: np.ndarray, levels: np.ndarray) -> np.ndarray:
    """Mix the share of black as mass and what is lit as quantiles; shapes as in ``density_mixture``."""
    lit_p, lit_r = p[p > 0], r[r > 0]
    share_p, share_r = lit_p.size / p.size, lit_r.size / r.size
    out = np.zeros((len(parts), len(levels)), np.float32)
    for row, part in zip(out, parts, strict=True):
        a, b = (1 - part) * share_p, part * share_r
        if a + b <= 0:
            continue
        within = (levels - (1 - a - b)) / (a + b)
        lit = within > 0
        total = np.zeros(int(lit.sum()))
        for weight, sample in ((a, lit_p), (b, lit_r)):
            if weight > 0:
                total += weight * _quantiles(sample, within[lit])
        row[lit] = total / (a + b)
    return out


def nearest_mixture(p: np.ndarray, r: np.ndarray, parts: np.ndarray, levels: np.ndarray) -> np.ndarray:
    """Take the nearer sample unmixed; shapes as in ``density_mixture``."""
    near = (np.asarray(parts) < 0.5)[:, None]
    return np.where(near, _quantiles(p, levels), _quantiles(r, levels)).astype(np.float32)


MIXTURES = {
    "density": density_mixture,
    "quantile": quantile_mixture,
    "hybrid": hybrid_mixture,
    "nearest": nearest_mixture,
}


def match(values: np.ndarray, target: np.ndarray, ranks: np.ndarray, *, keep_zero: bool = False) -> np.ndarray:
    """Give rows of values a target distribution by a monotone function of the value.

    The function runs through (source at a rank, target at that rank). Equal values stay equal, so there is no order of
    ties and no speckle; equal distributions give the identity; rounding noise is not amplified.

    Args:
        values: Shape (rows, count).
        target: Target quantiles at ``ranks``, shape (rows, ranks).
        ranks: Ranks among ``count``, from ``rank_grid``.
        keep_zero: Map values <= 0 to 0, so that a black background stays black.

    Returns:
        The matched values, shape of ``values``.
    """
    nodes = np.sort(values, axis=-1)[:, ranks]
    out = np.empty(values.shape, np.float32)
    for row, source, k, q in zip(out, values, nodes, target, strict=True):
        _match_row(source, k, q, keep_zero, row)
    return out


def _match_row(source: np.ndarray, k: np.ndarray, q: np.ndarray, keep_zero: bool, out: np.ndarray) -> None:
    k, q = _merge_ties(k, q)
    if keep_zero:
        q = np.where(k <= 0, 0.0, q)
    low, high = float(k[0]), float(k[-1])
    if not high > low:
        out[:] = 0.0 if keep_zero and high <= 0 else q.mean()
        return
    table = np.interp(np.linspace(low, high, NODES + 1), k, q).astype(np.float32)
    position = (source - np.float32(low)) * np.float32(NODES / (high - low))
    np.clip(position, 0, NODES, out=position)
    node = position.astype(np.int32)
    position -= node
    position *= np.diff(table, append=table[-1])[node]
    np.add(position, table[node], out=out)
    if keep_zero:
        out *= source > 0


def _merge_ties(k: np.ndarray, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Give equal source values the mean of their targets."""
    new = np.concatenate([[True], k[1:] > k[:-1]])
    if new.all():
        return k, q
    starts = np.flatnonzero(new)
    return k[starts], np.add.reduceat(q.astype(np.float64), starts) / np.diff(np.append(starts, k.size))


def _quantiles(sample: np.ndarray, levels: np.ndarray) -> np.ndarray:
    position = np.clip(np.asarray(levels) * sample.size - 0.5, 0, sample.size - 1)
    return np.interp(position, np.arange(sample.size), sample)


def mix_neighbours(
    band: np.ndarray, left: np.ndarray, parts: np.ndarray, mixture: str
) -> tuple[np.ndarray, np.ndarray]:
    """Return the values that the views of a fan should have, each mixed of its two neighbours'.

    Args:
        band: Of the inputs, or one band of their pyramids, shape (input, rows, columns).
        left: Left neighbour of each view of the fan.
        parts: How far each view is on the way to the right one, 0 to 1.
        mixture: A key of ``MIXTURES``.

    Returns:
        The sorted values of each view, and the ranks that they have.
    """
    values = np.sort(band.reshape(len(band), -1), axis=-1)
    ranks = rank_grid(values.shape[1])
    levels = (ranks + 0.5) / values.shape[1]
    mixed = np.empty((len(left), levels.size), np.float32)
    for pair in np.unique(left):
        at = np.flatnonzero(left == pair)
        mixed[at] = MIXTURES[mixture](values[pair], values[pair + 1], parts[at], levels)
    return mixed, ranks
