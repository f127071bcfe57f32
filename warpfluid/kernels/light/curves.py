"""Read a curve: equally spaced values over a field from 0 to a top, straight in between, its ends beyond."""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import CPU_RUN, CUDA_RUN, launch

wp.set_module_options({"enable_backward": False})


@wp.func
def place_on_curve(value: float, last: int, top: float) -> float:
    """Return where a value lies between entry 0 and the last one."""
    return wp.clamp(value / top, 0.0, 1.0) * float(last)


@wp.func
def rise_from_side(at: int, count: int, width: float) -> float:
    """Return how much there is at a voxel, where things rise smoothly from the sides of the box."""
    inside = wp.min(float(at) + 0.5, float(count) - 0.5 - float(at))
    part = wp.clamp(inside / width, 0.0, 1.0)
    return part * part * (3.0 - 2.0 * part)


@wp.kernel
def look_up_kernel(
    first_row: int,
    first_block: int,
    field: wp.array3d[float],
    values: wp.array[float],
    top: float,
    times: wp.array3d[float],
    multiplied: bool,
    edge_fade: float,
    run: int,
    out: wp.array3d[float],
):
    """Read the curve at each voxel."""
    i, z, j = wp.tid()
    x = first_row + i
    begin = (first_block + j) * run
    last = values.shape[0] - 1
    for y in range(begin, wp.min(begin + run, field.shape[2])):
        at = place_on_curve(field[x, z, y], last, top)
        below = int(at)
        entry = wp.lerp(values[below], values[wp.min(below + 1, last)], at - float(below))
        if multiplied:
            entry *= wp.max(times[x, z, y], 0.0)
        if edge_fade > 0.0:
            entry *= rise_from_side(x, field.shape[0], edge_fade) * rise_from_side(z, field.shape[1], edge_fade)
            entry *= rise_from_side(y, field.shape[2], edge_fade)
        out[x, z, y] = entry


def look_up(
    field: wp.array3d[float],
    values: wp.array[float],
    *,
    top: float,
    times: wp.array3d[float] | None = None,
    edge_fade: float = 0.0,
    out: wp.array3d[float] | None = None,
) -> wp.array3d[float]:
    """Read a curve at each voxel of a field.

    Args:
        field: Shape (x, z, y).
        values: The curve, equally spaced from field value 0 on, shape (n,).
        top: Field value of the last entry.
        times: What the curve's values are multiplied by, where above 0, shape of ``field``.
        edge_fade: Over how many voxels the result rises from the box's sides; 0 for not at all.
        out: Array to write; it may be ``field``.

    Returns:
        The curve's values, shape of ``field``.

    Raises:
        ValueError: If shapes, types or devices do not fit, or ``top`` is not above 0.
    """
    out = wp.empty_like(field) if out is None else out
    factor = field if times is None else times
    device = checks.same_device(field=field, values=values, times=factor, out=out)
    checks.floats(3, field=field, times=factor, out=out)
    checks.floats(1, values=values)
    checks.same_shape(field=field, times=factor, out=out)
    if not (top > 0 and values.size):
        raise ValueError(f"a curve has {values.size} values up to {top}, expected one at least, and a top above 0")
    run = CUDA_RUN if device.is_cuda else CPU_RUN
    inputs = [field, values, top, factor, times is not None, edge_fade, run]
    launch(look_up_kernel, field.shape, inputs, [out], device)
    return out
