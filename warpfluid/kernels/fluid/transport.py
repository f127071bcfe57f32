"""Move what the fluid carries along paths (Stam 1999).

The path from each place back to where its fluid came from is known (``tracing``); the value there is interpolated
linearly, which makes no new extremes but blurs.
"""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.fluid.places import PLACES, check_places
from warpfluid.kernels.launch import launch
from warpfluid.kernels.sides import SIX

wp.set_module_options({"enable_backward": False})

CARRY = (
    PLACES
    + """
    const float *px = path.data + start, *pz = px + places, *py = pz + places;
    for (int l = 0; l < count; ++l) value[l] = read(field.data, px[l], pz[l], py[l]);
    for (int l = 0; l < count; ++l) to[l] = value[l];
"""
)

LIMIT = (
    PLACES
    + """
    const float *px = path.data + start, *pz = px + places, *py = pz + places;
    for (int l = 0; l < count; ++l) value[l] = limit(to[l], px[l], pz[l], py[l]);
    for (int l = 0; l < count; ++l) to[l] = value[l];
"""
)


@wp.func_native(snippet=CARRY)
def carry_run(
    field: wp.array3d[float],
    path: wp.array4d[float],
    sides: SIX,
    place: int,
    x: int,
    z: int,
    block: int,
    out: wp.array3d[float],
):
    """Read a run of heights where its paths end."""


@wp.func_native(snippet=LIMIT)
def limit_run(
    field: wp.array3d[float],
    path: wp.array4d[float],
    sides: SIX,
    place: int,
    x: int,
    z: int,
    block: int,
    out: wp.array3d[float],
):
    """Keep a run of heights within the values around the source."""


@wp.kernel
def carry_kernel(
    first_row: int,
    first_block: int,
    field: wp.array3d[float],
    path: wp.array4d[float],
    sides: SIX,
    place: int,
    out: wp.array3d[float],
):
    """Fetch each value from the end of its path."""
    i, z, j = wp.tid()
    carry_run(field, path, sides, place, first_row + i, z, first_block + j, out)


@wp.kernel
def limit_kernel(
    first_row: int,
    first_block: int,
    field: wp.array3d[float],
    path: wp.array4d[float],
    sides: SIX,
    place: int,
    out: wp.array3d[float],
):
    """Clamp to the eight values around the end of the path."""
    i, z, j = wp.tid()
    limit_run(field, path, sides, place, first_row + i, z, first_block + j, out)


def carry(
    field: wp.array3d[float],
    path: wp.array4d[float],
    sides: SIX,
    *,
    place: int,
    out: wp.array3d[float] | None = None,
) -> wp.array3d[float]:
    """Read a field where paths end (semi-Lagrangian advection, when the paths lead back).

    Args:
        field: Shape (x, z, y) of the places.
        path: Where each path ends, shape (3, x, z, y), in the field's index coordinates.
        sides: What the six sides are. Beyond closed ones the field is that of the border; beyond open ones too if it
            lives on faces, and 0 if it lives in the centres.
        place: 0, 1 or 2 for a field on the faces along x, z or y; ``tracing.CENTRE`` for one in the centres.
        out: Array to write, never ``field`` itself; a new one when omitted.

    Returns:
        The field at the ends, shape of ``field``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    checks.same_device(field=field)
    out = wp.empty_like(field) if out is None else out
    device = check_places(place, {"field": field, "out": out}, {"path": path})
    launch(carry_kernel, field.shape, [field, path, sides, place], [out], device, whole_columns=True)
    return out


def limit(
    field: wp.array3d[float],
    path: wp.array4d[float],
    sides: SIX,
    *,
    place: int,
    out: wp.array3d[float],
) -> wp.array3d[float]:
    """Keep what was carried within the eight values of the field around its source, in place.

    Args:
        field: What was, shape (x, z, y).
        path: Where each value came from, shape (3, x, z, y).
        sides: What the six sides are, as in ``carry``.
        place: Where the field lives, as in ``carry``.
        out: What was carried, shape of ``field``.

    Returns:
        ``out``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    device = check_places(place, {"field": field, "out": out}, {"path": path})
    launch(limit_kernel, field.shape, [field, path, sides, place], [out], device, whole_columns=True)
    return out
