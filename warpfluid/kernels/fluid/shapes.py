"""Signed distances to placed shapes, negative inside, and the velocity of the nearest one."""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import CPU_RUN, CUDA_RUN, launch

wp.set_module_options({"enable_backward": False})

SPHERE, BOX, CYLINDER, PLANE, MESH = 0, 1, 2, 3, 4
FAR = 1.0e6  # voxels; the distance to nothing
ACCURACY = 2.0  # of the winding number: clusters of triangles count as one from this many times their radius


@wp.struct
class PlacedShape:
    """A shape where it is: what kernels need to know of it, in index coordinates (x, z, y)."""

    kind: int
    size: wp.vec3  # half its extents along its own axes (x, y, z)
    centre: wp.vec3
    to_local: wp.mat33  # from the grid's axes to its own
    velocity: wp.vec3
    turning: wp.mat33  # from a point's offset to its velocity
    mesh: wp.uint64
    band: float  # voxels around a mesh where the distance is exact; further out it is that to its bounds


@wp.func
def box_distance(size: wp.vec3, p: wp.vec3) -> float:
    """Distance to a box around the origin."""
    q = wp.vec3(wp.abs(p[0]) - size[0], wp.abs(p[1]) - size[1], wp.abs(p[2]) - size[2])
    outside = wp.vec3(wp.max(q[0], 0.0), wp.max(q[1], 0.0), wp.max(q[2], 0.0))
    return wp.length(outside) + wp.min(wp.max(q), 0.0)


@wp.func
def mesh_distance(shape: PlacedShape, p: wp.vec3) -> float:
    """Distance to a closed mesh; its bounds spare a search far away."""
    bounds = box_distance(shape.size, p)
    if bounds > shape.band:
        return bounds
    query = wp.mesh_query_point_sign_winding_number(shape.mesh, p, FAR, ACCURACY)
    if not query.result:
        return bounds
    nearest = wp.mesh_eval_position(shape.mesh, query.face, query.u, query.v)
    return query.sign * wp.length(p - nearest)


@wp.func
def distance(shape: PlacedShape, at: wp.vec3) -> float:
    """Distance to a shape from a point of the grid."""
    p = shape.to_local * (at - shape.centre)
    result = float(FAR)
    if shape.kind == SPHERE:
        result = wp.length(p) - shape.size[0]
    elif shape.kind == BOX:
        result = box_distance(shape.size, p)
    elif shape.kind == CYLINDER:
        aside = wp.length(wp.vec2(p[0], p[2])) - shape.size[0]
        above = wp.abs(p[1]) - shape.size[1]
        result = wp.length(wp.vec2(wp.max(aside, 0.0), wp.max(above, 0.0))) + wp.min(wp.max(aside, above), 0.0)
    elif shape.kind == PLANE:
        result = p[1]
    elif shape.kind == MESH:
        result = mesh_distance(shape, p)
    return result


@wp.kernel
def union_kernel(
    first_row: int, first_block: int, shape: PlacedShape, first: wp.vec3, run: int, out: wp.array3d[float]
):
    """Lower distances to those to one more shape."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, out.shape[2])):
        at = first + wp.vec3(float(x), float(z), float(y))
        out[x, z, y] = wp.min(out[x, z, y], distance(shape, at))


@wp.kernel
def nearest_velocity_kernel(
    first_row: int,
    first_block: int,
    shape: PlacedShape,
    first: wp.vec3i,
    axis: int,
    alone: bool,
    run: int,
    nearest: wp.array3d[float],
    velocity: wp.array3d[float],
):
    """Take a shape's velocity where it is nearer than those before."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, nearest.shape[2])):
        at = wp.vec3(float(first[0] + x), float(first[1] + z), float(first[2] + y))
        at[axis] -= 0.5
        here = float(0.0)
        if not alone:
            here = distance(shape, at)
        if here < nearest[x, z, y]:
            nearest[x, z, y] = here
            moved = shape.velocity + shape.turning * (at - shape.centre)
            velocity[first[0] + x, first[1] + z, first[2] + y] = moved[axis]


def unite(shape: PlacedShape, *, first: tuple[float, float, float], out: wp.array3d[float]) -> wp.array3d[float]:
    """Lower signed distances to those to one more shape, in place.

    Args:
        shape: Where it is; a mesh must live on the device of ``out``.
        first: Index coordinates (x, z, y) of the first point of the lattice, whose points are a voxel apart.
        out: Distances [voxel], negative inside, any shape (x, z, y).

    Returns:
        ``out``.

    Raises:
        ValueError: If the array does not fit.
    """
    device = checks.same_device(out=out)
    checks.floats(3, out=out)
    launch(union_kernel, out.shape, [shape, wp.vec3(*first), _run(device)], [out], device)
    return out


def nearest_velocity(
    shape: PlacedShape,
    *,
    axis: int,
    first: tuple[int, int, int],
    nearest: wp.array3d[float],
    velocity: wp.array3d[float],
    alone: bool = False,
) -> wp.array3d[float]:
    """Take over the velocity of a shape where it is nearer than those before, in place.

    Args:
        shape: Where it is and how it moves.
        axis: Component to take and axis of the faces: 0 is x, 1 is z, 2 is y.
        first: First face (x, z, y) of the block that is written.
        nearest: Distance to the nearest shape so far [voxel], the shape of the block; lowered.
        velocity: That shape's velocity at all faces [voxel/s].
        alone: There is no other shape, so no distance needs to be measured.

    Returns:
        ``velocity``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    device = checks.same_device(nearest=nearest, velocity=velocity)
    checks.floats(3, nearest=nearest, velocity=velocity)
    checks.block(first, nearest.shape, velocity=velocity)
    inputs = [shape, wp.vec3i(*first), axis, alone, _run(device)]
    launch(nearest_velocity_kernel, nearest.shape, inputs, [nearest, velocity], device)
    return velocity


def _run(device: wp.Device) -> int:
    return CUDA_RUN if device.is_cuda else CPU_RUN
