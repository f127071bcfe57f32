"""Read a field at a few points anywhere, without copying it from its device."""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.sampling import trilinear

wp.set_module_options({"enable_backward": False})


@wp.kernel
def probe_kernel(field: wp.array3d[float], points: wp.array[wp.vec3], shift: wp.vec3, out: wp.array[float]):
    """Interpolate linearly, the nearest value beyond the border."""
    i = wp.tid()
    out[i] = trilinear(field, points[i] + shift)


def probe(
    field: wp.array3d[float],
    points: wp.array[wp.vec3],
    *,
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> wp.array[float]:
    """Read a field at points, linearly between its places.

    Args:
        field: Shape (x, z, y).
        points: Index coordinates (x, z, y), shape (n,).
        shift: Added to them: half a voxel along an axis for a field on its faces.

    Returns:
        The values, shape (n,).

    Raises:
        ValueError: If types or devices do not fit.
    """
    device = checks.same_device(field=field, points=points)
    checks.floats(3, field=field)
    checks.typed(wp.vec3, 1, points=points)
    out = wp.empty(points.shape, dtype=float, device=device)
    wp.launch(probe_kernel, dim=points.shape, inputs=[field, points, wp.vec3(*shift)], outputs=[out], device=device)
    return out
