"""Light scattered often, against what is known of uniform light and of a half-space; coarse lattices and curves."""

import numpy as np
import pytest
import warp as wp

from warpfluid.kernels.coarsen import coarsen, refine
from warpfluid.kernels.light.curves import look_up
from warpfluid.kernels.light.scattered import add_light, scatter_again

CHANDRASEKHAR_H1 = 2.9078  # H(1) for isotropic scattering without absorption


def lit(transmittance, albedo, *, suns=(), irradiance=(), radiance=(1, 2, 3)):
    """Ambient light where only one direction counts, for all."""
    through = wp.array(transmittance, dtype=float)
    light = wp.zeros((7, *through.shape), dtype=float)
    add_light(through, weight=0.5, radiance=radiance, light=light)
    add_light(through, weight=0.5, radiance=radiance, light=light)
    curve = wp.array(np.full((1, 3), albedo), dtype=wp.vec3)
    colors = wp.array(np.reshape(irradiance, (-1, 3)), dtype=wp.vec3)
    suns = wp.array(np.reshape(suns, (-1, *through.shape)), dtype=float)
    return scatter_again(light, through, curve, suns, colors, factor=1, top=1.0).numpy()


def test_uniform_light_without_absorption_is_uniform():
    """However little comes through."""
    through = np.exp(-np.random.default_rng(0).random((4, 5, 50)) * 30)
    np.testing.assert_allclose(lit(through, 1.0), np.broadcast_to([1, 2, 3], (*through.shape, 3)), rtol=1e-5)


@pytest.mark.parametrize("albedo", [0.0, 0.6, 0.95])
def test_closed_form(albedo):
    """J / (1 - albedo (1 - P)); nothing is added where nothing scatters."""
    through = np.random.default_rng(0).random((4, 5, 50))
    expected = through / (1 - albedo * (1 - through))
    np.testing.assert_allclose(lit(through, albedo)[..., 1], 2 * expected, rtol=1e-5)


def test_half_space_in_the_sun():
    """Seen from the sun, a thick slab that absorbs nothing is H(1)^2 / 8 pi as bright as its irradiance."""
    depth = np.linspace(0, 14, 2801)
    mu = (np.arange(400) + 0.5) / 400
    escape = 0.5 * np.exp(-depth[:, None] / mu).mean(axis=1)
    sun = np.exp(-depth)
    again = lit(escape.reshape(1, 1, -1), 1.0, suns=sun, irradiance=[1, 1, 1], radiance=(0, 0, 0))[0, 0, :, 0]
    seen = np.trapezoid(np.exp(-depth) * (sun / (4 * np.pi) + again), depth)
    assert seen == pytest.approx(CHANDRASEKHAR_H1**2 / (8 * np.pi), rel=0.1)


def test_sun_where_nothing_escapes():
    """Bounded, not infinite."""
    dark = lit(np.zeros((1, 1, 3)), 1.0, suns=np.full((1, 1, 3), 0.5), irradiance=[4 * np.pi] * 3)
    assert (dark < 0.5 * 10.1).all()


@pytest.mark.parametrize("shape", [(8, 6, 50), (7, 5, 49), (1, 1, 1)])
@pytest.mark.parametrize("factor", [1, 2, 3])
def test_coarse_and_back(shape, factor, device):
    """Means of cubes, which are 0 beyond the border; a ramp comes back as it was, but at the border."""
    field = np.random.default_rng(1).random(shape, np.float32)
    coarse = coarsen(wp.array(field, device=device), factor=factor)
    padded = np.pad(field, [(0, -n % factor) for n in shape])
    split = [part for n in padded.shape for part in (n // factor, factor)]
    np.testing.assert_allclose(coarse.numpy(), padded.reshape(split).mean(axis=(1, 3, 5)), rtol=1e-5)
    if min(shape) % factor == 0:
        ramp = np.indices(shape).sum(axis=0).astype(np.float32)
        back = wp.empty(shape, dtype=float, device=device)
        refine(coarsen(wp.array(ramp, device=device), factor=factor), factor=factor, out=back)
        inner = tuple(slice(factor, -factor) for _ in shape)
        np.testing.assert_allclose(back.numpy()[inner], ramp[inner], rtol=1e-5, atol=1e-4)


def test_curve(device):
    """As NumPy's, with its ends beyond, times another field or not."""
    field = np.random.default_rng(2).uniform(-1, 4, (3, 4, 60)).astype(np.float32)
    entries = np.array([0.5, 2.0, 1.0, 4.0], np.float32)
    read = look_up(wp.array(field, device=device), wp.array(entries, device=device), top=3.0)
    expected = np.interp(field, np.arange(4), entries)
    np.testing.assert_allclose(read.numpy(), expected, rtol=1e-5)
    times = wp.array(field, device=device)
    read = look_up(times, wp.array(entries, device=device), top=3.0, times=times)
    np.testing.assert_allclose(read.numpy(), expected * np.maximum(field, 0), rtol=1e-5)


def test_curve_rises_from_the_sides(device):
    """Smoothly over some voxels, not at all in the middle."""
    ones = wp.full((8, 9, 20), 1.0, dtype=float, device=device)
    read = look_up(ones, wp.array([2.0], dtype=float, device=device), top=1.0, edge_fade=2.0).numpy()
    part = np.array([0.25, 0.75])
    np.testing.assert_allclose(read[:2, 4, 10], 2 * part**2 * (3 - 2 * part), rtol=1e-5)
    assert (read[2:-2, 2:-2, 2:-2] == 2).all()
    np.testing.assert_array_equal(read, read[::-1, ::-1, ::-1])
