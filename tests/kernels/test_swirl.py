"""Vorticity confinement against NumPy's, and what it does to an eddy."""

import numpy as np
import pytest
import warp as wp
from mac import (
    ALL_CLOSED,
    ALL_OPEN,
    MIXED,
    SHAPE,
    SIDES,
    face_means,
    places,
    pushed,
    random_faces,
    six,
    still,
    without_walls,
    wraps,
)

from warpfluid.kernels.forces.swirl import add_swirl


def difference(field, axis, sides):
    """Central differences, one-sided at borders, around the box where it wraps."""
    if wraps(sides, axis):
        return (np.roll(field, -1, axis) - np.roll(field, 1, axis)) / 2
    return np.gradient(field, axis=axis)


def confinement(faces, sides, mask=1.0):
    """N x w in the voxels, with vectors in the right-handed order (x, y, z)."""
    u, w, v = ((f[1:] + f[:-1]) / 2 for f in (np.moveaxis(f.astype(float), k, 0) for k, f in enumerate(faces)))
    u, w, v = u, np.moveaxis(w, 0, 1), np.moveaxis(v, 0, 2)
    x, z, y = 0, 1, 2
    curl = [
        difference(w, y, sides) - difference(v, z, sides),
        difference(u, z, sides) - difference(w, x, sides),
        difference(v, x, sides) - difference(u, y, sides),
    ]
    size = np.linalg.norm(curl, axis=0)
    gradient = np.stack([difference(size, axis, sides) for axis in (x, y, z)])
    gradient /= np.maximum(np.linalg.norm(gradient, axis=0), 1e-30)
    force = np.cross(gradient, curl, axis=0) * mask
    return force[[0, 2, 1]]


def eddy(shape=(24, 9, 30), scale=1.0):
    """A Gaussian eddy in the (x, y) plane, velocities in voxels of ``scale``."""
    u, w, v = places(shape)
    middle = (np.array(shape) - 1) / 2

    def turn(place):
        d = (place - middle) / scale
        return np.exp(-(d[..., 0] ** 2 + d[..., 2] ** 2) / 18), d

    (gx, dx), (gy, dy) = turn(u), turn(v)
    return [(-dx[..., 2] * gx * scale), np.zeros(w.shape[:3]), (dy[..., 0] * gy * scale)]


@pytest.mark.parametrize("masked", [False, True])
@pytest.mark.parametrize("sides", SIDES)
def test_is_the_law(sides, masked, device):
    """On the faces as the mean of two voxels, with any kind of side."""
    faces = random_faces(sides=sides)
    mask = np.random.default_rng(4).random(SHAPE) if masked else np.ones(SHAPE)
    force = confinement(faces, sides, mask)
    means = [face_means(force[axis], sides)[axis] for axis in range(3)]
    changes = without_walls([0.1 * 3 * mean for mean in means], sides)
    field = wp.array(mask, dtype=float, device=device) if masked else None
    got = pushed(add_swirl, faces, device, strength=3.0, time_step=0.1, sides=six(sides), mask=field)
    for axis in range(3):
        np.testing.assert_allclose(got[axis], faces[axis] + changes[axis], atol=5e-5)
        if wraps(sides, axis):
            ends = np.moveaxis(got[axis], axis, 0)
            np.testing.assert_array_equal(ends[0], ends[-1])


def test_spins_an_eddy_up(device):
    """Kinetic energy grows, and falls when the strength is below 0; nothing moves across the plane of the eddy."""
    faces = eddy()
    energies = []
    for strength in (-1.0, 0.0, 1.0):
        got = pushed(add_swirl, faces, device, strength=strength, time_step=0.1, sides=six(ALL_OPEN))
        energies.append(sum((face.astype(float) ** 2).sum() for face in got))
        assert not got[1].any()
    assert energies[0] < 0.99 * energies[1]
    assert energies[2] > 1.01 * energies[1]


def test_a_speed_of_the_scene_does_not_depend_on_the_resolution(device):
    """Twice the voxels, strength and velocities twice as many of them: the same force on an eddy that both resolve."""
    changes = []
    for scale, shape in ((2, (48, 4, 60)), (4, (96, 8, 120))):
        faces = eddy(shape, scale)
        got = pushed(add_swirl, faces, device, strength=float(scale), time_step=1.0, sides=six(ALL_OPEN))
        change = (got[2] - faces[2])[:, shape[1] // 2]
        changes.append((change[:, 1:] + change[:, :-1]) / 2 / scale)
    fine = changes[1].reshape(48, 2, 60, 2).mean(axis=(1, 3))
    assert np.abs(fine - changes[0]).mean() < 0.08 * np.abs(changes[0]).mean()


@pytest.mark.parametrize("motion", [(0, 0, 0), (3, -1, 2)])
def test_leaves_uniform_motion_alone(motion, device):
    """There is nothing that turns."""
    faces = [face + speed for face, speed in zip(still(), motion, strict=True)]
    for before, after in zip(
        faces, pushed(add_swirl, faces, device, strength=5.0, time_step=1.0, sides=six(MIXED)), strict=True
    ):
        np.testing.assert_array_equal(before, after)


@pytest.mark.parametrize("nothing", [{"strength": 0.0}, {"time_step": 0.0}, {"mask": 0.0}])
def test_no_strength_keeps_the_bits(nothing, device):
    """No strength, no time or an empty mask."""
    faces = random_faces()
    if "mask" in nothing:
        nothing = {"mask": wp.zeros(SHAPE, dtype=float, device=device)}
    got = pushed(add_swirl, faces, device, sides=six(ALL_CLOSED), **({"strength": 2.0, "time_step": 0.1} | nothing))
    for before, after in zip(faces, got, strict=True):
        np.testing.assert_array_equal(before, after)


@pytest.mark.parametrize("shape", [(1, 1, 1), (1, 5, 2), (2, 1, 49)])
@pytest.mark.parametrize("sides", SIDES)
def test_thin_boxes_are_no_trouble(shape, sides, device):
    """Where there is no neighbour there is no difference."""
    got = pushed(add_swirl, random_faces(shape, sides), device, strength=1.0, time_step=0.1, sides=six(sides))
    assert all(np.isfinite(face).all() for face in got)


def test_any_number_of_threads_gives_the_same_bits(monkeypatch):
    """One thread or three."""
    results = []
    for threads in ("1", "3"):
        monkeypatch.setenv("WARPFLUID_THREADS", threads)
        faces = random_faces((40, 7, 53))
        results.append(pushed(add_swirl, faces, "cpu", strength=2.0, time_step=0.1, sides=six(ALL_OPEN)))
    for a, b in zip(*results, strict=True):
        np.testing.assert_array_equal(a, b)


def test_refuses_a_senseless_strength(device):
    """It would spread at once."""
    with pytest.raises(ValueError, match="strength"):
        pushed(add_swirl, still(), device, strength=float("nan"), time_step=0.1, sides=six(ALL_OPEN))
