"""A vector potential on the edges of the voxels, whose curl on their faces has no divergence.

Edges along an axis lie between four voxels: there is one more of them along each of the two other axes.
"""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.fluid.faces import check_faces, launch_run, on_wall
from warpfluid.kernels.sides import SIX, WRAP

wp.set_module_options({"enable_backward": False})


@wp.func
def cell_across(i: int, n: int, wraps: bool) -> int:
    """Return the voxel at an index one beyond the border at most: the one across, or the last one."""
    if wraps:
        return wp.where(i < 0, i + n, wp.where(i >= n, i - n, i))
    return wp.clamp(i, 0, n - 1)


@wp.kernel
def mask_kernel(
    first_row: int,
    first_block: int,
    mask: wp.array3d[float],
    axis: int,
    sides: SIX,
    run: int,
    potential: wp.array3d[float],
):
    """Multiply an edge by the least of the voxels around it, so that a voxel of 0 has no force on any face."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    x0 = cell_across(wp.where(axis == 0, x, x - 1), mask.shape[0], sides[0] == WRAP)
    x1 = cell_across(x, mask.shape[0], sides[0] == WRAP)
    z0 = cell_across(wp.where(axis == 1, z, z - 1), mask.shape[1], sides[2] == WRAP)
    z1 = cell_across(z, mask.shape[1], sides[2] == WRAP)
    for y in range(begin, wp.min(begin + run, potential.shape[2])):
        y0 = cell_across(wp.where(axis == 2, y, y - 1), mask.shape[2], sides[4] == WRAP)
        y1 = cell_across(y, mask.shape[2], sides[4] == WRAP)
        # Each is here twice: along the edge there is one voxel only.
        low = wp.min(wp.min(mask[x0, z0, y0], mask[x0, z0, y1]), wp.min(mask[x0, z1, y0], mask[x0, z1, y1]))
        high = wp.min(wp.min(mask[x1, z0, y0], mask[x1, z0, y1]), wp.min(mask[x1, z1, y0], mask[x1, z1, y1]))
        potential[x, z, y] = wp.min(low, high) * potential[x, z, y]


@wp.func
def edge(potential: wp.array3d[float], x: int, z: int, y: int, cells: wp.vec3i, sides: SIX) -> float:
    """Fetch the potential of an edge; the last edge of a wrapped axis is its first."""
    i = wp.where(x == cells[0] and sides[0] == WRAP, 0, x)
    j = wp.where(z == cells[1] and sides[2] == WRAP, 0, z)
    k = wp.where(y == cells[2] and sides[4] == WRAP, 0, y)
    return potential[i, j, k]


@wp.kernel
def curl_kernel(
    first_row: int,
    first_block: int,
    potential_b: wp.array3d[float],
    potential_c: wp.array3d[float],
    axis: int,
    cells: wp.vec3i,
    sides: SIX,
    run: int,
    velocity: wp.array3d[float],
):
    """Add the circulation around a face; b and c are the axes after the face's own, in turn."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    bx = wp.where(axis == 2, 1, 0)
    bz = wp.where(axis == 0, 1, 0)
    by = wp.where(axis == 1, 1, 0)
    for y in range(begin, wp.min(begin + run, velocity.shape[2])):
        if not on_wall(axis, x, z, y, cells, sides):
            along = edge(potential_c, x + bx, z + bz, y + by, cells, sides) - edge(potential_c, x, z, y, cells, sides)
            back = edge(potential_b, x + by, z + bx, y + bz, cells, sides) - edge(potential_b, x, z, y, cells, sides)
            velocity[x, z, y] = velocity[x, z, y] + (along - back)


def mask_edges(
    edges_x: wp.array3d[float],
    edges_z: wp.array3d[float],
    edges_y: wp.array3d[float],
    mask: wp.array3d[float],
    *,
    sides: SIX,
) -> None:
    """Multiply a potential by a mask, in place; the curl is then 0 on all faces of a voxel whose mask is 0.

    Args:
        edges_x: Component along x, shape (nx, nz + 1, ny + 1).
        edges_z: Shape (nx + 1, nz, ny + 1).
        edges_y: Shape (nx + 1, nz + 1, ny).
        mask: 0 to 1, shape (nx, nz, ny).
        sides: What the box's six sides are; beyond those that do not wrap the mask goes on as at the border.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    edges = {"edges_x": edges_x, "edges_z": edges_z, "edges_y": edges_y}
    checks.same_device(mask=mask, **edges)
    checks.floats(3, mask=mask, **edges)
    _check_edges(mask.shape, edges)
    for axis, potential in enumerate(edges.values()):
        launch_run(mask_kernel, [mask, axis, sides], potential)


def add_curl(
    velocity_x: wp.array3d[float],
    velocity_z: wp.array3d[float],
    velocity_y: wp.array3d[float],
    edges_x: wp.array3d[float],
    edges_z: wp.array3d[float],
    edges_y: wp.array3d[float],
    *,
    sides: SIX,
) -> None:
    """Add the curl of a potential to a velocity, in place; faces on closed sides stay as they are.

    Args:
        velocity_x: [voxel/s], shape (nx + 1, nz, ny).
        velocity_z: Shape (nx, nz + 1, ny).
        velocity_y: Shape (nx, nz, ny + 1).
        edges_x: Component along x [voxel^2/s], shape (nx, nz + 1, ny + 1).
        edges_z: Shape (nx + 1, nz, ny + 1).
        edges_y: Shape (nx + 1, nz + 1, ny).
        sides: What the box's six sides are; the last edge of an axis that wraps counts as its first.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    edges = {"edges_x": edges_x, "edges_z": edges_z, "edges_y": edges_y}
    cells, _ = check_faces(velocity_x, velocity_z, velocity_y)
    checks.same_device(velocity_x=velocity_x, **edges)
    checks.floats(3, **edges)
    _check_edges(cells, edges)
    components = list(edges.values())
    for axis, velocity in enumerate((velocity_x, velocity_z, velocity_y)):
        around = [components[(axis + 1) % 3], components[(axis + 2) % 3]]
        launch_run(curl_kernel, [*around, axis, wp.vec3i(*cells), sides], velocity)


def _check_edges(cells: tuple[int, int, int], edges: dict[str, wp.array]) -> None:
    for axis, (name, array) in enumerate(edges.items()):
        checks.shape(tuple(n + (k != axis) for k, n in enumerate(cells)), **{name: array})
