"""Frame after frame: a volume that moves on instead of starting anew.

Frames reconstructed alone flicker, because what no view sees is settled differently each time, and averaging them
blurs. So coherence belongs inside the reconstruction: a frame starts from the one before, carried along the footage's
flow. What the pictures show and the carried volume lacks grows from a fresh start; what they do not show is balanced
away. The start is then so near that an iteration or two suffice; the more light was missing, the more are made.
"""

from dataclasses import replace

import numpy as np
import warp as wp

from warpfluid.device import one_blas_thread, pick_device
from warpfluid.kernels import vectors
from warpfluid.kernels.tomography import filling
from warpfluid.motion.carry import carry
from warpfluid.options import ReconstructOptions
from warpfluid.reconstruction.em import Iteration, Progress, finish, footage_facts
from warpfluid.reconstruction.inputs import Inputs, make_inputs
from warpfluid.reconstruction.result import Observer, Reconstruction
from warpfluid.reconstruction.start import SWEEPS, first_volume, rough_start, roughen
from warpfluid.views import Views

TRIAL_SWEEPS = 2
SLACK = 1.2  # a picture lacks what is brighter than this times the trial
GAIN = 2.0  # lacking half of a pixel's light already calls for all of the fresh start
REFRESH = 0.06  # log-amplitude of noise on a carried volume: expanding matter would grow smooth, frame by frame
CUT = 0.5  # share of the light missing after the trial above which the frame is another scene


@one_blas_thread()
def follow(
    previous: np.ndarray,
    now: Views,
    later: Views,
    options: ReconstructOptions,
    *,
    towards: tuple[np.ndarray, float] | None = None,
    progress: Progress | None = None,
    observe: Observer | None = None,
    device: str | wp.Device | None = None,
) -> Reconstruction | None:
    """Model the frame after one whose volume is known.

    Args:
        previous: Volume of the frame before, shape (x, z, y).
        now: Views of the frame before.
        later: Views of the frame to model, at the same angles.
        options: Choices of the method; at least ``coherent_iterations`` are made.
        towards: Another volume of the frame to model, shape (x, z, y), and how much of the start it makes up, 0-1.
        progress: Called after each iteration with its number and the energy.
        observe: Called after each iteration with its pictures and the volume.
        device: Where to compute; the first GPU there is when omitted.

    Returns:
        The reconstruction, or None where the frame has too little in common with the one before, as after a cut.
    """
    options = options.settled(**footage_facts(later))
    few, full = options.coherent_iterations, options.iterations
    device = pick_device(device)
    inputs = make_inputs(later, options, device)
    if not (inputs.images > inputs.threshold).any():
        return None
    carried = carry(previous * np.float32(255 / now.white), now, later, method=options.flow, device=device)
    if towards is not None:
        other, weight = towards
        carried += np.float32(weight) * (other * np.float32(255 / later.white) - carried)
    initial = first_volume(inputs, options)
    volume, lacking = filled_start(inputs, options, carried, rough_start(inputs, options, initial))
    if lacking > CUT:
        return None
    roughen(volume, inputs, options, amplitude=min(REFRESH, options.start_noise))
    options = replace(options, iterations=few + round(lacking / CUT * max(full - few, 0)))
    modelled = Iteration(inputs, options).run(volume, progress, fade_first=True, observe=observe)
    return finish(later, options, inputs, modelled, initial)


def filled_start(
    inputs: Inputs, options: ReconstructOptions, carried: np.ndarray, fresh: wp.array
) -> tuple[wp.array, float]:
    """Turn a carried volume into a start: inside the hull, with new matter where it lacks some, balanced.

    Args:
        inputs: The inputs of the frame.
        options: Choices of the method.
        carried: Shape (x, z, y) of the whole box, in grey levels of linear light.
        fresh: The start of a frame alone, over the inputs' part of the box.

    Returns:
        The start, over the inputs' part of the box, and the share of the light that was missing.
    """
    device = inputs.hull.device
    volume = wp.array(np.ascontiguousarray(carried[inputs.part]), dtype=float, device=device)
    vectors.multiply(volume, inputs.support, out=volume)
    balancing = inputs.balancing(options.footprint)
    trial = balancing.apply(wp.clone(volume), TRIAL_SWEEPS)
    lack, missing, light = wp.zeros_like(volume), 0.0, 0.0
    for view, image, seen in balancing.views:
        share = view.project(trial)
        filling.missing(image, share, slack=SLACK, out=share)
        missing += vectors.dot(share, image)
        light += float(image.numpy().sum(dtype=np.float64))
        filling.widen(lack, view.backproject(share), seen)
    filling.fill(volume, lack, fresh, gain=GAIN)
    return balancing.apply(volume, SWEEPS), missing / max(light, 1e-9)
