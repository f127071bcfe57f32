"""Liquid mass and weight against closed forms."""

import numpy as np
import pytest
import warp as wp

from warpfluid.options import SimulateOptions
from warpfluid.simulation.liquid import draw_together, liquid_mass, share_of_gravity
from warpfluid.simulation.physics import Physics
from warpfluid.simulation.placing import Placing
from warpfluid.simulation.state import Faces, FluidState, six_sides

SHAPE, FULL = (6, 6, 8), 5.0


def state_of(density, device):
    cells = [wp.array(density, dtype=float, device=device), *(wp.zeros(SHAPE, device=device) for _ in range(3))]
    return FluidState(Faces.zeros(SHAPE, device), *cells)


def physics_of(weight, **more):
    return Physics(
        SimulateOptions(liquid_weight=weight, **more), Placing(SHAPE, FULL), six_sides("open", "open", "closed")
    )


def test_a_gas_has_no_mass(device):
    """Nothing is computed for it."""
    assert liquid_mass(physics_of(0.0), state_of(np.ones(SHAPE), device), 1) is None


@pytest.mark.parametrize("weight", [1.0, 30.0, 800.0])
def test_mass_and_weight(weight, device):
    """Air weighs 1, full density 1 + weight; air leaves a liquid (m - 1) / m of gravity."""
    density = np.zeros(SHAPE, np.float32)
    density[2:4], density[4:] = FULL / 2, FULL
    mass = liquid_mass(physics_of(weight), state_of(density, device), 1)
    found = mass.numpy()
    np.testing.assert_allclose(found[:2], 1)
    np.testing.assert_allclose(found[2:4], 1 + weight / 2, rtol=1e-6)
    np.testing.assert_allclose(found[4:], 1 + weight, rtol=1e-6)
    np.testing.assert_allclose(share_of_gravity(mass).numpy(), (found - 1) / found, rtol=1e-5, atol=1e-7)


@pytest.mark.parametrize(("weight", "surface"), [(30.0, 1.0), (30.0, "1:0"), (0.0, 1.0)])
def test_only_a_liquid_is_drawn_together(weight, surface, device):
    """What is half full gathers, unless it is a gas or is let fade; nothing is lost."""
    density = np.zeros(SHAPE, np.float32)
    density[1:4, 1:5, :4] = 0.5 * FULL
    state = state_of(density, device)
    for _ in range(10):
        draw_together(physics_of(weight, liquid_surface=surface), state, None, 1)
    drawn = weight > 0 and surface == 1.0
    assert (state.density.numpy().max() > 0.7 * FULL) == drawn
    assert state.density.numpy().sum() == pytest.approx(density.sum(), rel=1e-5)
