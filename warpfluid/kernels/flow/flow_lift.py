"""The approximate 3D optical flow: 2D flow of all views, lifted into the volume (Eqs. 5-7).

The paper averages the components that the views see of a motion. That is exact for views at 0 and 90 degrees; at others
uniform motion comes out too slow or skewed. The motion that fits all views best costs no more: two unknowns a voxel.
"""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import CPU_RUN, CUDA_RUN, launch

wp.set_module_options({"enable_backward": False})

UNSEEN = wp.constant(1.0e-6)  # below this part of the views' weight a direction is one that no view sees


@wp.kernel
def lift_kernel(
    first_row: int,
    first_block: int,
    flow_u: wp.array3d[float],
    flow_v: wp.array3d[float],
    directions: wp.array[wp.vec4],
    corner: wp.vec2i,
    average: bool,
    run: int,
    omega_x: wp.array3d[float],
    omega_z: wp.array3d[float],
    omega_y: wp.array3d[float],
):
    """Find the motion of a voxel that the views show."""
    i, z, j = wp.tid()
    x = first_row + i
    begin = (first_block + j) * run
    width = flow_u.shape[1]
    middle = 0.5 * float(width - 1)
    for y in range(begin, wp.min(begin + run, omega_x.shape[2])):
        total = wp.vec3(0.0, 0.0, 0.0)
        seen = wp.vec3(0.0, 0.0, 0.0)  # of Eqs. 5-7
        square = wp.vec3(0.0, 0.0, 0.0)  # of the normal equations: c c, c s, s s
        for a in range(flow_u.shape[0]):
            c = directions[a][0]
            s = directions[a][1]
            u = (float(x + corner[0]) - middle) * c + (float(z + corner[1]) - middle) * s + middle
            u = wp.clamp(u, 0.0, float(width - 1))
            left = wp.min(int(u), wp.max(width - 2, 0))
            right = wp.min(left + 1, width - 1)
            part = u - float(left)
            along_u = wp.lerp(flow_u[a, left, y], flow_u[a, right, y], part)
            along_v = wp.lerp(flow_v[a, left, y], flow_v[a, right, y], part)
            total += wp.vec3(along_u * c, along_u * s, along_v)
            seen += wp.vec3(wp.abs(c), wp.abs(s), 1.0)
            square += wp.vec3(c * c, c * s, s * s)
        trace = square[0] + square[2]
        determinant = square[0] * square[2] - square[1] * square[1]
        if average:
            omega_x[x, z, y] = wp.where(seen[0] > UNSEEN, total[0] / wp.max(seen[0], UNSEEN), 0.0)
            omega_z[x, z, y] = wp.where(seen[1] > UNSEEN, total[1] / wp.max(seen[1], UNSEEN), 0.0)
        elif determinant > UNSEEN * trace * trace:
            omega_x[x, z, y] = (square[2] * total[0] - square[1] * total[1]) / determinant
            omega_z[x, z, y] = (square[0] * total[1] - square[1] * total[0]) / determinant
        else:  # one view, or views that show the same: nothing along the line of sight
            omega_x[x, z, y] = total[0] / trace
            omega_z[x, z, y] = total[1] / trace
        omega_y[x, z, y] = total[2] / seen[2]


def lift(
    flow_u: wp.array3d[float],
    flow_v: wp.array3d[float],
    directions: wp.array[wp.vec4],
    shape: tuple[int, int, int],
    *,
    corner: tuple[int, int] = (0, 0),
    average: bool = False,
) -> tuple[wp.array3d[float], wp.array3d[float], wp.array3d[float]]:
    """Lift the flow of all views into a volume.

    Args:
        flow_u: Displacement to the right [pixel/frame], shape (view, u, v).
        flow_v: Displacement up, the same shape.
        directions: cos t, sin t, m and 1 / m of every view's angle.
        shape: Shape of the volume (x, z, y).
        corner: Where in the box, as wide as the images, the volume begins (x, z).
        average: Average components, Eqs. 5-7 to the letter, instead of fitting the views by least squares.

    Returns:
        Components along x, z and y [voxel/frame], each of the volume's shape; 0 for one that no view sees.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    device = checks.same_device(flow_u=flow_u, flow_v=flow_v, directions=directions)
    checks.floats(3, flow_u=flow_u, flow_v=flow_v)
    checks.same_shape(flow_u=flow_u, flow_v=flow_v)
    checks.typed(wp.vec4, 1, directions=directions)
    checks.shape((flow_u.shape[0],), directions=directions)
    if shape[2] != flow_u.shape[2]:
        raise ValueError(f"shape is {shape}, expected {flow_u.shape[2]} heights as the flow has")
    omega = tuple(wp.empty(shape, dtype=float, device=device) for _ in range(3))
    inputs = [flow_u, flow_v, directions, wp.vec2i(corner), average, CUDA_RUN if device.is_cuda else CPU_RUN]
    launch(lift_kernel, shape, inputs, list(omega), device)
    return omega
