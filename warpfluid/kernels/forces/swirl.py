"""Vorticity confinement (Fedkiw, Stam and Jensen 2001): give eddies back what the grid's coarseness takes from them.

The force points around each eddy the way it turns. In letters: with w = curl u and N = grad |w| / |grad |w||, which
points to where it turns fastest, it is ``strength * (N x w)``.
"""

import math

import warp as wp

from warpfluid.kernels.fluid.faces import check_faces, face_mean, launch_run, on_wall
from warpfluid.kernels.launch import CPU_RUN, CUDA_RUN, launch
from warpfluid.kernels.sides import SIX, WRAP

wp.set_module_options({"enable_backward": False})


@wp.func
def before(i: int, n: int, wraps: bool) -> int:
    """Return the voxel before one, itself at a border."""
    return wp.where(i > 0, i - 1, wp.where(wraps, n - 1, 0))


@wp.func
def after(i: int, n: int, wraps: bool) -> int:
    """Return the voxel after one, itself at a border."""
    return wp.where(i + 1 < n, i + 1, wp.where(wraps, 0, n - 1))


@wp.func
def per_voxel(i: int, n: int, wraps: bool) -> float:
    """Return one over the way between the voxels before and after."""
    return wp.where(wraps or (i > 0 and i + 1 < n), 0.5, 1.0)


@wp.func
def along_x(velocity: wp.array3d[float], x: int, z: int, y: int) -> float:
    """Twice the velocity in a voxel along x."""
    return velocity[x, z, y] + velocity[x + 1, z, y]


@wp.func
def along_z(velocity: wp.array3d[float], x: int, z: int, y: int) -> float:
    """Twice the velocity in a voxel along z."""
    return velocity[x, z, y] + velocity[x, z + 1, y]


@wp.func
def along_y(velocity: wp.array3d[float], x: int, z: int, y: int) -> float:
    """Twice the velocity in a voxel along y."""
    return velocity[x, z, y] + velocity[x, z, y + 1]


@wp.kernel
def vorticity_kernel(
    first_row: int,
    first_block: int,
    velocity_x: wp.array3d[float],
    velocity_z: wp.array3d[float],
    velocity_y: wp.array3d[float],
    sides: SIX,
    run: int,
    curl_x: wp.array3d[float],
    curl_z: wp.array3d[float],
    curl_y: wp.array3d[float],
    size: wp.array3d[float],
):
    """Take the curl of the velocity in the voxels' centres, by central differences."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    x0 = before(x, size.shape[0], sides[0] == WRAP)
    x1 = after(x, size.shape[0], sides[0] == WRAP)
    z0 = before(z, size.shape[1], sides[2] == WRAP)
    z1 = after(z, size.shape[1], sides[2] == WRAP)
    dx = 0.5 * per_voxel(x, size.shape[0], sides[0] == WRAP)
    dz = 0.5 * per_voxel(z, size.shape[1], sides[2] == WRAP)
    for y in range(begin, wp.min(begin + run, size.shape[2])):
        y0 = before(y, size.shape[2], sides[4] == WRAP)
        y1 = after(y, size.shape[2], sides[4] == WRAP)
        dy = 0.5 * per_voxel(y, size.shape[2], sides[4] == WRAP)
        y_by_z = dz * (along_y(velocity_y, x, z1, y) - along_y(velocity_y, x, z0, y))
        z_by_y = dy * (along_z(velocity_z, x, z, y1) - along_z(velocity_z, x, z, y0))
        x_by_y = dy * (along_x(velocity_x, x, z, y1) - along_x(velocity_x, x, z, y0))
        y_by_x = dx * (along_y(velocity_y, x1, z, y) - along_y(velocity_y, x0, z, y))
        z_by_x = dx * (along_z(velocity_z, x1, z, y) - along_z(velocity_z, x0, z, y))
        x_by_z = dz * (along_x(velocity_x, x, z1, y) - along_x(velocity_x, x, z0, y))
        curl = wp.vec3(y_by_z - z_by_y, x_by_y - y_by_x, z_by_x - x_by_z)
        curl_x[x, z, y] = curl[0]
        curl_z[x, z, y] = curl[1]
        curl_y[x, z, y] = curl[2]
        size[x, z, y] = wp.length(curl)


@wp.kernel
def confine_kernel(
    first_row: int,
    first_block: int,
    size: wp.array3d[float],
    mask: wp.array3d[float],
    gain: float,
    sides: SIX,
    run: int,
    curl_x: wp.array3d[float],
    curl_z: wp.array3d[float],
    curl_y: wp.array3d[float],
):
    """Replace the curl by the force; no mask is an empty array."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    x0 = before(x, size.shape[0], sides[0] == WRAP)
    x1 = after(x, size.shape[0], sides[0] == WRAP)
    z0 = before(z, size.shape[1], sides[2] == WRAP)
    z1 = after(z, size.shape[1], sides[2] == WRAP)
    dx = per_voxel(x, size.shape[0], sides[0] == WRAP)
    dz = per_voxel(z, size.shape[1], sides[2] == WRAP)
    for y in range(begin, wp.min(begin + run, size.shape[2])):
        y0 = before(y, size.shape[2], sides[4] == WRAP)
        y1 = after(y, size.shape[2], sides[4] == WRAP)
        dy = per_voxel(y, size.shape[2], sides[4] == WRAP)
        gradient = wp.vec3(
            dx * (size[x1, z, y] - size[x0, z, y]),
            dz * (size[x, z1, y] - size[x, z0, y]),
            dy * (size[x, z, y1] - size[x, z, y0]),
        )
        # In (x, z, y), which is left-handed, the curl and this product change sign, and both together do not.
        force = gain * wp.cross(wp.normalize(gradient), wp.vec3(curl_x[x, z, y], curl_z[x, z, y], curl_y[x, z, y]))
        if mask.shape[0] > 0:
            force = mask[x, z, y] * force
        curl_x[x, z, y] = force[0]
        curl_z[x, z, y] = force[1]
        curl_y[x, z, y] = force[2]


@wp.kernel
def add_mean_kernel(
    first_row: int,
    first_block: int,
    force: wp.array3d[float],
    axis: int,
    cells: wp.vec3i,
    sides: SIX,
    run: int,
    velocity: wp.array3d[float],
):
    """Add the mean of a face's two voxels."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, velocity.shape[2])):
        if not on_wall(axis, x, z, y, cells, sides):
            velocity[x, z, y] = velocity[x, z, y] + face_mean(force, axis, x, z, y, sides)


def add_swirl(
    velocity_x: wp.array3d[float],
    velocity_z: wp.array3d[float],
    velocity_y: wp.array3d[float],
    *,
    strength: float,
    sides: SIX,
    time_step: float,
    mask: wp.array3d[float] | None = None,
) -> None:
    """Spin eddies up, in place.

    The acceleration, ``strength * (N x w)``, is a speed times the vorticity [1/s]. Fedkiw et al. take the speed as
    a number times the voxel's width, so that finer grids swirl less. Here it is a plain speed: taken as a rate times a
    length of the scene, which is more voxels on a finer grid, it pushes an eddy that both grids resolve equally.

    Args:
        velocity_x: [voxel/s], shape (nx + 1, nz, ny).
        velocity_z: Shape (nx, nz + 1, ny).
        velocity_y: Shape (nx, nz, ny + 1).
        strength: [voxel/s]; an eddy of one voxel grows at this rate [1/s], so its product with the time step should
            stay below 1. Below 0 it stills eddies.
        sides: What the box's six sides are; faces on closed ones stay as they are.
        time_step: [s].
        mask: Factor, shape (nx, nz, ny); 1 when omitted.

    Raises:
        ValueError: If shapes, types or devices do not fit or the strength is not finite.
    """
    masks = {} if mask is None else {"mask": mask}
    cells, device = check_faces(velocity_x, velocity_z, velocity_y, **masks)
    if not math.isfinite(strength):
        raise ValueError(f"strength is {strength}, expected a finite number, in voxel/s")
    if strength * time_step == 0:
        return
    velocities = [velocity_x, velocity_z, velocity_y]
    run = CUDA_RUN if device.is_cuda else CPU_RUN
    *curls, size = (wp.empty(cells, dtype=float, device=device) for _ in range(4))
    mask = wp.empty((0, 0, 0), dtype=float, device=device) if mask is None else mask
    launch(vorticity_kernel, cells, [*velocities, sides, run], [*curls, size], device)
    launch(confine_kernel, cells, [size, mask, strength * time_step, sides, run], curls, device)
    for axis, velocity in enumerate(velocities):
        launch_run(add_mean_kernel, [curls[axis], axis, wp.vec3i(*cells), sides], velocity)
