"""One step of a Navier-Stokes solver, in Maya's place.

Carry everything along the velocity (MacCormack, Selle et al. 2008), draw liquids together, let in what emitters emit,
burn, cool and vanish, apply forces, and make the velocity divergence-free again (Stam 1999; on a MAC grid as Harlow and
Welch 1965).
"""

import math
from dataclasses import dataclass

import numpy as np
import warp as wp

from warpfluid.kernels import vectors
from warpfluid.kernels.fluid import combustion, decay
from warpfluid.kernels.fluid.totals import total
from warpfluid.kernels.sides import OPEN
from warpfluid.simulation.emitters import Emitter, emit
from warpfluid.simulation.forces import Force, add_forces
from warpfluid.simulation.guidance import Motion
from warpfluid.simulation.liquid import draw_together, liquid_mass
from warpfluid.simulation.physics import Physics
from warpfluid.simulation.pressure import hold, make_incompressible
from warpfluid.simulation.solids import clear, enforce
from warpfluid.simulation.state import Faces, FluidState, Solids
from warpfluid.simulation.transport import advect_scalars, advect_velocity, diffuse, keep_total

BOXES_A_FRAME = 2  # how far fluid may move; with more solver steps than usual, as much farther
USUAL_STEPS = 8  # a frame, at most


@dataclass(frozen=True, kw_only=True)
class Surroundings:
    """What acts on the fluid during a frame.

    Attributes:
        emitters: What is let in.
        forces: Fields of force.
        solids: What stands in the way.
        motion: What the footage asks of the velocity.
        follows: Whether the density follows volumes, which say themselves how sharp a liquid is.
    """

    emitters: tuple[Emitter, ...] = ()
    forces: tuple[Force, ...] = ()
    solids: Solids | None = None
    motion: Motion | None = None
    follows: bool = False


class Solver:
    """The steps of a simulation.

    Args:
        physics: Its numbers.
    """

    def __init__(self, physics: Physics):
        self.physics, self.number = physics, physics.number
        self.options, self.placing, self.sides = physics.options, physics.placing, physics.sides

    def step(self, state: FluidState, frame: float, seconds: float, around: Surroundings) -> int:
        """Simulate a frame, in place.

        Args:
            state: The fluid.
            frame: Where keyed numbers are looked up.
            seconds: How long it lasts.
            around: What acts on the fluid.

        Returns:
            How many solver steps were made.

        Raises:
            FloatingPointError: If the fluid became faster than can be simulated.
        """
        if seconds <= 0:
            return 0
        count = self._substeps(state, seconds, around)
        for _ in range(count):
            self._substep(state, frame, seconds / count, around)
        return count

    def _substeps(self, state: FluidState, seconds: float, around: Surroundings) -> int:
        speed = fastest(state.velocity)
        if around.motion:
            speed = max(speed, fastest(around.motion.target))
        for emitter in around.emitters:
            speed = max(speed, float(np.abs(emitter.velocity).max()) * (emitter.velocity_rate > 0))
        most = self.options.substeps or self.options.max_substeps
        if not speed * seconds <= max(self.placing.shape) * BOXES_A_FRAME * max(most / USUAL_STEPS, 1):
            raise FloatingPointError(f"the fluid moves {speed * seconds:.3g} voxels a frame")
        needed = max(math.ceil(speed * seconds / self.options.cfl - 1e-6), 1)
        return self.options.substeps or min(needed, self.options.max_substeps)

    def _substep(self, state: FluidState, frame: float, seconds: float, around: Surroundings) -> None:
        solids = around.solids
        for emitter in around.emitters:
            emit(state, emitter, seconds)
        if around.motion:
            state.velocity = around.motion.guided(state.velocity, solids)
        else:
            hold(state.velocity, self.sides, solids)
        self._carry(state, frame, seconds)
        if not around.follows:
            draw_together(self.physics, state, solids, frame)
        expansion = self._change(state, frame, seconds)
        add_forces(self.physics, state, frame, seconds, around.forces)
        if solids:
            for field in (state.density, state.temperature, state.fuel, state.flame):
                clear(field, solids)
            enforce(state.velocity, solids)
        make_incompressible(
            state.velocity,
            self.sides,
            expansion=expansion,
            solids=solids,
            mass=liquid_mass(self.physics, state, frame),
            method=self.options.pressure,
        )
        state.seconds += seconds

    def _carry(self, state: FluidState, frame: float, seconds: float) -> None:
        """Move everything along the velocity, and the velocity along itself."""
        names = ["density", "temperature", *(("fuel", "flame") if self.options.combustion else ())]
        names = [name for name in names if vectors.largest(getattr(state, name))]  # what is 0 everywhere stays so
        fields = [getattr(state, name) for name in names]
        before = total(state.density) if OPEN not in tuple(self.sides) else None
        moved = advect_scalars(fields, state.velocity, self.sides, seconds, scheme=self.options.advection)
        for name, field in zip(names, moved, strict=True):
            setattr(state, name, field)
        if before is not None:
            keep_total(state.density, before)
        scheme = self.options.velocity_advection
        state.velocity = advect_velocity(state.velocity, state.velocity, self.sides, seconds, scheme=scheme)
        for field, name in ((state.density, "density_diffusion"), (state.temperature, "temperature_diffusion")):
            diffuse(field, self.number(name, frame) * seconds, self.sides, out=field)
        diffuse(state.velocity, self.number("viscosity", frame) * seconds, self.sides, out=state.velocity)

    def _change(self, state: FluidState, frame: float, seconds: float) -> wp.array | None:
        """Burn, cool and vanish; return the divergence that burning makes [1/s]."""
        expansion = None
        if self.options.combustion:
            full = self.placing.reference
            expansion = combustion.burn_fuel(
                state.fuel,
                state.temperature,
                state.density,
                state.flame,
                burn_rate=self.number("burn_rate", frame),
                ignition=self.number("ignition", frame),
                hottest=self.number("max_temperature", frame),
                heat=self.number("heat", frame) / full,
                smoke=self.number("smoke", frame),
                expansion=self.number("expansion", frame) / full,
                flame_decay=self.number("flame_fade", frame),
                time_step=seconds,
            )
            # A closed box has no room to grow into; there the total is kept as it is carried.
            if self.number("expansion", frame) and OPEN in tuple(self.sides):
                for field in (state.density, state.fuel, state.flame):
                    decay.thin(field, divergence=expansion, time_step=seconds)
            hottest = self.number("max_temperature", frame)
            decay.radiate(state.temperature, rate=self.number("cooling", frame), hottest=hottest, time_step=seconds)
        decay.decay(state.temperature, rate=self.number("temperature_dissipation", frame), time_step=seconds)
        if self.options.density_dissipation != "auto":
            decay.decay(state.density, rate=self.number("density_dissipation", frame), time_step=seconds)
        for part in state.velocity:
            decay.decay(part, rate=self.number("velocity_damp", frame), time_step=seconds)
        return expansion


def fastest(velocity: Faces) -> float:
    """Return the greatest component of a velocity, in size; NaN if it is not finite."""
    return max(vectors.largest(part) for part in velocity)
