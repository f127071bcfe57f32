"""Fields that live in places of a MAC grid, the voxels' centres or the faces along an axis, read along paths."""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import RUN_OF_HEIGHTS
from warpfluid.kernels.sampling import LINEAR

# Opens the body of a native function over a run of heights of `out`, and defines `read`, `limit` and `leaves`.
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


def check_places(place: int, fields: dict[str, wp.array], paths: dict[str, wp.array]) -> wp.Device:
    """Check fields and the paths from or to each of their places.

    Args:
        place: 0, 1 or 2 for fields on the faces along x, z or y; 3 for fields in the centres.
        fields: By name, shape (x, z, y); "field" is among them, and "out", which none of the others may be.
        paths: By name, shape (3, x, z, y).

    Returns:
        The device they are on.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    device = checks.same_device(**fields, **paths)
    checks.floats(3, **fields)
    checks.floats(4, **paths)
    checks.same_shape(**fields)
    checks.shape((3, *fields["field"].shape), **paths)
    if place not in (0, 1, 2, 3):
        raise ValueError(f"place is {place}, expected the axis of the faces, 0, 1 or 2, or 3 for the centres")
    if fields["field"].size >= 2**31:
        raise ValueError(
            f"field has shape {fields['field'].shape}, expected less than 2^31 values: reduce the resolution"
        )
    if any(fields["out"] is fields[name] for name in fields if name != "out"):
        raise ValueError("out is one of the fields that are read: pass another array")
    return device
