"""What the ray marcher's steps may be wrong by, and what they may skip."""

import numpy as np
import pytest
from media import LINE, VIEWS, fine, noise, on

from warpfluid.rendering import marching
from warpfluid.rendering.marching import march
from warpfluid.rendering.medium import Curve, Medium


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("thickness", [0.1, 1.0, 20.0])
def test_keeps_the_error_bound(view, thickness, device):
    """Compared with a march 48 times as fine, also where a ray just touches something hard."""
    volume = noise((20, 20, 13), sigma=2)
    camera = VIEWS[view](volume.shape)
    glow = np.array([0, 0.1, 0.3, 1, 0.8])
    medium = Medium(
        fields={"density": on(device, volume)},
        extinction=Curve("density", 1, thickness * LINE),
        emission=Curve("density", 1, glow),
    )
    picture = march(medium, camera, error=1 / 512)
    curves = {"extinction": lambda f: thickness * f, "emission": lambda f: np.interp(f, np.linspace(0, 1, 5), glow)}
    color, alpha = fine(volume, camera, **curves, steps=48)
    wrong = np.abs(picture.color[..., 0] - color) / np.maximum(1, color)
    for off in (np.abs(picture.alpha - alpha), wrong):
        assert np.mean(off > 1 / 512) < 0.01
        assert off.max() < 2 / 512


def test_a_smaller_error_is_kept_too(device):
    """Intervals are halved as often as they must."""
    volume = noise((20, 20, 13), sigma=2)
    camera = VIEWS["above"](volume.shape)
    medium = Medium(fields={"density": on(device, volume)}, extinction=Curve("density", 1, LINE))
    _, alpha = fine(volume, camera, lambda f: f, lambda f: 0, steps=48)
    off = [np.abs(march(medium, camera, error=error).alpha - alpha) for error in (0.5, 0.01, 0.001)]
    assert off[0].max() > 0.01 > off[1].max()
    assert np.mean(off[2] > 0.001) < 0.01
    assert off[2].mean() < 0.25 * off[1].mean()


@pytest.mark.parametrize("interpolation", marching.INTERPOLATIONS)
@pytest.mark.parametrize("view", VIEWS)
def test_empty_bricks_change_nothing(view, interpolation, device, monkeypatch):
    """Puffs far apart: the same bits without skipping."""
    volume = noise((41, 37, 29), sigma=3) * (noise((41, 37, 29), seed=4, sigma=3) > 0.5)
    medium = Medium(
        fields={"density": on(device, volume)},
        extinction=Curve("density", 1, LINE),
        emission=Curve("density", 1, np.array([0, 0, 0.3, 1])),
    )
    camera = VIEWS[view](volume.shape)
    skipping = march(medium, camera, interpolation=interpolation)
    found = marching._bricks

    def nowhere_dark(*arguments, **options):
        most = found(*arguments, **options).numpy()
        assert (most == 0).any()
        return on(device, np.maximum(most, np.finfo(np.float32).tiny))

    monkeypatch.setattr(marching, "_bricks", nowhere_dark)
    visiting = march(medium, camera, interpolation=interpolation)
    for name in ("color", "alpha", "density", "emission"):
        np.testing.assert_array_equal(getattr(skipping, name), getattr(visiting, name))
    np.testing.assert_allclose(skipping.depth, visiting.depth, atol=0.5)


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize(("thickness", "most"), [(20, 2), (400, 16)])
def test_what_lies_between_planes_is_not_passed_over(view, thickness, most, device):
    """A hard voxel that slanting rays touch on no plane, nor half way between two."""
    volume = np.zeros((9, 9, 9), np.float32)
    volume[4, 4, 4] = 1
    camera = VIEWS[view](volume.shape)
    medium = Medium(fields={"density": on(device, volume)}, extinction=Curve("density", 1, thickness * LINE))
    _, alpha = fine(volume, camera, lambda f: thickness * f, np.zeros_like, steps=200)
    assert np.abs(march(medium, camera).alpha - alpha).max() < most / 512
