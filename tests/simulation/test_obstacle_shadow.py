"""Shadows of obstacles on volumes that are followed: where no matter of the footage can have come from."""

import numpy as np
import pytest
import warp as wp

from warpfluid.options.scene import parse_thing
from warpfluid.simulation.placing import Placing
from warpfluid.simulation.shadow import advance_shadow, shaded
from warpfluid.simulation.solids import build_solids
from warpfluid.simulation.state import Faces, face_shape, six_sides

SHAPE = (16, 16, 40)
SIDES = six_sides("open", "open", "open")


def rising(speed: float, device) -> Faces:
    parts = [np.zeros(face_shape(SHAPE, axis), np.float32) for axis in range(3)]
    parts[2][:] = speed
    return Faces(*(wp.array(part, dtype=float, device=device) for part in parts))


@pytest.fixture
def slab(device):
    """Four voxels wide and deep, two high, from a quarter of the height on."""
    obstacle = parse_thing("obstacle", "box center=0,2.75,0 size=1,0.5,1")
    return build_solids([Placing(SHAPE, 1.0).solid(obstacle, 0.0, 1.0, 1.0)], SHAPE, wp.get_device(device))


@pytest.mark.parametrize("speed", [1.0, 3.0, 7.0])
def test_a_shadow_grows_as_the_footage_moves(slab, speed, device):
    """From the slab as far as matter came, without gaps, as wide as the slab, and nothing before it."""
    shadow = None
    for _ in range(3):
        shadow = advance_shadow(shadow, rising(speed, device), slab, SIDES, 1.0, keep=1.0)
    inside, column = slab.fluid.numpy()[7, 7] < 0.01, shadow.numpy()[7, 7]
    top, far = np.flatnonzero(inside).max(), int(3 * speed)
    np.testing.assert_allclose(column[inside], 1, atol=1e-6)
    np.testing.assert_allclose(column[top + 1 : top + 1 + far], 1, atol=1e-5)
    assert column[: np.flatnonzero(inside).min()].max() == 0
    assert column[top + 3 + far :].max() < 1e-6
    wide = slab.fluid.numpy()[..., top].min(axis=1) < 0.5
    np.testing.assert_array_equal(shadow.numpy()[:, 7, top + 1] > 0.5, wide)


def test_a_shadow_is_forgotten(slab, device):
    """By the same share each frame; without a solid it goes on as it is carried, and is gone in the end."""
    still = rising(0.0, device)
    shadow = advance_shadow(None, still, slab, SIDES, 1.0, keep=0.5)
    again = advance_shadow(shadow, still, None, SIDES, 1.0, keep=0.5).numpy()
    np.testing.assert_allclose(again, shadow.numpy() / 2)
    assert advance_shadow(None, still, None, SIDES, 1.0, keep=0.5) is None


def test_a_volume_is_left_where_no_shadow_is(device):
    """Share by share."""
    rng = np.random.default_rng(0)
    volume, shadow = rng.random((2, *SHAPE)).astype(np.float32)
    left = shaded(wp.array(volume, device=device), wp.array(shadow, device=device)).numpy()
    np.testing.assert_allclose(left, volume * (1 - shadow), atol=1e-6)
