"""The whole solver step against closed forms."""

import numpy as np
import pytest
import warp as wp

from warpfluid.kernels.fluid.totals import total
from warpfluid.options import SimulateOptions
from warpfluid.simulation.physics import Physics
from warpfluid.simulation.placing import Placing
from warpfluid.simulation.solver import Solver, Surroundings
from warpfluid.simulation.state import Faces, FluidState, face_shape, six_sides

STILL = {"density_dissipation": 0.0, "temperature_dissipation": 0.0}


def solver(shape, **choices):
    options = SimulateOptions(**STILL | choices)
    sides = six_sides(options.boundary_x, options.boundary_z, options.boundary_y)
    return Solver(Physics(options, Placing(shape, 1.0), sides))


def at_rest(shape, device):
    cells = [wp.zeros(shape, dtype=float, device=device) for _ in range(4)]
    return FluidState(Faces.zeros(shape, wp.get_device(device)), *cells)


def test_taylor_green_vortex_decays(device):
    """In a periodic box the vortex keeps its shape and its energy falls as exp(-4 nu k^2 t)."""
    n, nu, k = 32, 6.0, 2 * np.pi / 32
    state = at_rest((n, 4, n), device)
    parts = []
    for axis in range(3):
        x, _, y = np.indices(face_shape((n, 4, n), axis)).astype(float)
        x, y = (x - 0.5 * (axis == 0)) * k, (y - 0.5 * (axis == 2)) * k
        parts.append([np.cos(x) * np.sin(y), 0 * x, -np.sin(x) * np.cos(y)][axis])
    state.velocity = Faces(*(wp.array(part, dtype=float, device=device) for part in parts))
    sides = dict.fromkeys(("boundary_x", "boundary_y", "boundary_z"), "wrap")
    made = solver((n, 4, n), viscosity=nu, **sides)
    for frame in range(12):
        made.step(state, frame, 1 / 24, Surroundings())
    expected = np.exp(-2 * nu * k**2 * 0.5)
    found = state.velocity.x.numpy()
    np.testing.assert_allclose(found, expected * parts[0], atol=0.01)


def test_closed_box_keeps_its_mass(device):
    """Stirred by hot gas, nothing is lost and nothing leaves."""
    shape = (20, 20, 24)
    state = at_rest(shape, device)
    state.density.numpy()[6:14, 6:14, 3:9] = 1
    state.temperature.numpy()[6:14, 6:14, 3:9] = 1
    before = total(state.density)
    sides = dict.fromkeys(("boundary_x", "boundary_y", "boundary_z"), "closed")
    made = solver(shape, temperature_buoyancy=40.0, swirl=2.0, turbulence_strength=1.0, **sides)
    for frame in range(12):
        made.step(state, frame, 1 / 24, Surroundings())
    assert total(state.density) == pytest.approx(before, rel=1e-5)
    heights = state.density.numpy().sum((0, 1))
    assert (heights * np.arange(24)).sum() / heights.sum() > 6
    assert state.density.numpy().min() >= 0


def test_buoyancy_lifts_and_sinks(device):
    """Up for a positive lift, down for a negative one, not at all without gravity."""
    shape = (20, 20, 30)
    rise = {}
    for name, choices in (
        ("up", {"density_buoyancy": 20.0}),
        ("down", {"density_buoyancy": -20.0}),
        ("weightless", {"density_buoyancy": 20.0, "gravity": "0,0,0"}),
    ):
        state = at_rest(shape, device)
        state.density.numpy()[7:13, 7:13, 12:18] = 1
        made = solver(shape, **choices)
        for frame in range(8):
            made.step(state, frame, 1 / 24, Surroundings())
        heights = state.density.numpy().sum((0, 1))
        rise[name] = (heights * np.arange(30)).sum() / heights.sum() - 14.5
    assert rise["up"] > 0.5
    assert rise["down"] < -0.5
    assert abs(rise["weightless"]) < 1e-4


def test_turbulence_stirs_and_hardly_moves_the_whole(device):
    """Enstrophy rises; where the matter is, on a large scale, changes little (Fig. 12)."""
    from scipy.ndimage import gaussian_filter

    shape, made = (28, 28, 36), {}
    for strength in (0.0, 1.0):
        state = at_rest(shape, device)
        state.density.numpy()[8:20, 8:20, 6:30] = 1
        made[strength] = state
        step = solver(shape, turbulence_strength=strength, turbulence_frequency=1.0)
        for frame in range(10):
            step.step(state, frame, 1 / 24, Surroundings())
    curl = {s: np.square(np.diff(state.velocity.x.numpy(), axis=2)).sum() for s, state in made.items()}
    assert curl[1.0] > 100 * max(curl[0.0], 1e-6)
    slow = [gaussian_filter(made[s].density.numpy(), 5) for s in (0.0, 1.0)]
    assert np.abs(slow[1] - slow[0]).mean() < 0.1 * slow[0].mean()
    assert np.abs(made[1.0].density.numpy() - made[0.0].density.numpy()).mean() > 0.03 * slow[0].mean()
