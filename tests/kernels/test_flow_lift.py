"""Lifting flow into the volume (Eqs. 5-7)."""

import numpy as np
import pytest
import warp as wp

from warpfluid.device import pick_device
from warpfluid.kernels.flow.flow_lift import lift
from warpfluid.projector import directions

SHAPE = (9, 9, 50)


def lifted(flows, angles, device, shape=SHAPE, corner=(0, 0), average=False):
    u, v = (wp.array(np.stack([f[i] for f in flows]), dtype=float, device=device) for i in (0, 1))
    fan = directions(np.array(angles, float), pick_device(device))
    return [part.numpy() for part in lift(u, v, fan, shape, corner=corner, average=average)]


def equations(flows, angles, shape=SHAPE):
    """Eqs. 5-7 with linear interpolation, in NumPy."""
    n = shape[0]
    x, z = np.meshgrid(np.arange(n) - (n - 1) / 2, np.arange(n) - (n - 1) / 2, indexing="ij")
    total, seen = np.zeros((3, *shape)), np.zeros(3)
    for (fu, fv), angle in zip(flows, np.radians(angles), strict=True):
        u = np.clip(x * np.cos(angle) + z * np.sin(angle) + (n - 1) / 2, 0, n - 1)
        at = [
            np.stack([np.interp(u.ravel(), np.arange(n), f[:, y]).reshape(n, n) for y in range(shape[2])], -1)
            for f in (fu, fv)
        ]
        total += [at[0] * np.cos(angle), at[0] * np.sin(angle), at[1]]
        seen += [abs(np.cos(angle)), abs(np.sin(angle)), 1]
    return total / seen.reshape(3, 1, 1, 1)


def test_equations_5_to_7(device):
    """Any views agree with the formulas."""
    rng = np.random.default_rng(0)
    angles = (10.0, 75.0, 140.0)
    flows = [rng.standard_normal((2, 9, 50)).astype(np.float32) for _ in angles]
    ours = lifted(flows, angles, device, average=True)
    for component, expected in zip(ours, equations(flows, angles), strict=True):
        np.testing.assert_allclose(component, expected, atol=1e-5)


@pytest.mark.parametrize("angles", [(0, 90), (0, 45), (35, 128), (0, 60, 120), (10, 20, 150)])
def test_uniform_motion_is_found(angles, device):
    """Whatever the views, least squares returns the motion that they show; at 0 and 90 Eqs. 5-7 do, too."""
    motion = np.array([1.0, -0.5, 2.0])
    flows = [
        np.stack([np.full((9, 50), motion[0] * np.cos(t) + motion[1] * np.sin(t)), np.full((9, 50), motion[2])])
        for t in np.radians(angles)
    ]
    for component, expected in zip(lifted(flows, angles, device), motion, strict=True):
        np.testing.assert_allclose(component, expected, atol=1e-4)
    if angles == (0, 90):
        for component, expected in zip(lifted(flows, angles, device, average=True), motion, strict=True):
            np.testing.assert_allclose(component, expected, atol=1e-5)


@pytest.mark.parametrize("angle", [0, 30, 90, 200])
def test_one_view_moves_across_its_sight_alone(angle, device):
    """The motion is along u by what the view shows, and 0 along the line of sight."""
    x, z, _ = lifted([np.ones((2, 9, 50), np.float32)], (angle,), device)
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    np.testing.assert_allclose(x * c + z * s, 1, atol=1e-5)
    np.testing.assert_allclose(z * c - x * s, 0, atol=1e-5)


def test_a_part_of_the_box(device):
    """A part has the values that the whole has there."""
    rng = np.random.default_rng(1)
    flows = [rng.standard_normal((2, 9, 50)).astype(np.float32) for _ in range(2)]
    whole = lifted(flows, (0, 60), device)
    part = lifted(flows, (0, 60), device, shape=(4, 5, 50), corner=(3, 2))
    for a, b in zip(part, whole, strict=True):
        np.testing.assert_array_equal(a, b[3:7, 2:7])


@pytest.mark.parametrize(("angle", "blind"), [(0, 1), (90, 0)])
def test_one_view_knows_no_depth(angle, blind, device):
    """The component along the line of sight is 0, not 0 / 0."""
    flow = np.ones((2, 9, 50), np.float32)
    omega = lifted([flow], (angle,), device)
    assert (omega[blind] == 0).all()
    np.testing.assert_allclose(np.abs(omega[1 - blind]), 1, atol=1e-6)
    np.testing.assert_allclose(omega[2], 1)
