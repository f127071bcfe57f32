"""A liquid is a fluid that is heavier than the air around it, in proportion to its density, and has a surface."""

import warp as wp

from warpfluid.kernels import vectors
from warpfluid.kernels.fluid import decay
from warpfluid.kernels.fluid.surface import sharpen
from warpfluid.simulation.physics import Physics
from warpfluid.simulation.state import FluidState, Solids

SURFACE = 0.5  # width of the surface's profile [voxel]; narrower ones the grid does not carry
SWEEPS, STEP = 4, 0.15  # a solver step's, and how far each draws the surface together [voxel]


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


def draw_together(physics: Physics, state: FluidState, solids: Solids | None, frame: float) -> None:
    """Keep a liquid from fading into mist as it is carried, in place; a gas stays as it is."""
    firmness = physics.number("liquid_surface", frame)
    if not (firmness and physics.number("liquid_weight", frame) and vectors.largest(state.density)):
        return
    around = {"reference": physics.placing.reference, "openings": tuple(solids.open) if solids else ()}
    for _ in range(SWEEPS):
        state.density = sharpen(state.density, physics.sides, width=SURFACE, time_step=STEP * firmness, **around)


def _ones(like: wp.array) -> wp.array:
    return wp.full(like.shape, 1.0, dtype=float, device=like.device)
