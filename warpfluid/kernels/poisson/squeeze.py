"""What solids ask of the fluid between them where it has no room to give way.

Two solids that near each other press out what is between them. What they ask for in a voxel does not shrink with the
open shares of its faces, so from a voxel that they nearly close fluid would shoot without bound; where they overlap,
which nothing real does, there is such a voxel nearly always. So a voxel lets out no more than its ways out are wide:
below one whole open face, their sum.
"""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import CPU_RUN, CUDA_RUN, launch
from warpfluid.kernels.sides import CLOSED, SIX

wp.set_module_options({"enable_backward": False})


@wp.func
def room(fluid: wp.array3d[float], x: int, z: int, y: int) -> float:
    """Share of a voxel that is fluid; beyond the box there is nothing else."""
    inside = x >= 0 and x < fluid.shape[0] and z >= 0 and z < fluid.shape[1] and y >= 0 and y < fluid.shape[2]
    share = float(1.0)
    if inside:
        share = fluid[x, z, y]
    return share


@wp.func
def nearing(
    open: wp.array3d[float], solid: wp.array3d[float], fluid: wp.array3d[float], axis: int, at: wp.vec3i, sides: SIX
) -> wp.vec3:
    """Flux that the solids at two opposite faces ask for as they part, and how open both faces are."""
    step = wp.vec3i(int(axis == 0), int(axis == 1), int(axis == 2))
    result = wp.vec3(0.0, 0.0, 0.0)
    speeds = wp.vec2(0.0, 0.0)
    for end in range(2):
        face = at + step * end
        beside = at + step * (2 * end - 1)
        share = open[face[0], face[1], face[2]]
        speed = solid[face[0], face[1], face[2]]
        outside = beside[axis] < 0 or beside[axis] == fluid.shape[axis]
        if outside and sides[2 * axis + end] == CLOSED:  # a wall holds what no solid covers
            speed = (1.0 - share) * speed
            share = 0.0
        # An open face between two voxels with hardly any fluid leads nowhere.
        widest = wp.max(room(fluid, at[0], at[1], at[2]), room(fluid, beside[0], beside[1], beside[2]))
        result[1 + end] = wp.min(share, widest)
        speeds[end] = speed
    low = 1.0 - result[1]
    high = 1.0 - result[2]
    # What else they ask for is what one solid of their mean speed asks for: it pushes fluid ahead, through open faces.
    result[0] = 2.0 * low * high / wp.max(low + high, 1.0e-12) * (speeds[1] - speeds[0])
    return result


@wp.kernel
def squeeze_kernel(
    first_row: int,
    first_block: int,
    open_x: wp.array3d[float],
    open_z: wp.array3d[float],
    open_y: wp.array3d[float],
    solid_x: wp.array3d[float],
    solid_z: wp.array3d[float],
    solid_y: wp.array3d[float],
    fluid: wp.array3d[float],
    sides: SIX,
    run: int,
    out: wp.array3d[float],
):
    """Write the share of the squeezing that finds no way out."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, out.shape[2])):
        at = wp.vec3i(x, z, y)
        asked = nearing(open_x, solid_x, fluid, 0, at, sides)
        asked += nearing(open_z, solid_z, fluid, 1, at, sides)
        asked += nearing(open_y, solid_y, fluid, 2, at, sides)
        out[x, z, y] = asked[0] * wp.max(1.0 - asked[1] - asked[2], 0.0)


def measure_squeeze(
    *,
    open_x: wp.array3d[float],
    open_z: wp.array3d[float],
    open_y: wp.array3d[float],
    solid_x: wp.array3d[float],
    solid_z: wp.array3d[float],
    solid_y: wp.array3d[float],
    fluid: wp.array3d[float],
    sides: SIX,
    out: wp.array3d[float],
) -> wp.array3d[float]:
    """Write the divergence that solids ask for and that voxels between them are too narrow to have.

    Without it, fluid becomes a few times as fast as the solids that squeeze it. A solid alone, however it moves and
    turns, asks for none.

    Args:
        open_x: Share of each face along x that is fluid.
        open_z: The same along z.
        open_y: The same along y.
        solid_x: Component along x of the solid's velocity at these faces [voxel/s].
        solid_z: The same along z.
        solid_y: The same along y.
        fluid: Share of each voxel that is fluid, shape (x, z, y).
        sides: What the sides of the box are.
        out: Shape of ``fluid`` [1/s].

    Returns:
        ``out``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    pairs = {"x": (open_x, solid_x), "z": (open_z, solid_z), "y": (open_y, solid_y)}
    faces = {
        f"{name}_{k}": part for k, pair in pairs.items() for name, part in zip(("open", "solid"), pair, strict=True)
    }
    device = checks.same_device(fluid=fluid, out=out, **faces)
    checks.floats(3, fluid=fluid, out=out, **faces)
    checks.same_shape(out=out, fluid=fluid)
    for axis, (name, (opening, solid)) in enumerate(pairs.items()):
        shape = tuple(n + (k == axis) for k, n in enumerate(out.shape))
        checks.shape(shape, **{f"open_{name}": opening, f"solid_{name}": solid})
    inputs = [open_x, open_z, open_y, solid_x, solid_z, solid_y, fluid, sides, CUDA_RUN if device.is_cuda else CPU_RUN]
    launch(squeeze_kernel, out.shape, inputs, [out], device)
    return out
