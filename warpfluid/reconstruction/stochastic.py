"""Stochastic tomography: the energy falls by random walks (Gregson et al. 2012; Section 5).

Chains add or take quanta of light wherever that lowers the squared differences of the views plus a weighted sum of
absolute differences between neighbours (SAD), and stay where that pays. Sweeps follow each other with smaller and
smaller quanta. A change of a few voxels alone cannot leave the corners that absolute differences have, so a proposal
that raises the energy is applied, too, with Metropolis's probability at a temperature of ``sad`` times the quantum;
the last sweeps are cold.
"""

import math
from dataclasses import dataclass

import numpy as np
import warp as wp

from warpfluid.kernels.tomography import stochastic
from warpfluid.projector import directions
from warpfluid.reconstruction.convex import Progress, SadEnergy

SWEEPS = 48
COLD = 1 / 6  # share of the sweeps, the last ones
FINEST = 2.0**-8  # the smallest quantum over the first


@dataclass(frozen=True)
class WalkOptions:
    """What a random walk is told.

    Attributes:
        mutations: Proposals of all chains together.
        chains: Number of chains; at least one a slab.
        quantum: The first quantum [grey level].
        seed: Of the random numbers.
        sweeps: Number of sweeps that share the mutations.
        first_sweep: Number of the first; other sweeps have other random numbers.
        heat: Temperature of the warm sweeps over the SAD of a quantum between two voxels; 0 only ever goes down.
    """

    mutations: int
    chains: int
    quantum: float
    seed: int
    sweeps: int = SWEEPS
    first_sweep: int = 0
    heat: float = 1.0


@dataclass(frozen=True)
class Walk:
    """How a random walk went.

    Attributes:
        energies: Before and after each sweep, shape (sweep, 2).
        rates: Share of the proposals that were applied, and quantum [grey level], shape (sweep, 2).
    """

    energies: np.ndarray
    rates: np.ndarray


def random_walk(energy: SadEnergy, volume: wp.array, options: WalkOptions, *, progress: Progress | None = None) -> Walk:
    """Lower the energy by random walks, in place.

    Args:
        energy: What to lower.
        volume: Where to start, zero outside the hull, shape (x, z, y).
        options: Mutations, chains, quantum and seed.
        progress: Called after each sweep with its number and the energy.

    Returns:
        Energies, acceptance rates and quanta of all sweeps.
    """
    chains = _Chains(energy, volume.shape, options)
    energies, rates = np.zeros((options.sweeps, 2)), np.zeros((options.sweeps, 2))
    warm, before = math.ceil(options.sweeps * (1 - COLD)), energy(volume)
    for sweep in range(options.sweeps):
        quantum = options.quantum * FINEST ** min(sweep / max(warm - 1, 1), 1)
        heat = options.heat * energy.weight * quantum if sweep < warm else 0.0
        rates[sweep] = chains.sweep(volume, quantum, heat, sweep), quantum
        energies[sweep] = before, energy(volume)
        before = energies[sweep, 1]
        if progress:
            progress(sweep + 1, before)
    return Walk(energies, rates)


class _Chains:
    """All chains of a walk, with arrays in the order of slices: a thread's memory lies together."""

    def __init__(self, energy: SadEnergy, shape: tuple[int, int, int], options: WalkOptions):
        self._energy, self._options, self._device = energy, options, energy.projector.device
        hull = energy.projector.hull.numpy() > 0
        self._inside = hull.sum(axis=(0, 1))
        self._hull = wp.array(np.ascontiguousarray(hull.transpose(2, 0, 1)), dtype=wp.uint8, device=self._device)
        weights = np.ones(len(energy.projector.angles_deg)) if energy.weights is None else energy.weights
        self._weights = wp.array(weights, dtype=float, device=self._device)
        self._directions = directions(np.array(energy.projector.angles_deg), self._device)
        slabs = len(_slabs(shape[2], stochastic.SLAB // 2))
        self._a_slab = max(1, round(options.chains / slabs))
        rng = np.random.default_rng(options.seed)
        self._places = rng.integers((*shape[:2], stochastic.SLAB), size=(slabs * self._a_slab, 3)).astype(np.int32)

    def sweep(self, volume: wp.array, quantum: float, heat: float, sweep: int) -> float:
        """Let all chains walk; return the share of the proposals that were applied."""
        options, projector = self._options, self._energy.projector
        shift = stochastic.SLAB // 2 * (sweep % 2)
        counts = self._steps(_slabs(volume.shape[2], shift))
        used = len(counts) * self._a_slab
        places = wp.array(self._places[:used], dtype=int, device=self._device)
        accepted = wp.zeros(len(counts), dtype=int, device=self._device)
        levels = volume.transpose((2, 0, 1)).contiguous()
        residual = self._energy.residual.transpose((2, 0, 1)).contiguous()
        stochastic.walk(
            levels,
            residual,
            self._hull,
            self._directions,
            self._weights,
            wp.array(counts, dtype=int, device=self._device),
            places,
            accepted,
            quantum=quantum,
            sad=self._energy.weight,
            heat=heat,
            seed=options.seed,
            sweep=options.first_sweep + sweep,
            shift=shift,
            corner=projector.corner,
            footprint=projector.footprint,
        )
        wp.copy(volume, levels.transpose((1, 2, 0)).contiguous())
        self._places[:used] = places.numpy()
        return float(accepted.numpy().sum() / max(counts.sum() * self._a_slab, 1))

    def _steps(self, slabs: range) -> np.ndarray:
        """Share the mutations of a sweep out to the slabs by the voxels of the hull in them."""
        inside = np.add.reduceat(self._inside, [max(bottom, 0) for bottom in slabs])
        share = self._options.mutations / self._options.sweeps / self._a_slab * inside / max(inside.sum(), 1)
        return np.where(inside > 0, np.maximum(np.rint(share), 1), 0).astype(np.int32)


def _slabs(heights: int, shift: int) -> range:
    """Return where the slabs begin that cover all heights, the first below them."""
    return range(-shift, heights, stochastic.SLAB)
