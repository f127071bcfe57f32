"""The surface of a liquid: a profile in closed form, totals that stay, nothing through walls."""

import numpy as np
import pytest
import warp as wp

from warpfluid.kernels.fluid.surface import sharpen
from warpfluid.kernels.sides import CLOSED, OPEN, SIX, WRAP

BOX, RING = SIX(CLOSED, CLOSED, OPEN, OPEN, CLOSED, OPEN), SIX(WRAP, WRAP, WRAP, WRAP, CLOSED, CLOSED)


def sharpened(field, device, sides=BOX, *, steps=1, reference=1.0, width=0.5, **more):
    """Sharpen for some steps."""
    field = wp.array(field, dtype=float, device=device)
    for _ in range(steps):
        field = sharpen(field, sides, reference=reference, width=width, time_step=0.2, **more)
    return field.numpy()


def drop(shape=(20, 18, 24), soft=3.0):
    """Return a ball with a soft rim."""
    at = np.stack(np.meshgrid(*(np.arange(n) for n in shape), indexing="ij"), -1) - [9, 8, 11]
    return (1 / (1 + np.exp((np.linalg.norm(at, axis=-1) - 6) / soft))).astype(np.float32)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("begin", [0.5, 3.0])
def test_profile_of_a_level_surface(axis, begin, device):
    """From sharp and from soft it comes to 1 / (1 + exp(-x / width)), here with a width of one voxel."""
    x = np.arange(40) - 19.5
    profile = np.moveaxis(np.broadcast_to(1 / (1 + np.exp(-x / begin)), (4, 5, 40)), 2, axis)
    made = np.moveaxis(sharpened(profile, device, steps=400, width=1.0), axis, 2)
    np.testing.assert_allclose(made[1, 2], 1 / (1 + np.exp(-x)), atol=0.02)


@pytest.mark.parametrize("sides", [BOX, RING])
def test_totals_stay(sides, device):
    """Whatever wraps and wherever the drop is; nothing becomes negative, and it becomes sharper."""
    field = np.roll(drop(), 8, axis=0) if sides is RING else drop()
    made = sharpened(7 * field, device, sides, steps=20, reference=7.0) / 7
    assert made.sum(dtype=float) == pytest.approx(field.sum(dtype=float), rel=1e-5)
    assert made.min() >= 0
    half = (made > 0.1) & (made < 0.9)
    assert half.sum() < 0.6 * ((field > 0.1) & (field < 0.9)).sum()


def test_a_ring_has_no_border(device):
    """Where sides wrap, a moved drop gives the moved result, bit for bit."""
    moved = sharpened(np.roll(drop(), (7, -5), axis=(0, 1)), device, RING, steps=3)
    np.testing.assert_array_equal(moved, np.roll(sharpened(drop(), device, RING, steps=3), (7, -5), axis=(0, 1)))


def test_overfull_flows_out(device):
    """Two voxels in one take the room of two."""
    heap = np.zeros((15, 15, 15), np.float32)
    heap[6:9, 6:9, 6:9] = 2.0
    made = sharpened(heap, device, steps=100)
    assert made.max() < 1.1
    assert made.sum() == pytest.approx(54, rel=1e-4)


def test_solids_let_nothing_through(device):
    """A drop beside a closed wall of faces leaves nothing behind it."""
    field = drop(soft=1.0)
    field[9:] = 0
    faces = [np.ones(tuple(n + (k == axis) for k, n in enumerate(field.shape)), np.float32) for axis in range(3)]
    faces[0][9] = 0
    openings = tuple(wp.array(face, dtype=float, device=device) for face in faces)
    assert not sharpened(field, device, steps=5, openings=openings)[9:].any()
    assert sharpened(field, device, steps=5)[9:].any()


@pytest.mark.parametrize("wrong", [{"reference": 0.0}, {"width": -1.0}, {"width": 2.0}])
def test_numbers_that_make_no_sense(wrong, device):
    """They are told together with what is expected."""
    with pytest.raises(ValueError, match="expected a density above 0, and a short step"):
        sharpened(drop(), device, **wrong)


def test_openings_are_three(device):
    """One for each axis."""
    one = wp.array(np.ones((21, 18, 24)), dtype=float, device=device)
    with pytest.raises(ValueError, match="there are 1 openings, expected none or three"):
        sharpened(drop(), device, openings=(one,))
