"""All that pushes a fluid during a step."""

from typing import NamedTuple

import numpy as np
import warp as wp

from warpfluid.kernels.blur import blur
from warpfluid.kernels.fluid import decay
from warpfluid.kernels.forces.air import add_buoyancy, add_wind
from warpfluid.kernels.forces.pushes import add_push
from warpfluid.kernels.forces.reach import make_reach
from warpfluid.kernels.forces.swirl import add_swirl
from warpfluid.kernels.forces.turbulence import add_turbulence
from warpfluid.kernels.sides import CLOSED, SIX
from warpfluid.options import ForceOptions
from warpfluid.options.keys import Keyed
from warpfluid.options.scene import EVERYWHERE
from warpfluid.simulation.fields import mark_fluid, number_or_field
from warpfluid.simulation.liquid import liquid_mass, share_of_gravity
from warpfluid.simulation.physics import Physics
from warpfluid.simulation.placed import SWAP
from warpfluid.simulation.placing import UNITS, Placing
from warpfluid.simulation.state import FluidState

STANDARD_GRAVITY = 9.8
SWIRL_UNITS = 0.1  # strength 1 turns an eddy faster by this many units a second
USUAL_CENTER = "0,3,0"
USUAL_REACH = 2.0  # of a force that has a centre
MASK_SOFTNESS = 1 / 12  # blur of the turbulence's mask in waves; a hard rim would be pushed along itself


class Force(NamedTuple):
    """A field of force in voxels and seconds; vectors are (x, z, y)."""

    kind: str
    strength: float
    centre: tuple[float, ...]
    radius: float
    direction: tuple[float, ...]


def place_force(options: ForceOptions, placing: Placing, frame: float) -> Force:
    """Return a field of force as it is at a frame."""
    rate = options.kind in ("wind", "drag")
    strength = Keyed(options.strength).at(frame) * (1 if rate else placing.unit)
    vector = placing.vector if options.kind == "wind" else lambda text, at: Keyed(text, 3).at(at)
    centre = SWAP @ placing.point(options.center or USUAL_CENTER, frame)
    direction = SWAP @ vector(options.direction, frame)
    usual = 0.0 if options.kind in EVERYWHERE else USUAL_REACH
    reach = usual if options.radius is None else Keyed(options.radius).at(frame)
    return Force(options.kind, strength, tuple(centre), reach * placing.unit, tuple(direction))


def add_forces(physics: Physics, state: FluidState, frame: float, seconds: float, forces: tuple[Force, ...]) -> None:
    """Accelerate a fluid for a time step, in place."""
    _buoyancy(physics, state, frame, seconds)
    _turbulence(physics, state, frame, seconds)
    step = {"sides": physics.sides, "time_step": seconds}
    _swirl(physics, state, frame, step)
    wind = SWAP @ physics.placing.vector(physics.options.wind, frame)
    blowing = [Force("wind", physics.number("wind_drag", frame), (), 0.0, tuple(wind))] if np.any(wind) else []
    for force in (*blowing, *forces):
        if force.kind in ("wind", "drag"):
            mask = _reach(state, force, physics.sides) if force.radius else _blown(physics, state, force)
            # What rises goes on rising in a wind from the side: components that it has not are left alone.
            wind = tuple(part or None for part in force.direction) if force.kind == "wind" else (0.0, 0.0, 0.0)
            add_wind(*state.velocity, wind=wind, rate=force.strength, mask=mask, **step)
        else:
            add_push(*state.velocity, **force._asdict(), **step)


def _blown(physics: Physics, state: FluidState, force: Force) -> wp.array | None:
    """Return where a wind blows: everywhere, for it is the air that moves. Drag acts on the fluid alone.

    So does a wind between two walls, where air cannot blow through the box.
    """
    sides = physics.sides
    walled = any(part and sides[2 * axis] == sides[2 * axis + 1] == CLOSED for axis, part in enumerate(force.direction))
    if force.kind == "wind" and not walled:
        return None
    return decay.make_mask(state.density, reference=physics.placing.reference)


def _reach(state: FluidState, force: Force, sides: SIX) -> wp.array:
    return make_reach(wp.empty_like(state.density), centre=force.centre, radius=force.radius, sides=sides)


def _swirl(physics: Physics, state: FluidState, frame: float, step: dict) -> None:
    """Make curls stronger.

    Only where there is fluid: around a jet the clear air shears, and made stronger its curl winds up into a ring that
    sucks smoke out of the jet's foot. An artist's ramp says itself where.
    """
    swirl = number_or_field(physics.options.swirl, frame, state, physics.placing)
    unit = SWIRL_UNITS * physics.placing.unit
    if isinstance(swirl, wp.array):
        add_swirl(*state.velocity, strength=unit, mask=swirl, **step)
    elif swirl:
        add_swirl(*state.velocity, strength=swirl * unit, mask=mark_fluid(state, physics.placing.reference), **step)


def _buoyancy(physics: Physics, state: FluidState, frame: float, seconds: float) -> None:
    """Lift what is hot or light, against gravity; a liquid falls instead."""
    gravity = SWAP @ Keyed(physics.options.gravity, 3).at(frame)
    lift = {name: physics.number(name, frame) for name in ("temperature_buoyancy", "density_buoyancy")}
    step = {"sides": physics.sides, "time_step": seconds, "reference": physics.placing.reference}
    fields = {"temperature": state.temperature, "density": state.density}
    if any(lift.values()):
        up = tuple(-gravity / STANDARD_GRAVITY * physics.placing.unit)
        add_buoyancy(*state.velocity, **fields, up=up, **lift, **step)
    mass = liquid_mass(physics, state, frame)
    if mass:
        fields["density"], step["reference"] = share_of_gravity(mass), 1.0
        fall = {"temperature_buoyancy": 0.0, "density_buoyancy": -1.0}
        add_buoyancy(*state.velocity, **fields, up=tuple(-gravity * physics.placing.unit), **fall, **step)


def _turbulence(physics: Physics, state: FluidState, frame: float, seconds: float) -> None:
    """Stir with noise that moves in time."""
    options, unit = physics.options, physics.placing.unit
    state.phase += physics.number("turbulence_speed", frame) * seconds
    strength = physics.number("turbulence_strength", frame) * UNITS * unit
    if not strength:
        return
    frequency = physics.number("turbulence_frequency", frame) / unit
    add_turbulence(
        *state.velocity,
        strength=strength,
        frequency=frequency,
        phase=state.phase,
        octaves=options.turbulence_octaves,
        seed=options.turbulence_seed,
        sides=physics.sides,
        time_step=seconds,
        mask=_mask(physics, state, MASK_SOFTNESS / frequency),
    )


def _mask(physics: Physics, state: FluidState, softness: float) -> wp.array | None:
    """Return where turbulence acts, 0 to 1, with a soft rim."""
    kind = physics.options.turbulence_mask
    if kind == "none":
        return None
    field, full = (state.density, physics.placing.reference) if kind == "density" else (state.temperature, 1.0)
    mask = decay.make_mask(field, reference=full)
    return blur(mask, softness, out=mask)
