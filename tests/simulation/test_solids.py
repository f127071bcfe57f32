"""What shapes leave open, against their volumes, and how they move, against rigid motion."""

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st

from warpfluid.simulation.placed import Placed, rotation_of_degrees
from warpfluid.simulation.shapes import Box, Plane, Sphere
from warpfluid.simulation.solids import build_solids, clear, enforce
from warpfluid.simulation.state import Faces, six_sides

GRID = (30, 32, 28)
CENTRE = np.array([14.2, 13.7, 15.1])  # (x, y, z)


def built(placed, device, shape=GRID):
    return build_solids(placed, shape, wp.get_device(device))


def test_nothing_leaves_all_open(device):
    """Every share is 1 and nothing moves."""
    solids = built([], device)
    for array in (*solids.open, solids.fluid):
        assert (array.numpy() == 1).all()
    assert not any(array.numpy().any() for array in solids.velocity)


@pytest.mark.parametrize("radius", [6.0, 12.0])
def test_sphere_has_its_volume(radius, device):
    """By voxels, and by the faces of each axis; the error falls with the square of the radius."""
    solids = built([Placed(Sphere(radius), CENTRE)], device)
    volume = 4 / 3 * np.pi * radius**3
    for array in (solids.fluid, *solids.open):
        covered = (1 - array.numpy().astype(np.float64)).sum()
        assert covered == pytest.approx(volume, rel=0.7 / radius**2)


def test_sphere_has_its_area(device):
    """Faces through the middle are covered on a disc."""
    solids = built([Placed(Sphere(10.0), (14.5, 13.5, 15.5))], device)
    assert (1 - solids.open.x.numpy()[15]).sum() == pytest.approx(np.pi * 100, rel=0.01)
    assert (1 - solids.open.z.numpy()[:, 16]).sum() == pytest.approx(np.pi * 100, rel=0.01)
    assert (1 - solids.open.y.numpy()[:, :, 14]).sum() == pytest.approx(np.pi * 100, rel=0.01)


def test_box_on_faces_is_exact(device):
    """Its sides close their faces wholly, whatever rounding does to distances."""
    solids = built([Placed(Box((6, 4, 8)), (12.5, 9.5, 15.5))], device)
    fluid = np.ones(GRID, np.float32)
    fluid[10:16, 12:20, 8:12] = 0
    np.testing.assert_array_equal(solids.fluid.numpy(), fluid)
    opening = np.ones((31, 32, 28), np.float32)
    opening[10:17, 12:20, 8:12] = 0
    np.testing.assert_array_equal(solids.open.x.numpy(), opening)


@given(height=st.floats(-0.4, 26.0), tilt=st.floats(-60, 60), turn=st.floats(-180, 180))
@settings(max_examples=15)
def test_slope_is_exact(height, tilt, turn):
    """Voxels below a slope hold what a fine count says."""
    rotation = rotation_of_degrees((0, turn, 0)) @ rotation_of_degrees((tilt, 0, 0))
    solids = built([Placed(Plane(), (3, height, 3), rotation)], "cpu", (7, 7, 28))
    at = np.stack(np.meshgrid(*(np.arange(0, n, 1 / 6) + 1 / 12 - 0.5 for n in (7, 7, 28)), indexing="ij"), -1)
    above = (at[..., [0, 2, 1]] - [3, height, 3]) @ rotation[:, 1] > 0
    counted = above.reshape(7, 6, 7, 6, 28, 6).mean(axis=(1, 3, 5))
    assert np.abs(solids.fluid.numpy() - counted).max() < 0.1


def test_ground_at_a_face_closes_it(device):
    """The faces of that height and below, and no voxel above."""
    solids = built([Placed(Plane(), (0, 3.5, 0))], device)
    assert not solids.open.y.numpy()[:, :, :5].any()
    assert (solids.open.y.numpy()[:, :, 5:] == 1).all()
    assert (solids.fluid.numpy() == (np.arange(28) > 3)).all()


def test_open_faces_lead_to_fluid(device):
    """On both sides, or the pressure there would be free."""
    solids = built([Placed(Box((9, 5, 7)), CENTRE, rotation_of_degrees((10, 20, 30)))], device)
    opening, fluid = solids.open.z.numpy()[:, 1:-1] > 0, solids.fluid.numpy() > 0
    assert (fluid[:, :-1][opening] & fluid[:, 1:][opening]).all()


def test_turning_box_moves_rigidly(device):
    """v + w x r at the middle of every face around it, in right-handed axes."""
    velocity, spin = np.array([1.0, -2.0, 3.0]), np.array([0.3, 0.5, -0.7])
    placed = Placed(Box((8, 6, 7)), CENTRE, rotation_of_degrees((30, 40, 0)), velocity, spin)
    solids = built([placed], device)
    for axis, component, opening in zip((0, 2, 1), solids.velocity, solids.open, strict=True):
        x, z, y = np.meshgrid(*map(np.arange, component.shape), indexing="ij")
        at = np.stack([x, y, z], -1) - 0.5 * np.eye(3)[axis]
        expected = velocity + np.cross(spin, at - CENTRE)
        covered = opening.numpy() < 1
        assert covered.sum() > 300
        np.testing.assert_allclose(component.numpy()[covered], expected[..., axis][covered], atol=1e-4)


def test_the_nearest_gives_the_velocity(device):
    """A moving sphere beside one at rest."""
    moving, resting = Placed(Sphere(4.0), (7, 14, 15), velocity=(5, 0, 0)), Placed(Sphere(4.0), (22, 14, 15))
    for placed in ([moving, resting], [resting, moving]):
        velocity = built(placed, device).velocity.x.numpy()
        assert velocity[7, 15, 14] == 5
        assert velocity[22, 15, 14] == 0


def test_leaves_through_a_side_that_wraps(device):
    """And comes in across it: the first and the last faces are the same, and its volume is all there."""
    ball = Placed(Sphere(6.0), (28.3, 13.0, 0.4), velocity=(1, 2, 3), spin=(0.1, 0.2, 0.3))
    sides = six_sides("wrap", "wrap", "closed")
    solids = build_solids([ball], GRID, wp.get_device(device), sides=sides)
    assert (1 - solids.fluid.numpy()).sum() == pytest.approx(4 / 3 * np.pi * 6**3, rel=0.02)
    for axis in range(2):
        for part in (solids.open[axis], solids.velocity[axis]):
            faces = np.moveaxis(part.numpy(), axis, 0)
            assert faces[0].std() > 0
            np.testing.assert_allclose(faces[0], faces[-1], atol=2e-5)
    middle = Placed(Sphere(6.0), CENTRE)
    same = build_solids([middle], GRID, wp.get_device(device), sides=sides)
    np.testing.assert_array_equal(same.fluid.numpy(), built([middle], device).fluid.numpy())


def test_velocity_is_held_where_faces_are_closed(device):
    """And left alone, to the bit, where they are not."""
    solids = built([Placed(Sphere(8.0), CENTRE, velocity=(2, 3, 4))], device)
    rng = np.random.default_rng(0)
    before = [rng.standard_normal(array.shape).astype(np.float32) for array in solids.open]
    velocity = Faces(*(wp.array(array, dtype=float, device=device) for array in before))
    enforce(velocity, solids)
    for after, old, opening, speed in zip(velocity, before, solids.open, (2, 4, 3), strict=True):
        expected = np.where(opening.numpy() == 0, np.float32(speed), old)
        np.testing.assert_array_equal(after.numpy(), expected)


def test_clearing_often_takes_no_more_than_clearing_long(device):
    """Voxels with fluid in half of them or more keep all; those without any keep nothing."""
    solids = built([Placed(Sphere(8.0), CENTRE)], device)
    field = wp.full(GRID, 3.0, dtype=float, device=device)
    for _ in range(20):
        clear(field, solids)
    fluid = solids.fluid.numpy()
    assert (field.numpy()[fluid >= 0.5] == 3).all()
    assert (field.numpy()[fluid == 0] == 0).all()


def test_any_number_of_threads_gives_the_same_bits(monkeypatch):
    """One thread or three."""
    results = []
    for threads in ("1", "3"):
        monkeypatch.setenv("WARPFLUID_THREADS", threads)
        solids = built([Placed(Sphere(9.0), CENTRE, spin=(1, 2, 3)), Placed(Box((30, 3, 4)), CENTRE)], "cpu")
        results.append([array.numpy() for array in (*solids.open, *solids.velocity, solids.fluid)])
    for one, three in zip(*results, strict=True):
        np.testing.assert_array_equal(one, three)
