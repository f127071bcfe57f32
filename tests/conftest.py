"""What the tests share: the devices of this machine, and a small fire whose every view is known."""

import os

import numpy as np
import pytest
import warp as wp
from hypothesis import settings
from scipy import ndimage

from warpfluid.device import start_warp

start_warp()

# A kernel that is compiled on its first launch takes seconds. Under CI every run tries the same examples.
settings.register_profile("warpfluid", deadline=None, derandomize="CI" in os.environ)
settings.load_profile("warpfluid")


@pytest.fixture(scope="session", params=[str(device) for device in wp.get_devices()])
def device(request) -> str:
    """Every device there is, by name; the CPU always is one."""
    return request.param


@pytest.fixture(scope="session")
def fire() -> np.ndarray:
    """A flame-like volume (x, z, y): stretched noise, cut into wisps inside a cone; brightest pixel 255."""
    size, height = 48, 40
    rng = np.random.default_rng(5)
    noise = sum(
        weight * ndimage.gaussian_filter(rng.standard_normal((size, size, height)), (g, g, 2 * g)) * g**2
        for g, weight in ((1, 1), (2, 1.2), (4, 1.5))
    )
    middle = (size - 1) / 2
    x = np.arange(size) - middle
    radius = np.hypot(x[:, None], x)[..., None] / (middle * 0.85 * np.linspace(1, 0.5, height))
    volume = np.maximum(noise - 1.2 * radius**2, 0) * (radius < 1)
    return (volume * 255 / volume.sum(axis=1).max()).astype(np.float32)
