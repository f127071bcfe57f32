"""A liquid is a fluid that is heavier than the air around it, in proportion to its density."""

import warp as wp

from warpfluid.kernels import vectors
from warpfluid.kernels.fluid import decay
from warpfluid.simulation.physics import Physics
from warpfluid.simulation.state import FluidState


def liquid_mass(physics: Physics, state: FluidState, frame: float) -> wp.array | None:
    """Return the mass of a voxel against that of air, shape (x, z, y); None for a gas."""
    weight = physics.number("liquid_weight", frame)
    if weight == 0:
        return None
    share = decay.make_mask(state.density, reference=physics.placing.reference)
    return vectors.add_scaled(_ones(share), weight, share, out=share)


def share_of_gravity(mass: wp.array) -> wp.array:
    """Return the share (m - 1) / m of gravity that air leaves to what is m times as heavy, shape of ``mass``."""
    heavier = vectors.add_scaled(mass, -1.0, _ones(mass), out=wp.empty_like(mass))
    return vectors.divide(heavier, mass, floor=0.0, out=heavier)


def _ones(like: wp.array) -> wp.array:
    return wp.full(like.shape, 1.0, dtype=float, device=like.device)
