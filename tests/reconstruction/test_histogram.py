"""Mixtures of histograms (Eq. 4) against cumulative distributions, and matching."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warpfluid.reconstruction.histogram import MIXTURES, match, rank_grid

PARTS = [0.0, 0.2, 0.5, 0.9, 1.0]


def sample(count, seed, black=0.0):
    """Sorted values as bands and pictures have them; a share of them black."""
    rng = np.random.default_rng(seed)
    values = rng.gamma(0.7, 60, count)
    values[: int(round(black * count))] = 0
    return np.sort(values).astype(np.float32)


def levels(count):
    return (np.arange(count) + 0.5) / count


def below(values, at):
    """Cumulative distribution: the share of values up to each place."""
    return np.searchsorted(values, at, side="right") / values.size


def matched(values, target_sample, **options):
    """Match one row to all the quantiles of a sample of any size."""
    ranks = rank_grid(values.size)
    at = (ranks + 0.5) / values.size
    target = np.quantile(target_sample, at, method="hazen").astype(np.float32)
    return match(values[None].astype(np.float32), target[None], ranks, **options)[0]


@given(
    count=st.integers(2, 400),
    other=st.integers(2, 400),
    part=st.floats(0, 1),
    black=st.tuples(st.floats(0, 1), st.floats(0, 1)),
    seed=st.integers(0, 99),
)
@settings(max_examples=60)
def test_density_mixes_cumulative_distributions(count, other, part, black, seed):
    """Every quantile is the smallest value at which the mixture of the inputs' distributions reaches its level."""
    p, r = sample(count, seed, black[0]), sample(other, seed + 1, black[1])
    at = levels(300)
    (found,) = MIXTURES["density"](p, r, np.array([part]), at)
    reached = (1 - part) * below(p, found) + part * below(r, found)
    before = np.nextafter(found, np.float32(-np.inf))
    missed = (1 - part) * below(p, before) + part * below(r, before)
    assert (reached >= at - 1e-6).all()
    assert (missed <= at + 1e-6).all()
    assert (np.diff(found) >= 0).all()


@pytest.mark.parametrize("name", MIXTURES)
def test_the_ends_are_the_inputs(name):
    """At an input's own angle the target is that input."""
    p, r = sample(500, 0, 0.3), sample(500, 1, 0.6)
    first, last = MIXTURES[name](p, r, np.array([0.0, 1.0]), levels(500))
    np.testing.assert_allclose(first, p, atol=1e-3)
    np.testing.assert_allclose(last, r, atol=1e-3)


@pytest.mark.parametrize("name", ["density", "hybrid"])
def test_the_share_of_black_mixes_linearly(name):
    """It is what rounds the silhouette."""
    p, r = sample(1000, 0, 0.3), sample(1000, 1, 0.7)
    found = MIXTURES[name](p, r, np.array(PARTS), levels(1000))
    np.testing.assert_allclose((found == 0).mean(axis=1), 0.3 + 0.4 * np.array(PARTS), atol=2e-3)


@pytest.mark.parametrize("name", ["density", "quantile", "hybrid"])
def test_the_mean_mixes_linearly(name):
    """No light is gained or lost between views."""
    p, r = sample(2000, 0, 0.2), sample(2000, 1, 0.5)
    found = MIXTURES[name](p, r, np.array(PARTS), levels(2000)).mean(axis=1)
    expected = p.mean() + (r.mean() - p.mean()) * np.array(PARTS)
    np.testing.assert_allclose(found, expected, rtol=3e-3)


def test_quantiles_mix_between_equal_ranks():
    """The 1-D Wasserstein barycentre."""
    p, r = sample(400, 0), sample(400, 1)
    (found,) = MIXTURES["quantile"](p, r, np.array([0.25]), levels(400))
    np.testing.assert_allclose(found, 0.75 * p + 0.25 * r, rtol=1e-5)


def test_hybrid_mixes_black_against_lit():
    """A black view fades a lit one in by area, at full brightness."""
    p, r = np.zeros(400, np.float32), sample(400, 1) + 50
    (found,) = MIXTURES["hybrid"](p, r, np.array([0.5]), levels(400))
    assert (found == 0).mean() == pytest.approx(0.5, abs=5e-3)
    assert found[found > 0].min() >= 50


def test_nearest_takes_one_input():
    """Whole, never both."""
    p, r = sample(400, 0), sample(400, 1)
    found = MIXTURES["nearest"](p, r, np.array([0.1, 0.49, 0.51, 0.9]), levels(400))
    np.testing.assert_allclose(found, [p, p, r, r], rtol=1e-5)


@given(count=st.integers(1, 200_000))
def test_rank_grid(count):
    """Both ends, no rank twice, about a thousand, all of them for small bands."""
    ranks = rank_grid(count)
    assert ranks[0] == 0
    assert ranks[-1] == count - 1
    assert (np.diff(ranks) > 0).all()
    assert len(ranks) == count if count <= 1024 else 1024 <= len(ranks) <= 1100


@pytest.mark.parametrize("count", [10, 1000, 20_000])
def test_equal_distributions_give_the_identity(count):
    """Nothing is amplified that is right already."""
    values = np.random.default_rng(0).standard_normal(count).astype(np.float32) * 30
    np.testing.assert_allclose(matched(values, values), values, atol=1e-3)


@given(count=st.integers(2, 3000), grey=st.integers(2, 300), seed=st.integers(0, 99), keep_zero=st.booleans())
@settings(max_examples=60)
def test_is_one_monotone_function_of_the_value(count, grey, seed, keep_zero):
    """Equal values stay equal and order is kept: no speckle from ties, whatever the order of the pixels."""
    rng = np.random.default_rng(seed)
    values = rng.integers(-grey // 3, grey, count).astype(np.float32)
    target = sample(500, seed, 0.4)
    found = matched(values, target, keep_zero=keep_zero)
    distinct, first = np.unique(values, return_index=True)
    np.testing.assert_array_equal(found, found[first][np.searchsorted(distinct, values)])
    assert (np.diff(found[first]) >= -1e-4).all()
    order = rng.permutation(count)
    np.testing.assert_array_equal(matched(values[order], target, keep_zero=keep_zero), found[order])


@pytest.mark.parametrize("count", [900, 20_000])
def test_the_distribution_is_reached(count):
    """To a fraction of the target's spread, everywhere."""
    values = np.random.default_rng(0).standard_normal(count)
    target = sample(count, 1)
    found = np.sort(matched(values, target))
    assert np.abs(found - target).mean() < 0.01 * target.std()
    assert found[-1] == pytest.approx(target[-1], rel=1e-3)


def test_black_stays_black():
    """Values up to 0 map to 0, exactly."""
    values = np.random.default_rng(0).standard_normal(5000).astype(np.float32)
    found = matched(values, sample(5000, 1) + 20, keep_zero=True)
    assert not found[values <= 0].any()
    assert found[values > 0.1].min() > 0


def test_a_constant_band_takes_the_targets_mean():
    """There is no order to keep; a black one stays black."""
    target = sample(800, 1)
    np.testing.assert_allclose(matched(np.full(800, 7.0), target), target.mean(), rtol=1e-5)
    assert not matched(np.zeros(800), target, keep_zero=True).any()
    assert not matched(np.full(800, -1.0), target, keep_zero=True).any()


def test_two_grey_levels_take_the_means_of_their_shares():
    """The lower quarter of the target, and the rest."""
    values = np.repeat([3.0, 9.0], [200, 600])
    target = sample(800, 1)
    found = matched(np.random.default_rng(0).permutation(values), target)
    assert np.unique(found) == pytest.approx([target[:200].mean(), target[200:].mean()], rel=1e-4)


def test_rows_are_matched_one_by_one():
    """Views do not mix."""
    values = np.random.default_rng(0).standard_normal((3, 2000)).astype(np.float32)
    ranks = rank_grid(2000)
    target = np.stack([sample(2000, seed)[ranks] for seed in range(3)])
    found = match(values, target, ranks)
    for row in range(3):
        np.testing.assert_array_equal(match(values[row : row + 1], target[row : row + 1], ranks)[0], found[row])


def test_a_thin_view_next_to_a_wide_one_keeps_its_background():
    """78 % black against 64 % black: no pixel lights up, and the light is not far from the target's."""
    values, target = sample(39_024, 0, 0.78), sample(39_024, 1, 0.64)
    found = matched(np.random.default_rng(2).permutation(values), target, keep_zero=True)
    assert (found == 0).mean() == pytest.approx(0.78, abs=1e-3)
    assert 0.7 < found.sum() / target.sum() < 1.05
