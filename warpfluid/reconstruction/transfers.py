"""The M-steps: each gives rendered views the look of the inputs in its own way."""

from typing import Protocol

import numpy as np

from warpfluid.options import ReconstructOptions
from warpfluid.reconstruction.appearance import AppearanceTransfer
from warpfluid.reconstruction.portilla_simoncelli import PortillaSimoncelli
from warpfluid.reconstruction.texture_optimization import TextureOptimization


class Transfer(Protocol):
    """An M-step, made for a fan of views."""

    def transfer(self, rendered: np.ndarray, mask: np.ndarray) -> np.ndarray:
        """Modify rendered views, shape (angle, u, v), black outside the mask of that shape."""


def make_transfer(
    images: np.ndarray, angles_deg: tuple[float, ...], fan_deg: tuple[float, ...], options: ReconstructOptions
) -> Transfer:
    """Return the M-step that the options name.

    Args:
        images: How views should look, shape (view, u, v).
        angles_deg: Their angles, distinct and in [0, 180) [degree].
        fan_deg: Angles of the views to transfer to, in [0, 180) [degree].
        options: All settled.

    Raises:
        ValueError: If the images are smaller than a patch.
    """
    return TRANSFERS[options.transfer](images, angles_deg, fan_deg, options)


def _histograms(images, angles_deg, fan_deg, options: ReconstructOptions) -> AppearanceTransfer:
    choices = {"height": options.scales, "interpolation": options.interpolation}
    parted = options.highpass == "parted"
    return AppearanceTransfer(images, angles_deg, fan_deg, **choices, part_highpass=parted)


def _texture_optimization(images, angles_deg, fan_deg, options: ReconstructOptions) -> TextureOptimization:
    return TextureOptimization(images, angles_deg, fan_deg, patch=options.patch)


def _portilla_simoncelli(images, angles_deg, fan_deg, options: ReconstructOptions) -> PortillaSimoncelli:
    return PortillaSimoncelli(images, angles_deg, fan_deg, height=options.scales, sweeps=options.sweeps)


TRANSFERS = {
    "histograms": _histograms,
    "texture-optimization": _texture_optimization,
    "portilla-simoncelli": _portilla_simoncelli,
}
