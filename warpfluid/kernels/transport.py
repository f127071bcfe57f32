"""Move what the fluid carries along paths (Stam 1999), and make good most of what interpolation blurs.

The path from each place back to where its fluid came from is known (``tracing``); the value there is interpolated
linearly. Carrying the result forth again shows the error twice, so half the difference is taken off it: afterwards
(MacCormack, Selle et al. 2008) or beforehand (BFECC, Kim et al. 2005), never beyond the eight values around the source.
"""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import RUN_OF_HEIGHTS, launch
from warpfluid.kernels.sampling import LINEAR
from warpfluid.kernels.sides import SIX

wp.set_module_options({"enable_backward": False})

# Scalars (place 3, the centres) fade to 0 beyond an open side; components of a velocity stay as at the border.
PLACES = (
    """
    const int heights = out.shape[2];"""
    + RUN_OF_HEIGHTS
    + LINEAR
    + """
    const int size[3] = {out.shape[0], out.shape[1], heights};
    const size_t places = (size_t)size[0] * size[1] * heights;
    const size_t start = ((size_t)x * size[1] + z) * heights + y;
    const int period[3] = {sides[0] == 2 ? size[0] - (place == 0) : 0,
                           sides[2] == 2 ? size[1] - (place == 1) : 0,
                           sides[4] == 2 ? heights - (place == 2) : 0};
    float fades[6];
    for (int side = 0; side < 6; ++side) fades[side] = place == 3 && sides[side] == 0 ? 1.0f : 0.0f;
    const auto left_over = [&](float p, int axis) {
        const float last = (float)(size[axis] - 1);
        const float outside = p < 0.0f ? -p * fades[2 * axis] : (p > last ? (p - last) * fades[2 * axis + 1] : 0.0f);
        return outside < 1.0f ? 1.0f - outside : 0.0f;
    };
    const auto share = [&](float px, float pz, float py) {
        return left_over(px, 0) * left_over(pz, 1) * left_over(py, 2);
    };
    const auto read = [&](const float* data, float px, float pz, float py) {
        return share(px, pz, py) * linear(data, size, period, px, pz, py);
    };
    const auto beyond = [&](float p, int axis) {
        const float margin = axis == place ? 0.0f : 0.5f;
        return period[axis] == 0 && (p < -margin || p > (float)(size[axis] - 1) + margin);
    };
    const auto leaves = [&](float px, float pz, float py) {
        return beyond(px, 0) | beyond(pz, 1) | beyond(py, 2);
    };
    const auto limit = [&](float value, float px, float pz, float py) {
        float low, high;
        bounds(field.data, size, period, px, pz, py, low, high);
        const bool faded = share(px, pz, py) < 1.0f;
        low = faded && low > 0.0f ? 0.0f : low;
        high = faded && high < 0.0f ? 0.0f : high;
        value = value > low ? value : low;
        return value < high ? value : high;
    };
    // What is read might be what is written, for all the compiler knows: results wait here, so that it can use vectors.
    float value[RUN];
    float* to = out.data + start;
"""
)

CARRY = (
    PLACES
    + """
    const float *px = path.data + start, *pz = px + places, *py = pz + places;
    for (int l = 0; l < count; ++l) value[l] = read(field.data, px[l], pz[l], py[l]);
    for (int l = 0; l < count; ++l) to[l] = value[l];
"""
)

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
    out = _out(out, field=field)
    device = _check(place, {"field": field, "out": out}, {"path": path})
    launch(carry_kernel, field.shape, [field, path, sides, place], [out], device, whole_columns=True)
    return out


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
        sides: What the six sides are, as in ``carry``.
        place: Where the field lives, as in ``carry``.
        out: Array to write, none of the others; a new one when omitted.

    Returns:
        The corrected field, shape of ``field``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    out = _out(out, field=field)
    device = _check(place, {"field": field, "carried": carried, "out": out}, {"back": back, "forth": forth})
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
        sides: What the six sides are, as in ``carry``.
        place: Where the field lives, as in ``carry``.
        out: Array to write, none of the others; a new one when omitted.

    Returns:
        The field to carry in place of ``field``, of its shape.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    out = _out(out, field=field)
    device = _check(place, {"field": field, "carried": carried, "out": out}, {"path": path})
    launch(mend_kernel, field.shape, [field, carried, path, sides, place], [out], device, whole_columns=True)
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
    device = _check(place, {"field": field, "out": out}, {"path": path})
    launch(limit_kernel, field.shape, [field, path, sides, place], [out], device, whole_columns=True)
    return out


def _out(out: wp.array | None, field: wp.array) -> wp.array:
    checks.same_device(field=field)
    return wp.empty_like(field) if out is None else out


def _check(place: int, fields: dict[str, wp.array], paths: dict[str, wp.array]) -> wp.Device:
    """Return the device of arrays that fit each other."""
    device = checks.same_device(**fields, **paths)
    checks.floats(3, **fields)
    checks.floats(4, **paths)
    checks.same_shape(**fields)
    checks.shape((3, *fields["field"].shape), **paths)
    if place not in (0, 1, 2, 3):
        raise ValueError(f"place is {place}, expected the axis of the faces, 0, 1 or 2, or 3 for the centres")
    if any(fields["out"] is fields[name] for name in fields if name != "out"):
        raise ValueError("out is one of the fields that are read: pass another array")
    return device
