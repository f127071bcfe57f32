"""The lattice that random waves live on, and the waves themselves."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from warpfluid.kernels.forces.random_waves import (
    NODES_A_WAVE,
    TILE,
    curl_size,
    draw_tiles,
    lay_lattice,
    make_waves,
    window,
)
from warpfluid.kernels.forces.turbulence import FINEST


@given(cells=st.tuples(*[st.integers(1, 900)] * 3), frequency=st.floats(1e-4, FINEST))
def test_a_lattice_fits_where_the_box_wraps(cells, frequency):
    """A whole number of periods fill the box; nodes are near what was asked for, never too many for a run."""
    lattice = lay_lattice(cells, frequency, (True, False, True))
    asked = 1 / (NODES_A_WAVE * frequency)
    for axis, n in enumerate(cells):
        nodes, spacing = lattice.nodes[axis], lattice.spacing[axis]
        periods = n / (nodes * spacing)
        assert nodes <= TILE
        assert spacing >= min(0.8, n) * (1 - 1e-6)
        assert axis == 1 or periods == pytest.approx(round(periods))
        assert nodes == 1 or asked * (1 - 1e-6) <= spacing <= 1.5 * asked
    assert lattice.nodes[1] == TILE
    assert lattice.stretch(frequency)[1] == 1


@pytest.mark.parametrize("phase", [0.0, 3.7])
@pytest.mark.parametrize(("nodes", "stretch"), [((64, 64, 64), (1, 1, 1)), ((32, 48, 45), (1.1, 1, 1.05))])
def test_the_transform_is_as_strong_as_expected(nodes, stretch, phase):
    """The power of all waves is the mean square of each component, at any moment."""
    waves = make_waves(nodes, stretch, 0, 0)
    power = [
        (np.abs(part) ** 2) for part in np.fft.fftn(draw_tiles(nodes, waves, phase), axes=(1, 2, 3), norm="forward")
    ]
    grid = np.meshgrid(*map(np.fft.fftfreq, nodes), indexing="ij")
    response = np.prod([(2 + np.cos(2 * np.pi * k)) / 3 for k in grid], axis=0)
    for part in power:
        assert (part * response**2).sum() == pytest.approx(waves.power.sum(), rel=0.06)


def test_the_curl_of_long_waves_is_their_power_times_their_length():
    """As differences are derivatives then."""
    waves = make_waves((64,) * 3, (1.0,) * 3, 0, 0)
    lengths = 2 * np.pi * NODES_A_WAVE * 1e-3 * np.linalg.norm(waves.cycles, axis=0)
    assert curl_size(waves, 1e-3) == pytest.approx(np.sqrt(2 * (lengths**2) @ waves.power), rel=1e-4)


def test_waves_lie_within_an_octave():
    """And their directions are all equally likely."""
    waves = make_waves((TILE,) * 3, (1.0,) * 3, 0, 0)
    length = NODES_A_WAVE * np.linalg.norm(waves.cycles, axis=0)
    assert length.min() > 0.5**0.5
    assert length.max() < 2**0.5
    spread = (waves.power * waves.cycles**2).sum(1)
    np.testing.assert_allclose(spread, spread.mean(), rtol=0.02)


@pytest.mark.parametrize("nodes", [(64, 64, 64), (20, 33, 7)])
def test_part_of_a_lattice_is_what_the_whole_has_there(nodes):
    """Leaving out nodes and frequencies without waves changes no bit."""
    waves = make_waves(nodes, (1.0,) * 3, 3, 0)
    wanted = (np.arange(-3, 5) % nodes[0], np.arange(4, 9), np.array([6, 0, 1]))
    whole = draw_tiles(nodes, waves, 0.3)
    np.testing.assert_array_equal(draw_tiles(nodes, waves, 0.3, wanted), whole[np.ix_(range(3), *wanted)])
    half = np.zeros((3, *nodes[:2], nodes[2] // 2 + 1), complex)
    half.reshape(3, -1)[:, waves.index] = waves.amplitude * np.exp(0.3j * waves.pace)
    expected = np.fft.irfftn(half, s=nodes, axes=(1, 2, 3), norm="forward")
    np.testing.assert_allclose(whole, expected, atol=1e-5 * np.abs(expected).max())


@pytest.mark.parametrize("first", [-7.3, -2.0, 0.0, 5.99])
def test_window_holds_all_nodes_of_splines(first):
    """Two on either side of every element; the whole lattice when they are many."""
    begin, nodes = window(first, 1.7, 20, 128)
    places = np.floor(first + np.arange(20) / 1.7).astype(int)
    needed = places[:, None] + np.arange(-1, 3)
    assert begin <= needed.min()
    assert needed.max() < begin + len(nodes)
    np.testing.assert_array_equal(nodes, np.arange(begin, begin + len(nodes)) % 128)
    assert window(first, 1.7, 20, 12)[0] == 0
    np.testing.assert_array_equal(window(first, 1.7, 20, 12)[1], np.arange(12))
