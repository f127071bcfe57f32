"""Make good most of what carrying with linear interpolation blurs.

Carrying the result forth again shows the error twice, so half the difference is taken off it: afterwards (MacCormack,
Selle et al. 2008) or beforehand (BFECC, Kim et al. 2005), never beyond the eight values around the source.
"""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.fluid.places import PLACES, check_places
from warpfluid.kernels.launch import launch
from warpfluid.kernels.sides import SIX

wp.set_module_options({"enable_backward": False})

CORRECT = (
    PLACES
    + """
    const float *px = back.data + start, *pz = px + places, *py = pz + places;
    const float *qx = forth.data + start, *qz = qx + places, *qy = qz + places;
    const float *was = field.data + start, *now = carried.data + start;
    for (int l = 0; l < count; ++l) value[l] = now[l] + 0.5f * (was[l] - read(carried.data, qx[l], qz[l], qy[l]));
    for (int l = 0; l < count; ++l) value[l] = limit(value[l], px[l], pz[l], py[l]);
    for (int l = 0; l < count; ++l)
        to[l] = leaves(px[l], pz[l], py[l]) | leaves(qx[l], qz[l], qy[l]) ? now[l] : value[l];
"""
)

MEND = (
    PLACES
    + """
    const float *px = path.data + start, *pz = px + places, *py = pz + places;
    const float* was = field.data + start;
    for (int l = 0; l < count; ++l) {
        const float error = was[l] - read(carried.data, px[l], pz[l], py[l]);
        value[l] = was[l] + (leaves(px[l], pz[l], py[l]) ? 0.0f : 0.5f * error);
    }
    for (int l = 0; l < count; ++l) to[l] = value[l];
"""
)


@wp.func_native(snippet=CORRECT)
def correct_run(
    field: wp.array3d[float],
    carried: wp.array3d[float],
    back: wp.array4d[float],
    forth: wp.array4d[float],
    sides: SIX,
    place: int,
    x: int,
    z: int,
    block: int,
    out: wp.array3d[float],
):
    """Take the error off a run of heights."""


@wp.func_native(snippet=MEND)
def mend_run(
    field: wp.array3d[float],
    carried: wp.array3d[float],
    path: wp.array4d[float],
    sides: SIX,
    place: int,
    x: int,
    z: int,
    block: int,
    out: wp.array3d[float],
):
    """Add to a run of heights what it would lose."""


@wp.kernel
def correct_kernel(
    first_row: int,
    first_block: int,
    field: wp.array3d[float],
    carried: wp.array3d[float],
    back: wp.array4d[float],
    forth: wp.array4d[float],
    sides: SIX,
    place: int,
    out: wp.array3d[float],
):
    """Add half of what going there and back has lost."""
    i, z, j = wp.tid()
    correct_run(field, carried, back, forth, sides, place, first_row + i, z, first_block + j, out)


@wp.kernel
def mend_kernel(
    first_row: int,
    first_block: int,
    field: wp.array3d[float],
    carried: wp.array3d[float],
    path: wp.array4d[float],
    sides: SIX,
    place: int,
    out: wp.array3d[float],
):
    """Add half of what going there and back would lose, before going."""
    i, z, j = wp.tid()
    mend_run(field, carried, path, sides, place, first_row + i, z, first_block + j, out)


def correct(
    field: wp.array3d[float],
    carried: wp.array3d[float],
    back: wp.array4d[float],
    forth: wp.array4d[float],
    sides: SIX,
    *,
    place: int,
    out: wp.array3d[float] | None = None,
) -> wp.array3d[float]:
    """Take off half the error of going back and forth (MacCormack, Selle et al. 2008).

    Kept within the eight values of the field around the source; where a path leaves the box nothing is corrected.

    Args:
        field: What was, shape (x, z, y).
        carried: The field carried along ``back``, of the same shape.
        back: Where each value came from, shape (3, x, z, y).
        forth: Where each value goes to, of the same shape.
        sides: What the six sides are, as in ``transport.carry``.
        place: Where the field lives, as in ``transport.carry``.
        out: Array to write, none of the others; a new one when omitted.

    Returns:
        The corrected field, shape of ``field``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    checks.same_device(field=field)
    out = wp.empty_like(field) if out is None else out
    device = check_places(place, {"field": field, "carried": carried, "out": out}, {"back": back, "forth": forth})
    launch(correct_kernel, field.shape, [field, carried, back, forth, sides, place], [out], device, whole_columns=True)
    return out


def mend(
    field: wp.array3d[float],
    carried: wp.array3d[float],
    path: wp.array4d[float],
    sides: SIX,
    *,
    place: int,
    out: wp.array3d[float] | None = None,
) -> wp.array3d[float]:
    """Add half the error of going back and forth to what is carried (BFECC, Kim et al. 2005).

    Args:
        field: What was, shape (x, z, y).
        carried: The field carried back, of the same shape.
        path: Where each value goes to, shape (3, x, z, y).
        sides: What the six sides are, as in ``transport.carry``.
        place: Where the field lives, as in ``transport.carry``.
        out: Array to write, none of the others; a new one when omitted.

    Returns:
        The field to carry in place of ``field``, of its shape.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    checks.same_device(field=field)
    out = wp.empty_like(field) if out is None else out
    device = check_places(place, {"field": field, "carried": carried, "out": out}, {"path": path})
    launch(mend_kernel, field.shape, [field, carried, path, sides, place], [out], device, whole_columns=True)
    return out
