"""What vanishes by itself: velocity is damped, smoke dissolves, hot gas cools. All laws are solved exactly in time."""

import math

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.fluid.faces import launch_run

wp.set_module_options({"enable_backward": False})


@wp.kernel
def scale_kernel(first_row: int, first_block: int, factor: float, run: int, field: wp.array3d[float]):
    """Multiply by a number."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, field.shape[2])):
        field[x, z, y] = factor * field[x, z, y]


@wp.kernel
def radiate_kernel(
    first_row: int, first_block: int, exponent: float, hottest: float, run: int, field: wp.array3d[float]
):
    """Lose heat as a black body does; what is not above the surroundings keeps its temperature."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, field.shape[2])):
        now = field[x, z, y]
        if now > 0.0:
            share = now / hottest
            field[x, z, y] = now * wp.pow(1.0 + exponent * share * share * share, -1.0 / 3.0)


@wp.kernel
def thin_kernel(
    first_row: int,
    first_block: int,
    divergence: wp.array3d[float],
    time_step: float,
    run: int,
    field: wp.array3d[float],
):
    """Spread what a voxel holds over the room that it grows to."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, field.shape[2])):
        field[x, z, y] = field[x, z, y] * wp.exp(-divergence[x, z, y] * time_step)


@wp.kernel
def make_mask_kernel(
    first_row: int, first_block: int, density: wp.array3d[float], scale: float, run: int, out: wp.array3d[float]
):
    """Scale and keep within 0 and 1."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, out.shape[2])):
        out[x, z, y] = wp.clamp(scale * density[x, z, y], 0.0, 1.0)


def decay(field: wp.array3d[float], *, rate: float, time_step: float) -> wp.array3d[float]:
    """Let a field vanish at a rate, in place: field exp(-rate time_step).

    Args:
        field: Density, temperature, fuel or one component of a velocity, any shape (x, z, y).
        rate: [1/s]; 0 keeps the same bits.
        time_step: [s].

    Returns:
        The field.

    Raises:
        ValueError: If the field is no contiguous 3-D float array or ``rate`` is below 0.
    """
    checks.same_device(field=field)
    checks.floats(3, field=field)
    _check_rate(rate)
    if rate * time_step != 0:
        launch_run(scale_kernel, [math.exp(-rate * time_step)], field)
    return field


def radiate(temperature: wp.array3d[float], *, rate: float, hottest: float, time_step: float) -> wp.array3d[float]:
    """Cool as a black body does (Nguyen, Fedkiw and Jensen 2002, Eq. 17), in place.

    Solves ``dT/dt = -rate hottest (T / hottest)^4`` exactly: ``T (1 + 3 rate time_step (T / hottest)^3)^(-1/3)``.

    Args:
        temperature: The surroundings are 0, shape (x, z, y).
        rate: Share of its temperature that the hottest gas loses at first [1/s]; 0 keeps the same bits.
        hottest: The temperature that ``rate`` is said for.
        time_step: [s].

    Returns:
        The temperature.

    Raises:
        ValueError: If the field is no contiguous 3-D float array, ``rate`` is below 0 or ``hottest`` not above 0.
    """
    checks.same_device(temperature=temperature)
    checks.floats(3, temperature=temperature)
    _check_rate(rate)
    if not hottest > 0:
        raise ValueError(f"hottest is {hottest}, expected a temperature above 0")
    if rate * time_step != 0:
        launch_run(radiate_kernel, [3.0 * rate * time_step, hottest], temperature)
    return temperature


def thin(field: wp.array3d[float], *, divergence: wp.array3d[float], time_step: float) -> wp.array3d[float]:
    """Thin what a swelling gas holds, in place: field exp(-divergence time_step).

    Advection keeps values, so a flow out of a source would make more of everything; with this, the part
    ``-field divergence`` of the law of conservation, totals stay.

    Args:
        field: Density or fuel, shape (x, z, y).
        divergence: Of the velocity that will carry the field [1/s], the same shape.
        time_step: [s].

    Returns:
        The field.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    checks.same_device(field=field, divergence=divergence)
    checks.floats(3, field=field, divergence=divergence)
    checks.same_shape(field=field, divergence=divergence)
    launch_run(thin_kernel, [divergence, time_step], field)
    return field


def make_mask(
    density: wp.array3d[float], *, reference: float, out: wp.array3d[float] | None = None
) -> wp.array3d[float]:
    """Return how much smoke there is as a mask from 0 to 1: density / reference, at most 1.

    Args:
        density: Shape (x, z, y).
        reference: The density that counts as 1.
        out: Mask to write; a new one when omitted.

    Returns:
        The mask, shape of ``density``.

    Raises:
        ValueError: If shapes, types or devices do not fit or ``reference`` is not above 0.
    """
    checks.same_device(density=density)
    out = wp.empty_like(density) if out is None else out
    checks.same_device(density=density, out=out)
    checks.floats(3, density=density, out=out)
    checks.same_shape(density=density, out=out)
    if not reference > 0:
        raise ValueError(f"reference is {reference}, expected a density above 0")
    launch_run(make_mask_kernel, [density, 1.0 / reference], out)
    return out


def _check_rate(rate: float) -> None:
    if rate < 0 or not math.isfinite(rate):
        raise ValueError(f"rate is {rate}, expected a number >= 0, in 1/s")
