"""Emitters: shapes that let in density, fuel, heat and motion."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import warp as wp

from warpfluid.kernels.fluid import emission
from warpfluid.kernels.poisson import shares
from warpfluid.simulation.placed import SWAP, Index, Placed, signed_distance
from warpfluid.simulation.shapes import Plane
from warpfluid.simulation.state import FluidState


@dataclass(frozen=True, eq=False, kw_only=True)
class Emitter:
    """A shape and what comes out of it.

    Attributes:
        placed: The shape, where it is.
        soft_edge: Width around its surface over which it fades out; 0 cuts voxels exactly [voxel].
        density: Let in per second and voxel.
        fuel: Let in per second and voxel.
        temperature: What it is inside at least (or at most, if negative); 0 leaves it alone.
        velocity: What the fluid inside is drawn to (x, y, z) [voxel/s].
        velocity_rate: How fast: the difference falls to a third in one over this [1/s].
        noise: How much density and fuel flicker, from 0 to 1; the temperature is only lowered.
        noise_frequency: Of the coarser of two octaves [cycle/voxel].
        noise_speed: How fast the noise changes [cycle/s].
        seed: Which noise.

    Raises:
        ValueError: If a number makes no sense.
    """

    placed: Placed
    soft_edge: float = 0.0
    density: float = 0.0
    fuel: float = 0.0
    temperature: float = 0.0
    velocity: Sequence[float] = (0.0, 0.0, 0.0)
    velocity_rate: float = 0.0
    noise: float = 0.0
    noise_frequency: float = 0.1
    noise_speed: float = 2.0
    seed: int = 0

    def __post_init__(self):
        if isinstance(self.placed.shape, Plane):
            raise ValueError("an emitter cannot be a plane, which is endless: use a box")
        for name in ("soft_edge", "velocity_rate", "noise_frequency", "noise_speed"):
            if not 0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name} of an emitter is {getattr(self, name)}, expected a number >= 0")
        if not 0 <= self.noise <= 1:
            raise ValueError(f"noise of an emitter is {self.noise}, expected 0 to 1")
        numbers = (self.density, self.fuel, self.temperature, *self.velocity)
        if len(numbers) != 6 or not np.isfinite(numbers).all():
            raise ValueError("rates, temperature and velocity (x, y, z) of an emitter must be finite numbers")


class Outlet(NamedTuple):
    """The voxels that an emitter reaches.

    Attributes:
        first: First voxel (x, z, y) of their block.
        weight: Share of each that emits, shape of the block.
    """

    first: Index
    weight: wp.array


def emit(state: FluidState, emitter: Emitter, time_step: float, *, outlet: Outlet | None = None) -> None:
    """Let an emitter work for one time step, in place.

    A shape with a hard edge that lies inside of the grid adds rate x volume x time step in all, without noise.

    Args:
        state: The fluid; its seconds move the noise on.
        emitter: What comes out where.
        time_step: [s].
        outlet: What ``find_outlet`` found, for an emitter that stays; it is found again by default.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    outlet = outlet or find_outlet(emitter, state.density.shape, state.density.device)
    if outlet is None:
        return
    first, weight = outlet
    if emitter.density or emitter.fuel or emitter.temperature:
        emission.let_in(
            weight,
            state.density,
            state.fuel,
            state.temperature,
            first=first,
            added=(emitter.density * time_step, emitter.fuel * time_step),
            hot=emitter.temperature,
            noise=(emitter.noise, emitter.noise_frequency, emitter.noise_speed * state.seconds),
            seed=emitter.seed,
        )
    if emitter.velocity_rate:
        for axis, target in enumerate(SWAP @ emitter.velocity):
            emission.drive(
                weight,
                state.velocity[axis],
                axis=axis,
                first=first,
                target=float(target),
                rate=emitter.velocity_rate * time_step,
            )


def find_outlet(emitter: Emitter, shape: tuple[int, int, int], device: wp.Device) -> Outlet | None:
    """Return the voxels that an emitter reaches, None if it is outside of the grid.

    Args:
        emitter: Its shape and soft edge matter.
        shape: Voxels of the grid (x, z, y).
        device: Where to compute.
    """
    placed = emitter.placed
    block = placed.block(shape, margin=1 + int(np.ceil(emitter.soft_edge / 2)))
    if block is None:
        return None
    first, size = block
    if emitter.soft_edge:
        distance = signed_distance([placed], size, device, first=first)
        return Outlet(first, emission.soften(distance, width=float(emitter.soft_edge)))
    corners = signed_distance([placed], tuple(n + 1 for n in size), device, first=tuple(n - 0.5 for n in first))
    weight = shares.voxel_share(corners, first=(0, 0, 0), out=wp.empty(size, dtype=float, device=device))
    emission.cover(weight)
    low, high = placed.bounds()
    if (low >= -0.5).all() and (high <= np.array(shape) - 0.5).all():
        # Linear pieces cut off what bulges; spread over all voxels it is not missed.
        total = weight.numpy().sum(dtype=np.float64)
        return Outlet(first, wp.array(weight.numpy() * np.float32(placed.shape.volume / total), device=device))
    return Outlet(first, weight)
