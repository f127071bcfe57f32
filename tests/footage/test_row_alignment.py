"""Known offsets, shifts, sizes and exposures are found from row sums, and what is aligned is left alone."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warpfluid.footage.row_alignment import match_row_sums

STEPS, ROWS = 20, 72


def light(steps, rows):
    """Row sums at any moments and heights: puffs that rise at their own speeds over a base that flickers."""
    rng = np.random.default_rng(3)
    t, v = np.meshgrid(steps, rows, indexing="ij")
    sums = 900 * np.exp(-(((v - 8) / 9) ** 2)) * (1 + 0.2 * np.sin(1.7 * t))
    for _ in range(14):
        start, speed, bright, wide = rng.uniform((-40, 1, 300, 3), (70, 4, 1200, 7))
        sums += bright * np.exp(-(((v - start - speed * t) / wide) ** 2))
    return sums


def other(time=0.0, shift=0.0, scale=1.0, gain=1.0, noise=0.0):
    """Row sums of a view that is put right by playing it later, moving it up, enlarging and brightening it."""
    middle = (ROWS - 1) / 2
    rows = (np.arange(ROWS) - middle) * scale + middle + shift
    sums = light(np.arange(STEPS) + time, rows) / (gain * scale)
    return sums + noise * np.random.default_rng(0).standard_normal(sums.shape)


REFERENCE = light(np.arange(STEPS), np.arange(ROWS))


@settings(deadline=None, max_examples=14)
@given(
    time=st.integers(-5, 5),
    shift=st.one_of(st.floats(0.5, 4), st.floats(-4, -0.5), st.just(0.0)),
    scale=st.one_of(st.floats(0.95, 1.05), st.just(1.0)),
    gain=st.floats(0.7, 1.4),
    noise=st.sampled_from([0.0, 10.0]),
)
def test_what_is_known_is_found(time, shift, scale, gain, noise):
    """To the frame, a fifth of a pixel, half a per cent of the size and two of the light."""
    found = match_row_sums(REFERENCE, other(time, shift, scale, gain, noise))
    assert found.time == time
    assert found.shift == pytest.approx(shift, abs=0.2)
    assert found.scale == pytest.approx(scale, abs=0.005)
    assert found.gain == pytest.approx(gain, rel=0.02)
    assert found.correlation > 0.99
    assert found.disagreement < 0.01 + 0.1 * (noise > 0)


@settings(deadline=None, max_examples=6)
@given(st.floats(-4.5, 4.5), st.floats(-3, 3))
def test_parts_of_frames(time, shift):
    """A third of a frame is told from none when it is asked for."""
    found = match_row_sums(REFERENCE, other(time, shift, 1.0, 0.8, 5.0), subframe=True)
    assert found.time == pytest.approx(time, abs=0.06)
    assert found.shift == pytest.approx(shift, abs=0.2)


@pytest.mark.parametrize("noise", [0, 10])
def test_aligned_views_are_left_alone(noise):
    """Exactly, with parts of frames looked for and without."""
    for subframe in (False, True):
        found = match_row_sums(REFERENCE, other(noise=noise), subframe=subframe)
        assert (found.time, found.shift, found.scale, found.gain) == (0, 0, 1, 1)


def test_what_gains_little_is_not_done():
    """Views that disagree by their nature are not moved for a twentieth of it."""
    wavy = 1 + 0.2 * np.sin(np.arange(ROWS) / 3 + np.arange(STEPS)[:, None] / 2)
    found = match_row_sums(REFERENCE, REFERENCE * wavy, subframe=True)
    assert 0.08 < found.disagreement < 0.3
    assert (found.time, found.shift, found.scale) == (0, 0, 1)


def test_haze_over_all_rows_does_not_mislead():
    """What a grey background adds to one view changes neither gain nor place."""
    found = match_row_sums(REFERENCE, other(2, 1.5, 1.0, 1.3) + 150)
    assert found.time == 2
    assert found.shift == pytest.approx(1.5, abs=0.1)
    assert found.gain == pytest.approx(1.3, rel=0.01)


def test_a_steady_flame_fits_at_any_time():
    """Where every offset does as well, none is made."""
    still = np.repeat(REFERENCE[:1], STEPS, axis=0)
    found = match_row_sums(still, still / 2)
    assert (found.time, found.shift, found.scale) == (0, 0, 1)
    assert found.gain == pytest.approx(2)


def test_what_is_fixed_stays():
    """The rest is found around it."""
    found = match_row_sums(REFERENCE, other(3, 2.0, 1.03, 0.8), {"time": 3.0, "scale": 1.03})
    assert (found.time, found.scale) == (3, 1.03)
    assert found.shift == pytest.approx(2, abs=0.1)
    found = match_row_sums(REFERENCE, other(3, 2.0), {"shift": 2.0})
    assert (found.time, found.shift) == (3, 2)


def test_many_rows():
    """Tall footage is averaged, and the shift still counts in its own rows."""
    fine = np.repeat(REFERENCE, 10, axis=1)
    found = match_row_sums(fine, np.roll(fine, -20, axis=1))
    assert found.shift == pytest.approx(20, abs=1)


@pytest.mark.parametrize(
    ("reference", "sums", "words"),
    [
        (REFERENCE[:5], REFERENCE[:5], "5 frames are too few"),
        (REFERENCE, np.ones_like(REFERENCE), "rows of it are all alike"),
        (np.zeros_like(REFERENCE), REFERENCE, "rows of the first view are all alike"),
        (REFERENCE, REFERENCE[::-1, ::-1], "correlation 0."),
        (REFERENCE, other(0, 25), "of the height"),
    ],
)
def test_what_tells_nothing_is_refused(reference, sums, words):
    """With what was found."""
    with pytest.raises(ValueError, match=words):
        match_row_sums(reference, sums)


@pytest.mark.parametrize(("noise", "time"), [(0.0015, 0), (0.05, 20)])
def test_the_coding_of_a_video_moves_nothing(noise, time):
    """Where the light repeats, only noise tells one time from another: that of coding does not count."""
    rows = np.arange(40)
    puffs = [np.exp(-(((rows - middle) / 6) ** 2)) for middle in (15, 25)]
    sums = np.array([puffs[frame % 2] for frame in range(80)])
    sums += noise * sums.std() * np.random.default_rng(1).standard_normal(sums.shape)
    assert match_row_sums(sums[:-20], sums[20:]).time == time
