"""Stochastic tomography: the energy falls by random walks (Gregson et al. 2012; Section 5).

Chains add or take quanta of light wherever that lowers the squared differences of the views plus a weighted sum of
absolute differences between neighbours (SAD), and stay where that pays. Sweeps follow each other with smaller quanta:
a quantum is halved when few proposals are applied, and never is larger than a geometric course to the smallest.
"""

from dataclasses import dataclass

import numpy as np
import warp as wp

from warpfluid.kernels import stochastic
from warpfluid.projector import directions
from warpfluid.reconstruction.convex import Progress, SadEnergy

SWEEPS = 48
BUSY = 0.1  # share of applied proposals below which quanta are halved
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
    """

    mutations: int
    chains: int
    quantum: float
    seed: int
    sweeps: int = SWEEPS
    first_sweep: int = 0


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
    quantum, smallest, before = options.quantum, options.quantum * FINEST, energy(volume)
    for sweep in range(options.sweeps):
        quantum = min(quantum, options.quantum * FINEST ** (sweep / max(options.sweeps - 1, 1)))
        rates[sweep] = chains.sweep(volume, quantum, sweep), quantum
        energies[sweep] = before, energy(volume)
        before = energies[sweep, 1]
        if rates[sweep, 0] < BUSY:
            quantum = max(quantum / 2, smallest)
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
        slabs = stochastic.slab_count(shape[2], stochastic.SLAB // 2)
        self._a_slab = max(1, round(options.chains / slabs))
        places = np.zeros((slabs * self._a_slab, 4), np.int32)
        rng = np.random.default_rng(options.seed)
        places[:, :3] = rng.integers((*shape[:2], stochastic.SLAB), size=(len(places), 3))
        self._places = places

    def sweep(self, volume: wp.array, quantum: float, sweep: int) -> float:
        """Let all chains walk; return the share of the proposals that were applied."""
        options, projector = self._options, self._energy.projector
        shift = stochastic.SLAB // 2 * (sweep % 2)
        slabs = stochastic.slab_count(volume.shape[2], shift)
        counts = self._steps(slabs, shift)
        used = slabs * self._a_slab
        places = wp.array(self._places[:used], dtype=int, device=self._device)
        accepted = wp.zeros(slabs, dtype=int, device=self._device)
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
            seed=options.seed,
            sweep=options.first_sweep + sweep,
            shift=shift,
            corner=projector.corner,
            footprint=projector.footprint,
        )
        wp.copy(volume, levels.transpose((1, 2, 0)).contiguous())
        self._places[:used] = places.numpy()
        return float(accepted.numpy().sum() / max(counts.sum() * self._a_slab, 1))

    def _steps(self, slabs: int, shift: int) -> np.ndarray:
        """Share the mutations of a sweep out to the slabs by the voxels of the hull in them."""
        edges = np.clip(np.arange(slabs + 1) * stochastic.SLAB - shift, 0, len(self._inside))
        inside = np.add.reduceat(np.append(self._inside, 0), edges[:-1])
        share = self._options.mutations / self._options.sweeps / self._a_slab * inside / max(inside.sum(), 1)
        return np.where(inside > 0, np.maximum(np.rint(share), 1), 0).astype(np.int32)
