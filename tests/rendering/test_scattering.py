"""A ball of smoke against photons that are followed one by one, as path tracers do."""

import numpy as np
import pytest
import warp as wp

from warpfluid.rendering.camera import orthographic
from warpfluid.rendering.harmonics import uniform
from warpfluid.rendering.lighting import Lighting, Sun
from warpfluid.rendering.marching import march
from warpfluid.rendering.medium import Curve, Medium
from warpfluid.rendering.shadows import light_volume

SIZE, RADIUS = 48, 18.0
FRONT, SIDE = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])


def to_edge(places, directions):
    """Distance from places in the unit ball to its surface."""
    along = (places * directions).sum(axis=-1)
    return np.sqrt(np.maximum(along**2 + 1 - (places**2).sum(axis=-1), 0)) - along


def follow_photons(depth, albedo, sun, count=40000):
    """Mean radiance over the disc that the ball shows: in uniform light of 1, or in a sun of irradiance pi."""
    rng = np.random.default_rng(0)
    flat = rng.uniform(-1, 1, (2 * count, 2))
    flat = flat[(flat**2).sum(axis=1) < 1][:count]
    places = np.column_stack([flat, np.sqrt(1 - (flat**2).sum(axis=1))])
    directions, weight, total = np.tile(-FRONT, (len(flat), 1)), np.ones(len(flat)), 0.0
    while weight.size and weight.max() > 1e-3:
        step = rng.exponential(1 / depth, len(weight))
        out = step >= to_edge(places, directions)
        total += weight[out].sum() if sun is None else 0
        places = (places + step[:, None] * directions)[~out]
        weight = albedo * weight[~out]
        if sun is not None:
            total += (weight * np.exp(-depth * to_edge(places, sun)) / 4).sum()
        directions = rng.standard_normal((len(weight), 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return total / len(flat)


def rendered(depth, albedo, sun):
    """The same by the marcher."""
    places = np.indices((SIZE,) * 3) - (SIZE - 1) / 2
    ball = np.clip(RADIUS + 0.5 - np.sqrt((places**2).sum(axis=0)), 0, 1).astype(np.float32)
    curve = {"extinction": Curve("density", 1.0, [0, depth / RADIUS]), "albedo": Curve("density", 1.0, [albedo])}
    medium = Medium(fields={"density": wp.array(ball)}, **curve)
    lighting = Lighting((), uniform((1, 1, 1))) if sun is None else Lighting((Sun(sun, np.pi),))
    picture = march(medium, orthographic(ball.shape), lighting=lighting, **light_volume(medium, lighting).for_march())
    rows, columns = np.indices((SIZE, SIZE)) - (SIZE - 1) / 2
    light = picture.over(np.ones(3)) if sun is None else picture.color
    return light[np.hypot(rows, columns) < RADIUS].mean()


@pytest.mark.parametrize("sun", [None, FRONT, SIDE], ids=["sky", "sun in front", "sun at the side"])
@pytest.mark.parametrize(("depth", "albedo", "within"), [(1.0, 0.9, 0.03), (4.0, 0.5, 0.08), (4.0, 0.9, 0.09)])
def test_as_bright_as_photons_say(depth, albedo, within, sun):
    """Over light that is scattered once to often; single scattering alone would be 0.4 to 0.8 of it in a sun."""
    assert rendered(depth, albedo, sun) == pytest.approx(follow_photons(depth, albedo, sun), rel=within)
