"""The systems that appearance transfer is compared with (Section 5), each a volume from the views of one frame."""

from dataclasses import dataclass, field

import numpy as np
import warp as wp

from warpfluid.options import MUTATIONS_A_VOXEL, MUTATIONS_A_VOXEL_AND_E_STEP, ReconstructOptions
from warpfluid.reconstruction import convex, couplings, stochastic
from warpfluid.reconstruction.convex import Progress, SadEnergy
from warpfluid.reconstruction.inputs import Inputs
from warpfluid.reconstruction.start import least_squares

SWEEPS_AN_E_STEP = 12


@dataclass(frozen=True)
class Modelled:
    """What a system makes of a frame.

    Attributes:
        volume: Over the inputs' part of the box.
        energies: Before and after each round of what lowers an energy, shape (round, 2).
        walk: Share of applied proposals and quantum of each sweep of a random walk, shape (sweep, 2).
    """

    volume: wp.array
    energies: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    walk: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))


def model(inputs: Inputs, options: ReconstructOptions, progress: Progress | None = None) -> Modelled:
    """Model a volume with the system that the options name, any but appearance transfer.

    Args:
        inputs: The inputs of the frame.
        options: All settled.
        progress: Called after each round of an iterative system with its number and the energy.
    """
    return SYSTEMS[options.method](inputs, options, progress)


def round_count(options: ReconstructOptions) -> int:
    """Return how often ``progress`` is called for a frame."""
    rounds = {
        "appearance-transfer": options.iterations,
        "stochastic": stochastic.SWEEPS,
        "convex": -(-options.convex_steps // convex.STEPS_A_CHECK),
    }
    return rounds.get(options.method, 1)


def walk_options(options: ReconstructOptions, voxels: float, *, e_step: int | None = None) -> stochastic.WalkOptions:
    """Return what a random walk is told.

    Args:
        options: Mutations, chains, quantum and seed.
        voxels: Of the hull.
        e_step: Its number, for a walk that is an E-step.
    """
    a_voxel = MUTATIONS_A_VOXEL if e_step is None else MUTATIONS_A_VOXEL_AND_E_STEP
    return stochastic.WalkOptions(
        mutations=options.mutations or max(round(a_voxel * voxels), 1),
        chains=options.chains,
        quantum=options.quantum,
        seed=options.seed,
        sweeps=stochastic.SWEEPS if e_step is None else SWEEPS_AN_E_STEP,
        first_sweep=0 if e_step is None else e_step * SWEEPS_AN_E_STEP,
        heat=1.0 if e_step is None else 0.0,
    )


def _energy(inputs: Inputs, options: ReconstructOptions) -> tuple[SadEnergy, wp.array]:
    """Return the energy of stochastic tomography for the measured views, and an empty volume."""
    projector = inputs.projector(inputs.angles_deg[: inputs.fitted], options.footprint, soft=False)
    images = wp.array(inputs.images[: inputs.fitted], dtype=float, device=projector.device)
    empty = wp.zeros(projector.shape, dtype=float, device=projector.device)
    return SadEnergy(projector, images, options.sad_weight), empty


def _stochastic(inputs: Inputs, options: ReconstructOptions, progress: Progress | None) -> Modelled:
    energy, volume = _energy(inputs, options)
    voxels = float(inputs.support.numpy().sum(dtype=np.float64))
    walk = stochastic.random_walk(energy, volume, walk_options(options, voxels), progress=progress)
    return Modelled(volume, walk.energies, walk.rates)


def _convex(inputs: Inputs, options: ReconstructOptions, progress: Progress | None) -> Modelled:
    energy, volume = _energy(inputs, options)
    return Modelled(volume, convex.minimise(energy, volume, steps=options.convex_steps, progress=progress))


SYSTEMS = {
    "lsm": lambda inputs, options, _: Modelled(least_squares(inputs, options)),
    "stochastic": _stochastic,
    "convex": _convex,
    "multiplication": lambda inputs, options, _: Modelled(couplings.multiplication(inputs, options)),
    "flame-sheet": lambda inputs, options, _: Modelled(couplings.flame_sheet(inputs, options)),
}
