"""How a fluid carries a body along: what it does around it, and the drag of that."""

from collections.abc import Callable

import numpy as np
import warp as wp

from warpfluid.kernels.fluid.probe import probe
from warpfluid.simulation.placed import SWAP
from warpfluid.simulation.state import FluidState

# Where points are, (x, y, z), shape (n, 3): the fluid's velocity there [voxel/s], shape (n, 3), and how heavy it is,
# shape (n,), from 0 for empty air to 1.
Flow = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


def flow_around(state: FluidState, reference: float) -> Flow:
    """Return a fluid as bodies feel it.

    Args:
        state: The fluid; it is read when the flow is asked.
        reference: Density at and above which the fluid drags in full; thinner fluid drags less, empty air not at all.

    Raises:
        ValueError: If the reference is not positive.
    """
    if not reference > 0:
        raise ValueError(f"reference is {reference}, expected a density above 0")

    def flow(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        swapped = points @ SWAP
        places = wp.array(swapped, dtype=wp.vec3, device=state.density.device)
        shifts = np.eye(3) / 2
        speeds = [probe(part, places, shift=tuple(shift)) for part, shift in zip(state.velocity, shifts, strict=True)]
        shares = np.clip(probe(state.density, places).numpy() / reference, 0, 1)
        beyond = ((swapped < -0.5) | (swapped > np.array(state.density.shape) - 0.5)).any(axis=1)
        return np.stack([speed.numpy() for speed in speeds], axis=1) @ SWAP, np.where(beyond, 0, shares)

    return flow


def crosses(arms: np.ndarray) -> np.ndarray:
    """Return the matrices that take the cross product with vectors (n, 3), shape (n, 3, 3)."""
    zero, (x, y, z) = np.zeros(len(arms)), np.asarray(arms).T
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(-1, 3, 3)


def drag_at(arms: np.ndarray, speeds: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Add up a drag that is linear in the difference of speeds at points of a body.

    Args:
        arms: From the centre of mass to the points, shape (n, 3).
        speeds: Of the fluid there, shape (n, 3).
        weights: Force for a difference of 1, shape (n,).

    Returns:
        The matrix on (velocity, angular velocity) that brakes, shape (6, 6), and the force and torque on a body at
        rest, shape (6,).
    """
    lever = np.concatenate([np.broadcast_to(np.eye(3), (len(arms), 3, 3)), crosses(arms)], axis=1)
    return np.einsum("p,pij,pkj->ik", weights, lever, lever), np.einsum("p,pij,pj->i", weights, lever, speeds)
