"""What pictures and flows go through between two scales: another size, and a median against strays."""

import warp as wp

from warpfluid.kernels import checks

wp.set_module_options({"enable_backward": False})


@wp.func
def between(place: int, size: int, wanted: int) -> float:
    """Return where the centre of a pixel lies among those of another size."""
    return wp.clamp((float(place) + 0.5) * float(size) / float(wanted) - 0.5, 0.0, float(size - 1))


@wp.kernel
def resize_kernel(field: wp.array3d[float], out: wp.array3d[float]):
    """Interpolate linearly between the centres of pixels."""
    c, u, v = wp.tid()
    at_u = between(u, field.shape[1], out.shape[1])
    at_v = between(v, field.shape[2], out.shape[2])
    i = int(at_u)
    j = int(at_v)
    right = wp.min(i + 1, field.shape[1] - 1)
    above = wp.min(j + 1, field.shape[2] - 1)
    near = wp.lerp(field[c, i, j], field[c, i, above], at_v - float(j))
    far = wp.lerp(field[c, right, j], field[c, right, above], at_v - float(j))
    out[c, u, v] = wp.lerp(near, far, at_u - float(i))


@wp.kernel
def median_kernel(flow: wp.array3d[float], out: wp.array3d[float]):
    """Take the median of 3 x 3 pixels by sorting the lower five."""
    c, u, v = wp.tid()
    values = wp.vector(length=9, dtype=float)
    for p in range(9):
        i = wp.clamp(u + p / 3 - 1, 0, flow.shape[1] - 1)
        j = wp.clamp(v + p % 3 - 1, 0, flow.shape[2] - 1)
        values[p] = flow[c, i, j]
    for p in range(5):
        for q in range(p + 1, 9):
            lower = wp.min(values[p], values[q])
            values[q] = wp.max(values[p], values[q])
            values[p] = lower
    out[c, u, v] = values[4]


def resize(field: wp.array3d[float], size: tuple[int, int]) -> wp.array3d[float]:
    """Give pictures another size; blur them first if it is smaller.

    Args:
        field: Pictures or components, shape (picture, u, v).
        size: Width and height wanted [pixel].

    Returns:
        The same pictures, shape (picture, *size).

    Raises:
        ValueError: If the field is no 3-D float array or the size is empty.
    """
    device = checks.same_device(field=field)
    checks.floats(3, field=field)
    if min(size) < 1:
        raise ValueError(f"size is {size}, expected at least 1 x 1 pixel")
    out = wp.empty((field.shape[0], *size), dtype=float, device=device)
    wp.launch(resize_kernel, dim=out.shape, inputs=[field], outputs=[out], device=device)
    return out


def median(flow: wp.array3d[float], *, out: wp.array3d[float] | None = None) -> wp.array3d[float]:
    """Take the median of the 3 x 3 pixels about each, the nearest pixels standing in beyond the border.

    Args:
        flow: Displacements, shape (component, u, v).
        out: Array to write, never ``flow``; a new one when omitted.

    Returns:
        The medians, shape of ``flow``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    checks.same_device(flow=flow)
    out = wp.empty_like(flow) if out is None else out
    device = checks.same_device(flow=flow, out=out)
    checks.floats(3, flow=flow, out=out)
    checks.same_shape(flow=flow, out=out)
    wp.launch(median_kernel, dim=flow.shape, inputs=[flow], outputs=[out], device=device)
    return out
