"""What emitters let in, against rates times volumes and against exponentials."""

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st

from warpfluid.simulation.emitters import Emitter, emit, find_outlet
from warpfluid.simulation.placed import Placed, rotation_of_degrees
from warpfluid.simulation.shapes import Box, Cylinder, Mesh, Plane, Sphere
from warpfluid.simulation.state import Faces, FluidState
from warpfluid.simulation.triangles import box_surface

GRID = (24, 26, 50)
CENTRE = (11.3, 20.6, 12.8)  # (x, y, z)
SHAPES = [Sphere(4.2), Box((5.0, 3.3, 6.1)), Cylinder(3.7, 5.0), Mesh(*box_surface((4, 5, 6)))]


def still(device, shape=GRID):
    cells = [wp.zeros(shape, dtype=float, device=device) for _ in range(4)]
    return FluidState(Faces.zeros(shape, wp.get_device(device)), *cells)


def total(array):
    return array.numpy().sum(dtype=np.float64)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
def test_rate_integrates_to_what_is_added(shape, device):
    """Rate times volume times time, for every hard shape, turned and between voxels."""
    state = still(device)
    emitter = Emitter(placed=Placed(shape, CENTRE, rotation_of_degrees((10, 40, 70))), density=3.0, fuel=0.5)
    for _ in range(4):
        emit(state, emitter, 0.05)
    assert total(state.density) == pytest.approx(3.0 * shape.volume * 0.2, rel=1e-5)
    assert total(state.fuel) == pytest.approx(0.5 * shape.volume * 0.2, rel=1e-5)


def test_box_on_voxels_is_exact(device):
    """Its voxels get the rate times the time, others nothing."""
    state = still(device)
    emit(state, Emitter(placed=Placed(Box((4, 6, 2)), (10.5, 8.5, 12.5)), density=8.0), 0.25)
    expected = np.zeros(GRID, np.float32)
    expected[9:13, 12:14, 6:12] = 2
    np.testing.assert_allclose(state.density.numpy(), expected, rtol=1e-6)


def test_cut_by_the_floor(device):
    """Half of a ball lies inside the grid."""
    state, ball = still(device), Sphere(7.0)
    emit(state, Emitter(placed=Placed(ball, (11.5, -0.5, 12.5)), density=1.0), 1.0)
    assert total(state.density) == pytest.approx(ball.volume / 2, rel=0.02)


def test_soft_edge(device):
    """The weight is a half at the surface, falls all the way out, and is 0 beyond half the width."""
    placed = Placed(Sphere(5.0), (11, 20, 12))
    first, weight = find_outlet(Emitter(placed=placed, soft_edge=4.0), GRID, wp.get_device(device))
    full = np.zeros(GRID)
    full[tuple(slice(f, f + n) for f, n in zip(first, weight.shape, strict=True))] = weight.numpy()
    ray = full[11:, 12, 20]
    assert ray[5] == pytest.approx(0.5, abs=1e-5)
    assert (np.diff(ray[3:8]) < 0).all()
    assert (ray[:4] == 1).all()
    assert (ray[7:] == 0).all()


@pytest.mark.parametrize("temperature", [2.0, -1.5])
def test_temperature_is_held(temperature, device):
    """However often, and what is hotter (or colder) already stays."""
    state = still(device)
    state.temperature.fill_(0.5)
    emitter = Emitter(placed=Placed(Sphere(4.0), (11, 20, 12)), temperature=temperature)
    emit(state, emitter, 0.1)
    once = state.temperature.numpy()
    assert once[11, 12, 20] == pytest.approx(temperature, rel=0.03)
    assert once[0, 0, 0] == 0.5
    emit(state, emitter, 0.1)
    np.testing.assert_array_equal(state.temperature.numpy(), once)


@given(steps=st.integers(1, 6))
@settings(max_examples=6)
def test_velocity_follows_an_exponential(steps):
    """The same however a second is cut into steps; each component at its own faces."""
    state = still("cpu")
    emitter = Emitter(placed=Placed(Box((8, 8, 8)), (11.5, 19.5, 12.5)), velocity=(1.0, -2.0, 3.0), velocity_rate=1.5)
    for _ in range(steps):
        emit(state, emitter, 1 / steps)
    reached = 1 - np.exp(-1.5)
    for component, speed in zip(state.velocity, (1.0, 3.0, -2.0), strict=True):
        assert component.numpy()[11, 12, 19] == pytest.approx(speed * reached, rel=1e-5)
        assert component.numpy()[2, 2, 2] == 0
    edge = state.velocity.x.numpy()[8, 12, 19]
    assert edge == pytest.approx(1 - np.exp(-0.75), rel=1e-5)


def test_outermost_faces_stay(device):
    """There the sides of the box rule."""
    state = still(device)
    emit(state, Emitter(placed=Placed(Box((90, 90, 90)), CENTRE), velocity=(1, 1, 1), velocity_rate=9.0), 1.0)
    for axis, component in enumerate(state.velocity):
        inner = np.moveaxis(component.numpy(), axis, 0)
        assert not inner[[0, -1]].any()
        assert inner[1:-1].all()


def noisy(device, seconds=0.0, **options):
    state = still(device)
    state.seconds = seconds
    emit(state, Emitter(placed=Placed(Box((20, 40, 20)), CENTRE), density=1.0, noise=1.0, **options), 1.0)
    return state.density.numpy()[3:20, 4:21, 3:40]


def test_noise_flickers_around_one(device):
    """Strongly, never below nothing, and half as often above as below."""
    added = noisy(device, noise_frequency=0.3)
    assert added.min() >= 0
    assert 0.2 < added.std() < 0.6
    assert added.mean() == pytest.approx(1, abs=0.06)


def test_noise_moves_on_in_time(device):
    """A little after a little while, all after long; no speed, no change; another seed is another noise."""
    now = noisy(device)
    soon, later, other = noisy(device, 0.01), noisy(device, 3.7), noisy(device, seed=4)
    assert 0 < np.abs(soon - now).max() < 0.25
    for different in (later, other):
        assert np.abs(np.corrcoef(now.ravel(), different.ravel())[0, 1]) < 0.5
    np.testing.assert_array_equal(noisy(device, noise_speed=0.0), noisy(device, 5.0, noise_speed=0.0))


def test_frequency_sets_the_size(device):
    """Twice the frequency changes about twice as fast from voxel to voxel."""
    slow, fast = (np.abs(np.diff(noisy(device, noise_frequency=f), axis=2)).mean() for f in (0.04, 0.08))
    assert 1.5 < fast / slow < 2.5


def test_outside_does_nothing(device):
    """Nor does an emitter that lets nothing in, to the bit."""
    state = still(device)
    state.temperature.fill_(-3.0)
    emit(state, Emitter(placed=Placed(Sphere(2.0), (99, 0, 0)), density=1.0), 1.0)
    emit(state, Emitter(placed=Placed(Sphere(2.0), CENTRE)), 1.0)
    assert not state.density.numpy().any()
    assert (state.temperature.numpy() == -3).all()


def test_a_kept_outlet_gives_the_same_bits(device):
    """As one that is found anew."""
    emitter = Emitter(placed=Placed(Sphere(4.4), CENTRE), density=1.0, noise=0.5)
    states = still(device), still(device)
    emit(states[0], emitter, 0.1)
    emit(states[1], emitter, 0.1, outlet=find_outlet(emitter, GRID, wp.get_device(device)))
    np.testing.assert_array_equal(*(state.density.numpy() for state in states))


@pytest.mark.parametrize(
    "options",
    [
        {"noise": 1.5},
        {"soft_edge": -1.0},
        {"velocity_rate": np.nan},
        {"density": np.inf},
        {"velocity": (1, 2)},
        {"placed": Placed(Plane())},
    ],
)
def test_refuses_senseless_numbers(options):
    """The message names the emitter."""
    with pytest.raises(ValueError, match="emitter"):
        Emitter(**{"placed": Placed(Sphere(1.0))} | options)
