"""Cubic interpolation in the ray marcher against Catmull and Rom's own weights in NumPy."""

import numpy as np
import pytest
from media import LINE, noise, on

from warpfluid.rendering.camera import orthographic
from warpfluid.rendering.marching import OVERSHOOT, march
from warpfluid.rendering.medium import Curve, Medium

MATRIX = np.array([[0, 2, 0, 0], [-1, 0, 1, 0], [2, -5, 4, -1], [-1, 3, -3, 1]]) / 2  # of 1, t, t^2, t^3


def weights(places, count):
    """What each of ``count`` points has in each place, shape (place, count)."""
    found = np.zeros((len(places), count + 6))
    for row, place in zip(found, places, strict=True):
        low = int(np.floor(place))
        row[low + 2 : low + 6] = (place - low) ** np.arange(4) @ MATRIX
    return found[:, 3:-3]


def glow(volume, device="cpu"):
    """A medium that gives off its own density."""
    return Medium(fields={"density": on(device, volume)}, emission=Curve("density", 4, 4 * LINE))


def test_a_picture_is_the_separable_sum(device):
    """Seen from the front at three pixels a voxel, each plane is interpolated by itself; below 0 there is nothing."""
    volume = noise((9, 7, 8))
    camera = orthographic(volume.shape, size=(27, 24))
    columns, rows, _ = camera.project([[0, 0, 0], [1, 1, 0]]).T
    across = weights((np.arange(27) - columns[0]) / (columns[1] - columns[0]), 9)
    above = weights((np.arange(24) - rows[0]) / (rows[1] - rows[0]), 8)
    planes = np.maximum(np.einsum("ux,vy,xzy->zvu", across, above, volume), 0)
    picture = march(glow(volume, device), camera, interpolation="cubic")
    np.testing.assert_allclose(picture.color[..., 0], planes.sum(axis=0), rtol=1e-4, atol=1e-5)
    np.testing.assert_allclose(picture.density, planes.sum(axis=0), rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("seed", range(3))
def test_it_stays_within_its_bounds(seed):
    """Not below 0, and not above what bricks allow for, in the wildest volumes."""
    volume = (np.random.default_rng(seed).random((8, 8, 8)) > 0.7).astype(np.float32)
    camera = orthographic(volume.shape, 35, 20, size=(64, 64))
    medium = Medium(fields={"density": on("cpu", volume)}, extinction=Curve("density", 1, LINE))
    picture = march(medium, camera, interpolation="cubic")
    assert picture.density.min() >= 0
    assert picture.density.max() < OVERSHOOT * 8 * np.sqrt(3)
    assert 0 <= picture.alpha.min() <= picture.alpha.max() <= 1


def test_voxels_do_not_show_close_up(device):
    """The slope of the light across a puff has no steps; linear light has one at every voxel."""
    x = np.arange(17) - 8
    ball = np.exp(-(x[:, None, None] ** 2 + x[:, None] ** 2 + x**2) / 8)
    camera = orthographic(ball.shape, size=(170, 170))
    bends = []
    for kind in ("linear", "cubic"):
        row = march(glow(ball, device), camera, interpolation=kind).color[85, :, 0]
        bends.append(np.abs(np.diff(row, 3)).max() / row.max())
    assert bends[1] < 0.3 * bends[0]


def test_finer_volumes_come_nearer():
    """Light that rises steeply with a field is nearer to that of a volume three times as fine than linear light is."""
    x = (np.arange(36) - 17.5) / 3
    ball = np.exp(-(x[:, None, None] ** 2 + x[:, None] ** 2 + x**2) / 6)
    coarse = ball[1::3, 1::3, 1::3]
    steep = Curve("density", 1, np.linspace(0, 1, 101) ** 6)
    lights = []
    for volume, size, kind in ((coarse, 12, "linear"), (coarse, 12, "cubic"), (ball, 36, "linear")):
        medium = Medium(fields={"density": on("cpu", volume)}, emission=steep)
        picture = march(medium, orthographic(volume.shape, 30, 20, size=(72, 72)), interpolation=kind)
        lights.append(picture.color[..., 0].mean() * 12 / size)
    linear, cubic, truth = lights
    assert abs(cubic / truth - 1) < 0.3 * abs(linear / truth - 1)


def test_unknown_kinds_are_refused():
    """With those that there are."""
    with pytest.raises(ValueError, match="linear or cubic"):
        march(glow(np.ones((3, 3, 3))), orthographic((3, 3, 3)), interpolation="nearest")
