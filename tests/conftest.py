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
        ndimage.gaussian_filter(rng.standard_normal((size, size, height)), (grain, grain, 2 * grain)) * grain**2
        for grain in (1, 2, 3)
    )
    x = np.arange(size) - (size - 1) / 2
    radius = np.hypot(x[:, None], x)[..., None] / (0.42 * size * np.linspace(1, 0.5, height))
    volume = np.maximum(noise / noise.std() + 1 - 3 * radius**2, 0) ** 2
    volume[..., :2] = volume[..., -2:] = 0
    return (volume * 255 / volume.sum(axis=1).max()).astype(np.float32)
