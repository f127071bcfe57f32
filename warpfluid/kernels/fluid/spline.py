"""Carry a field along paths with a cubic B-spline, continued beyond the box as the sides say."""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.blur import convolve
from warpfluid.kernels.launch import CPU_RUN, CUDA_RUN, launch
from warpfluid.kernels.sampling import SPLINE_REACH, spline_taps, spline_weights
from warpfluid.kernels.sides import OPEN, SIX, WRAP

wp.set_module_options({"enable_backward": False})

MARGIN = SPLINE_REACH + 3  # the filter mirrors the border of what it is given; so far inside that is not felt


@wp.func
def period_of(size: int, sides: SIX, axis: int, place: int) -> int:
    """Return after how many places an axis repeats, 0 if it does not."""
    if sides[2 * axis] != WRAP:
        return 0
    return wp.where(axis == place, size - 1, size)


@wp.func
def continued(i: int, size: int, period: int) -> int:
    """Return the place inside whose value stands at a place beyond the border."""
    if period > 0:
        return (i % period + period) % period
    return wp.clamp(i, 0, size - 1)


@wp.func
def is_in_open_air(i: int, size: int, sides: SIX, axis: int) -> bool:
    """Tell whether a place lies beyond an open side."""
    return (i < 0 and sides[2 * axis] == OPEN) or (i >= size and sides[2 * axis + 1] == OPEN)


@wp.func
def within_margin(p: float, size: int, period: int) -> float:
    """Move a position into the box where it repeats, to two places from the box elsewhere."""
    if period > 0:
        return wp.clamp(p - float(period) * wp.floor(p / float(period)), 0.0, float(period))
    return wp.clamp(p, -2.0, float(size + 1))


@wp.kernel
def continue_kernel(
    first_row: int,
    first_block: int,
    field: wp.array3d[float],
    sides: SIX,
    place: int,
    margin: int,
    run: int,
    out: wp.array3d[float],
):
    """Write a field with a margin around it."""
    row, column, block = wp.tid()
    nx, nz, ny = field.shape[0], field.shape[1], field.shape[2]
    x = first_row + row - margin
    z = column - margin
    i = continued(x, nx, period_of(nx, sides, 0, place))
    j = continued(z, nz, period_of(nz, sides, 1, place))
    outside = is_in_open_air(x, nx, sides, 0) or is_in_open_air(z, nz, sides, 1)
    begin = (first_block + block) * run
    for height in range(begin, wp.min(begin + run, out.shape[2])):
        y = height - margin
        value = field[i, j, continued(y, ny, period_of(ny, sides, 2, place))]
        if place == 3 and (outside or is_in_open_air(y, ny, sides, 2)):
            value = float(0.0)
        out[first_row + row, column, height] = value


@wp.kernel
def carry_spline_kernel(
    first_row: int,
    first_block: int,
    spline: wp.array3d[float],
    path: wp.array4d[float],
    sides: SIX,
    place: int,
    margin: int,
    run: int,
    out: wp.array3d[float],
):
    """Fetch each value from the end of its path: 64 coefficients, weighed."""
    row, z, block = wp.tid()
    x = first_row + row
    nx, nz, ny = out.shape[0], out.shape[1], out.shape[2]
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, ny)):
        px = within_margin(path[0, x, z, y], nx, period_of(nx, sides, 0, place))
        pz = within_margin(path[1, x, z, y], nz, period_of(nz, sides, 1, place))
        py = within_margin(path[2, x, z, y], ny, period_of(ny, sides, 2, place))
        i, j, k = int(wp.floor(px)), int(wp.floor(pz)), int(wp.floor(py))
        wx = spline_weights(px - float(i))
        wz = spline_weights(pz - float(j))
        wy = spline_weights(py - float(k))
        total = float(0.0)
        for p in range(4):
            for q in range(4):
                for r in range(4):
                    weight = wx[p] * wz[q] * wy[r]
                    total += weight * spline[i + p - 1 + margin, j + q - 1 + margin, k + r - 1 + margin]
        out[x, z, y] = total


def carry_spline(
    field: wp.array3d[float],
    path: wp.array4d[float],
    sides: SIX,
    *,
    place: int,
    out: wp.array3d[float] | None = None,
) -> wp.array3d[float]:
    """Read the cubic B-spline through a field where paths end.

    The spline may overshoot the values it goes through: ``transport.limit`` keeps it within them.

    Args:
        field: Shape (x, z, y) of the places.
        path: Where each path ends, shape (3, x, z, y), in the field's index coordinates.
        sides: What the six sides are, as in ``transport.carry``.
        place: Where the field lives, as in ``transport.carry``.
        out: Array to write; it may be ``field``; a new one when omitted.

    Returns:
        The field at the ends, shape of ``field``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    checks.same_device(field=field)
    out = wp.empty_like(field) if out is None else out
    device = checks.same_device(field=field, path=path, out=out)
    checks.floats(3, field=field, out=out)
    checks.floats(4, path=path)
    checks.same_shape(field=field, out=out)
    checks.shape((3, *field.shape), path=path)
    run = CUDA_RUN if device.is_cuda else CPU_RUN
    padded = wp.empty(tuple(n + 2 * MARGIN for n in field.shape), dtype=float, device=device)
    launch(continue_kernel, padded.shape, [field, sides, place, MARGIN, run], [padded], device, whole_columns=True)
    spline = convolve(padded, (spline_taps(str(device)),) * 3, out=padded)
    launch(
        carry_spline_kernel, field.shape, [spline, path, sides, place, MARGIN, run], [out], device, whole_columns=True
    )
    return out
