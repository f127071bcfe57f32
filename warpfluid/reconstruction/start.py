"""The volume that the iteration starts from.

Least squares alone (Eq. 3) smears light along the rays. A little smooth noise gives appearance transfer something to
sharpen that is not a smear; balancing then makes the input views right again.
"""

import functools

import numpy as np
import warp as wp

from warpfluid.balance import Balancing
from warpfluid.kernels import vectors
from warpfluid.kernels.blur import blur
from warpfluid.options import ReconstructOptions
from warpfluid.reconstruction.couplings import flame_sheet, multiplication
from warpfluid.reconstruction.inputs import Inputs
from warpfluid.reconstruction.lsm import initial_volume

SWEEPS = 5


def least_squares(inputs: Inputs, options: ReconstructOptions) -> wp.array:
    """Return the volume of least squares on the inputs (Eq. 3), over the inputs' part of the box."""
    projector = inputs.projector(inputs.angles_deg[: inputs.fitted], options.footprint)
    images = wp.array(inputs.images[: inputs.fitted], dtype=float, device=projector.device)
    return initial_volume(projector, images, steps=options.lsm_steps, non_negative=options.non_negative)


STARTS = {"lsm": least_squares, "multiplication": multiplication, "flame-sheet": flame_sheet}


def first_volume(inputs: Inputs, options: ReconstructOptions) -> wp.array:
    """Return the volume that appearance transfer begins with, over the inputs' part of the box."""
    return STARTS[options.start](inputs, options)


def rough_start(inputs: Inputs, options: ReconstructOptions, initial: wp.array) -> wp.array:
    """Return the initial volume, or front times side for one view, made uneven and balanced."""
    looks = inputs.images if inputs.side is None else np.stack([inputs.images[0], inputs.side])
    if inputs.side is None or options.start != "lsm":
        volume = vectors.multiply(initial, inputs.support, out=wp.empty_like(initial))
    else:
        volume = _product(inputs, looks, options.footprint)
    if options.start_noise > 0:
        roughen(volume, inputs, options, amplitude=options.start_noise)
        if options.non_negative:
            balancing = Balancing(looks, inputs.projectors(inputs.angles_deg, options.footprint))
            balancing.apply(volume, SWEEPS)
    return volume


def roughen(volume: wp.array, inputs: Inputs, options: ReconstructOptions, *, amplitude: float) -> None:
    """Multiply a volume by log-normal noise, in place; the seed is that of the options, so the same in every frame."""
    if amplitude == 0:
        return
    noise = _noise(inputs.box, options.seed, options.noise_grain, options.noise_grain_y)[inputs.part]
    factor = wp.array(np.exp(np.float32(amplitude) * noise), dtype=float, device=volume.device)
    vectors.multiply(volume, factor, out=volume)


def given_start(inputs: Inputs, options: ReconstructOptions, volume: np.ndarray) -> wp.array:
    """Return a volume from outside, kept within the hull and balanced against the measured views.

    Args:
        inputs: The inputs of the frame.
        options: Choices of the method.
        volume: Shape (x, z, y) of the whole box, in grey levels of linear light.

    Raises:
        ValueError: If the shape is another.
    """
    if volume.shape != inputs.box:
        raise ValueError(f"start has shape {volume.shape}, expected {inputs.box}: (x, z, y) of these views")
    start = wp.array(np.maximum(volume[inputs.part], 0), dtype=float, device=inputs.hull.device)
    vectors.multiply(start, inputs.support, out=start)
    return inputs.balancing(options.footprint).apply(start, SWEEPS)


def _product(inputs: Inputs, looks: np.ndarray, footprint: str) -> wp.array:
    """Multiply front and side: a start without the cross that their sum has."""
    device = inputs.hull.device
    pair = zip(inputs.projectors(inputs.angles_deg, footprint), looks, strict=True)
    front, side = (p.backproject(wp.array(look[None], dtype=float, device=device)) for p, look in pair)
    per_row = (1 / np.maximum(inputs.row_sums, 1)).astype(np.float32)
    scale = wp.array(np.broadcast_to(per_row, front.shape), dtype=float, device=device)
    vectors.multiply(front, side, out=front)
    return vectors.multiply(front, scale, out=front)


@functools.lru_cache(maxsize=1)
def _noise(shape: tuple[int, int, int], seed: int, grain: float, grain_y: float) -> np.ndarray:
    """Smooth Gaussian noise of unit deviation; the frames of a sequence share one, or they would flicker."""
    white = np.random.default_rng(seed).standard_normal(shape).astype(np.float32)
    smooth = blur(wp.array(white, dtype=float, device="cpu"), (grain, grain, grain_y)).numpy()
    return smooth / max(float(smooth.std()), 1e-12)
