"""A velocity in the centres of the voxels, from the faces around them."""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.fluid.faces import check_faces, launch_run

wp.set_module_options({"enable_backward": False})


@wp.kernel
def centre_kernel(
    first_row: int, first_block: int, component: wp.array3d[float], axis: int, run: int, out: wp.array3d[float]
):
    """Average both faces of a voxel."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, out.shape[2])):
        i = wp.where(axis == 0, x + 1, x)
        j = wp.where(axis == 1, z + 1, z)
        k = wp.where(axis == 2, y + 1, y)
        out[x, z, y] = 0.5 * (component[x, z, y] + component[i, j, k])


@wp.kernel
def speed_kernel(
    first_row: int,
    first_block: int,
    velocity_x: wp.array3d[float],
    velocity_z: wp.array3d[float],
    velocity_y: wp.array3d[float],
    run: int,
    out: wp.array3d[float],
):
    """Take the length of the mean velocity of a voxel's faces."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, out.shape[2])):
        along_x = velocity_x[x, z, y] + velocity_x[x + 1, z, y]
        along_z = velocity_z[x, z, y] + velocity_z[x, z + 1, y]
        along_y = velocity_y[x, z, y] + velocity_y[x, z, y + 1]
        out[x, z, y] = 0.5 * wp.length(wp.vec3(along_x, along_z, along_y))


def to_centres(component: wp.array3d[float], *, axis: int) -> wp.array3d[float]:
    """Average a component of a velocity from the faces to the voxels.

    Args:
        component: On its faces, shape (x, z, y), one longer along the axis than the voxels.
        axis: 0 is x, 1 is z, 2 is y.

    Returns:
        The component in the voxels, in the unit it had.

    Raises:
        ValueError: If the type does not fit.
    """
    device = checks.same_device(component=component)
    checks.floats(3, component=component)
    shape = tuple(n - (k == axis) for k, n in enumerate(component.shape))
    out = wp.empty(shape, dtype=float, device=device)
    launch_run(centre_kernel, [component, axis], out)
    return out


def measure_speed(
    velocity_x: wp.array3d[float], velocity_z: wp.array3d[float], velocity_y: wp.array3d[float]
) -> wp.array3d[float]:
    """Return how fast the fluid moves in each voxel.

    Args:
        velocity_x: [voxel/s], shape (nx + 1, nz, ny).
        velocity_z: Shape (nx, nz + 1, ny).
        velocity_y: Shape (nx, nz, ny + 1).

    Returns:
        The speed [voxel/s], shape (nx, nz, ny).

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    cells, device = check_faces(velocity_x, velocity_z, velocity_y)
    out = wp.empty(cells, dtype=float, device=device)
    launch_run(speed_kernel, [velocity_x, velocity_z, velocity_y], out)
    return out
