"""Motion blur against a blob whose path is known."""

import numpy as np
import pytest
import warp as wp

from warpfluid.rendering.camera import orthographic
from warpfluid.rendering.marching import march
from warpfluid.rendering.medium import Curve, Medium
from warpfluid.rendering.motion_blur import mean_picture, moments

N = 32


def blob(x):
    """A round blob at a place along x."""
    at = np.arange(N)
    d2 = (at[:, None, None] - x) ** 2 + (at[None, :, None] - 15.5) ** 2 + (at[None, None, :] - 15.5) ** 2
    return np.exp(-d2 / 18).astype(np.float32)


def moving(device, speed):
    fields = {"density": wp.array(blob(15.5), dtype=float, device=device)}
    zero = wp.zeros((N, N, N), dtype=float, device=device)
    return fields, (wp.full((N, N, N), speed, dtype=float, device=device), zero, zero)


def picture(fields):
    return march(Medium(fields=fields, emission=Curve("density", 1, np.array([0, 1]))), orthographic((N, N, N)))


def test_moments_lie_evenly_around_the_frame(device):
    """Each is the blob where it is then."""
    fields, velocity = moving(device, 8.0)
    found = list(moments(fields, velocity, shutter=0.5, samples=4))
    for i, moment in enumerate(found):
        time = 0.5 * ((i + 0.5) / 4 - 0.5)
        np.testing.assert_allclose(moment["density"].numpy(), blob(15.5 + 8 * time), atol=0.02)


def test_the_mean_is_that_of_the_blobs(device):
    """Longer along its way than across."""
    fields, velocity = moving(device, 8.0)
    blurred = mean_picture(picture(moment) for moment in moments(fields, velocity, shutter=1, samples=9))
    places = 15.5 + 8 * ((np.arange(9) + 0.5) / 9 - 0.5)
    expected = np.mean([blob(x).sum(axis=1).T[::-1] for x in places], axis=0)
    np.testing.assert_allclose(blurred.color[..., 0], expected, atol=0.05)
    across, along = blurred.density.sum(axis=1), blurred.density.sum(axis=0)
    at = np.arange(N) - 15.5
    assert (along * at**2).sum() / along.sum() > 1.5 * (across * at**2).sum() / across.sum()


def test_nothing_moves(device):
    """A closed shutter, one sample or no velocity leave a picture as it is."""
    fields, velocity = moving(device, 0.0)
    sharp = picture(fields)
    for shutter, samples in ((0.0, 3), (1.0, 1), (1.0, 2)):
        blurred = mean_picture(picture(m) for m in moments(fields, velocity, shutter=shutter, samples=samples))
        np.testing.assert_allclose(blurred.color, sharp.color, atol=2e-5)
        lit = sharp.color[..., 0] > 0.01
        np.testing.assert_allclose(blurred.depth[lit], sharp.depth[lit], rtol=1e-4)


def test_refuses_nonsense(device):
    """No time, no moments, no pictures."""
    fields, velocity = moving(device, 1.0)
    for wrong in ({"shutter": -1, "samples": 2}, {"shutter": float("nan"), "samples": 2}, {"shutter": 1, "samples": 0}):
        with pytest.raises(ValueError, match="shutter"):
            list(moments(fields, velocity, **wrong))
    with pytest.raises(ValueError, match="none"):
        mean_picture([])
