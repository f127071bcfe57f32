"""Fields of a fluid in the units that an artist knows them in, and numbers that depend on them."""

import warp as wp

from warpfluid.kernels import vectors
from warpfluid.kernels.fluid import decay
from warpfluid.kernels.fluid.centres import measure_speed
from warpfluid.kernels.forces.ramp import look_up
from warpfluid.options.keys import Keyed, Ramp, is_ramp
from warpfluid.simulation.placing import Placing
from warpfluid.simulation.state import FluidState


def number_or_field(value: float | str, frame: float, state: FluidState, placing: Placing) -> float | wp.array:
    """Return an option as it is at a frame: a number, or one a voxel where it depends on a field.

    Args:
        value: A number, keys, or a ramp (``keys.py``).
        frame: Where keys are looked up.
        state: The fluid.
        placing: What full density and a unit of length are.

    Returns:
        The number; or shape (x, z, y).
    """
    if not is_ramp(value):
        return Keyed(value).at(frame)
    ramp = Ramp(value)
    field, full = {
        "density": lambda: (state.density, placing.reference),
        "temperature": lambda: (state.temperature, 1.0),
        "speed": lambda: (measure_speed(*state.velocity), placing.unit),
    }[ramp.field]()
    return look_up(field, inputs=ramp.inputs, values=ramp.values, scale=1 / full)


def mark_fluid(state: FluidState, reference: float) -> wp.array:
    """Return where there is fluid to be seen or felt, from 0 in the air to 1: smoke, fuel or heat.

    Args:
        state: The fluid.
        reference: Full density.

    Returns:
        The mask, shape (x, z, y).
    """
    there = wp.empty_like(state.density)
    vectors.add_scaled(state.density, 1.0, state.fuel, out=there)
    vectors.add_scaled(there, reference, vectors.clip(wp.clone(state.temperature)), out=there)
    return decay.make_mask(there, reference=reference, out=there)
