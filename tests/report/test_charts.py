"""Curves: to scale, inside their frame, with gaps where there is nothing to draw."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sound import Page

from warpfluid.report import charts

finite = st.floats(-1e6, 1e6).map(lambda value: round(value, 3))


@given(
    st.lists(st.tuples(*[st.floats(1e-12, 1e18)] * 2), min_size=1, max_size=12).map(np.array),
)
def test_energy_is_drawn_to_scale(energies):
    """Points stand in order, higher for more energy, in proportion to its logarithm, inside the frame."""
    svg = charts.energy_chart(energies)
    Page(svg)
    found = re.findall(r'<circle class="(\w)" cx="([\d.]+)" cy="([\d.]+)" r="4"><title>', svg)
    assert [step for step, _, _ in found] == ["m", "e"] * len(energies)
    x, y = np.array([[float(a), float(b)] for _, a, b in found]).T
    assert (np.diff(x) > 0).all()
    top, bottom = charts.TOP, charts.TOP + charts.HEIGHT
    assert y.min() >= top - 0.1
    assert y.max() <= bottom + 0.1
    lines = np.array(re.findall(r'y1="([\d.]+)"', svg), float)
    decades = np.log10(charts._log_ticks(energies.min(), energies.max()))
    slope = (lines[-1] - lines[0]) / (decades[-1] - decades[0])
    wanted = lines[0] + slope * (np.log10(energies.ravel()) - decades[0])
    np.testing.assert_allclose(y, wanted, atol=0.2)


def test_energies_that_have_no_logarithm_are_left_out():
    """Zeros and broken values leave gaps; with nothing left there is no chart."""
    svg = charts.energy_chart(np.array([[4.0, 0.0], [np.nan, 1.0]]))
    assert svg.count("<title>") == 2
    assert charts.energy_chart(np.zeros((3, 2))) == ""
    with pytest.raises(ValueError, match=r"\(4,\); \(iteration, 2\)"):
        charts.energy_chart(np.ones(4))


@given(st.dictionaries(st.integers(1, 2000), finite, min_size=2, max_size=12))
def test_numbers_over_frames_are_drawn_to_scale(values):
    """Points stand where their frame and their value say, on round lines, inside of the frame."""
    svg = charts.series_chart({"a": values}, "numbers")
    Page(svg)
    found = re.findall(r'<circle class="one" cx="([-\d.]+)" cy="([-\d.]+)" r="2.5"><title>frame (\d+):', svg)
    assert [int(frame) for _, _, frame in found] == list(values)
    lines = np.array(re.findall(r'y1="([-\d.]+)"', svg), float)
    ticks = charts.linear_ticks(min(values.values()), max(values.values()))
    assert len(lines) == len(ticks) <= 8
    x, y = np.array([[float(a), float(b)] for a, b, _ in found]).T
    slope = (lines[-1] - lines[0]) / (ticks[-1] - ticks[0])
    np.testing.assert_allclose(y, lines[0] + slope * (np.array(list(values.values())) - ticks[0]), atol=0.3)
    frames = np.array(list(values))
    across = charts.LEFT + 14 + (frames - frames.min()) / np.ptp(frames) * (charts.WIDTH - 28)
    np.testing.assert_allclose(x, across, atol=0.1)
    assert y.min() >= charts.TOP - 0.3
    assert y.max() <= charts.TOP + charts.LOW_HEIGHT + 0.3


@pytest.mark.parametrize(
    ("low", "high", "ticks"),
    [
        (0, 10, [0, 2, 4, 6, 8, 10]),
        (90, 100, [90, 92, 94, 96, 98, 100]),
        (3, 10, [0, 2, 4, 6, 8, 10]),
        (-1, 1, [-1, -0.5, 0, 0.5, 1]),
    ],
)
def test_lines_are_round(low, high, ticks):
    """With zero among them where the numbers come near it."""
    assert charts.linear_ticks(low, high) == pytest.approx(ticks)


def test_one_value_all_along():
    """A constant has an axis, too; a single frame has no curve."""
    assert "polyline" in charts.series_chart({"": {1: 5.0, 2: 5.0}}, "numbers")
    assert "polyline" in charts.series_chart({"": {1: 0.0, 2: 0.0}}, "numbers")
    assert charts.series_chart({"": {1: 5.0}}, "numbers") == ""
    assert charts.series_chart({"": {1: 5.0, 2: np.nan}}, "numbers") == ""
    assert charts.series_chart({}, "numbers") == ""


def test_curves_have_their_names_and_colours():
    """A legend for two, none for one without a name; the unit stands at the right."""
    svg = charts.series_chart({"a<b": {1: 1.0, 2: 2.0}, "c": {1: 2.0, 3: 1.0}}, "x<y", unit=" dB")
    assert "a<b" in Page(svg).words
    assert 'aria-label="x&lt;y"' in svg
    assert "a&lt;b" in svg
    assert svg.count('class="curve one"') == svg.count('class="curve two"') == 1
    assert ">dB</text>" in svg
