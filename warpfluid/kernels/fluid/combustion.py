"""Fuel burns where it is hot: it heats, leaves smoke and makes the gas expand (Nguyen, Fedkiw and Jensen 2002)."""

import math

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import CPU_RUN, CUDA_RUN, launch

wp.set_module_options({"enable_backward": False})


@wp.struct
class Reaction:
    """How fuel burns in one time step; ``burn_fuel`` says what the numbers are."""

    exponent: float  # of the exponential by which fuel becomes less, at the hottest
    ignition: float
    hottest: float
    heat: float
    smoke: float
    expansion: float  # a unit of burnt fuel, over the time step
    keep: float  # share of the flame that is left after a time step


@wp.kernel
def burn_kernel(
    first_row: int,
    first_block: int,
    reaction: Reaction,
    run: int,
    fuel: wp.array3d[float],
    temperature: wp.array3d[float],
    density: wp.array3d[float],
    flame: wp.array3d[float],
    expansion: wp.array3d[float],
):
    """Turn fuel into heat, smoke and room."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, fuel.shape[2])):
        hot = temperature[x, z, y]
        before = fuel[x, z, y]
        burnt = float(0.0)
        if before > 0.0 and hot > reaction.ignition:
            pace = wp.min((hot - reaction.ignition) / (reaction.hottest - reaction.ignition), 1.0)
            burnt = before * (1.0 - wp.exp(-reaction.exponent * pace))
            fuel[x, z, y] = before - burnt
            temperature[x, z, y] = wp.max(hot, wp.min(hot + reaction.heat * burnt, reaction.hottest))
            density[x, z, y] = density[x, z, y] + reaction.smoke * burnt
        flame[x, z, y] = reaction.keep * flame[x, z, y] + burnt
        expansion[x, z, y] = reaction.expansion * burnt


def burn_fuel(
    fuel: wp.array3d[float],
    temperature: wp.array3d[float],
    density: wp.array3d[float],
    flame: wp.array3d[float],
    *,
    burn_rate: float,
    ignition: float,
    hottest: float,
    heat: float,
    smoke: float,
    expansion: float,
    flame_decay: float,
    time_step: float,
    out: wp.array3d[float] | None = None,
) -> wp.array3d[float]:
    """Burn fuel for one time step, in place.

    Fuel hotter than ``ignition`` burns at ``dF/dt = -burn_rate p F``, where p grows from 0 at ``ignition`` to 1 at
    ``hottest``. With the temperature from before the step this is solved exactly, so

        burnt       = F (1 - exp(-burn_rate p time_step))
        fuel        = F - burnt
        temperature = T + heat burnt, at most ``hottest``; what was hotter already stays
        density     = density + smoke burnt
        flame       = flame exp(-flame_decay time_step) + burnt
        expansion   = expansion burnt / time_step

    Args:
        fuel: In the unit of density, shape (x, z, y).
        temperature: The surroundings are 0, the same shape.
        density: Smoke, the same shape.
        flame: Fuel that burnt lately, to be shown as light, the same shape.
        burn_rate: Of the hottest fuel [1/s]; at 0 nothing burns.
        ignition: Temperature above which fuel burns.
        hottest: Temperature that burning heats to at most.
        heat: Rise of temperature a unit of burnt fuel.
        smoke: Density a unit of burnt fuel; 1 keeps fuel + density.
        expansion: Volume that a voxel gains a unit of burnt fuel, in parts of the voxel.
        flame_decay: How fast a flame is forgotten [1/s].
        time_step: [s].
        out: Expansion to write; a new array when omitted.

    Returns:
        The divergence that expansion makes [1/s], shape of ``fuel``.

    Raises:
        ValueError: If shapes, types or devices do not fit, a rate is below 0 or ``hottest`` not above ``ignition``.
    """
    checks.same_device(fuel=fuel)
    out = wp.empty_like(fuel) if out is None else out
    arrays = {"fuel": fuel, "temperature": temperature, "density": density, "flame": flame, "out": out}
    device = checks.same_device(**arrays)
    checks.floats(3, **arrays)
    checks.same_shape(**arrays)
    _check_numbers(burn_rate, flame_decay, time_step, ignition, hottest)
    reaction = Reaction()
    reaction.exponent = burn_rate * time_step
    reaction.ignition = ignition
    reaction.hottest = hottest
    reaction.heat = heat
    reaction.smoke = smoke
    reaction.expansion = expansion / time_step
    reaction.keep = math.exp(-flame_decay * time_step)
    run = CUDA_RUN if device.is_cuda else CPU_RUN
    launch(burn_kernel, fuel.shape, [reaction, run], list(arrays.values()), device)
    return out


def _check_numbers(burn_rate: float, flame_decay: float, time_step: float, ignition: float, hottest: float) -> None:
    if not (burn_rate >= 0 and flame_decay >= 0 and time_step > 0):
        found = f"burn_rate is {burn_rate}, flame_decay {flame_decay}, time_step {time_step}"
        raise ValueError(f"{found}, expected rates >= 0 in 1/s and a time above 0")
    if not hottest > ignition:
        raise ValueError(f"hottest is {hottest}, expected a temperature above ignition, {ignition}")
