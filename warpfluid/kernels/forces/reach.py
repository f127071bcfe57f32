"""How far something about a centre reaches: a soft ball."""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.fluid.faces import launch_run
from warpfluid.kernels.forces.pushes import away
from warpfluid.kernels.sides import SIX, WRAP

wp.set_module_options({"enable_backward": False})


@wp.kernel
def reach_kernel(
    first_row: int,
    first_block: int,
    centre: wp.vec3,
    radius: float,
    sides: SIX,
    run: int,
    out: wp.array3d[float],
):
    """Fall off as a Gaussian does."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    dx = away(float(x), centre[0], out.shape[0], sides[0] == WRAP)
    dz = away(float(z), centre[1], out.shape[1], sides[2] == WRAP)
    for y in range(begin, wp.min(begin + run, out.shape[2])):
        dy = away(float(y), centre[2], out.shape[2], sides[4] == WRAP)
        out[x, z, y] = wp.exp(-0.5 * (dx * dx + dz * dz + dy * dy) / (radius * radius))


def make_reach(
    out: wp.array3d[float], *, centre: tuple[float, float, float], radius: float, sides: SIX
) -> wp.array3d[float]:
    """Write exp(-r^2 / 2R^2), r from a centre: 1 there, nearly 0 beyond three radii.

    Args:
        out: What is written, shape (x, z, y).
        centre: (x, z, y), voxel centres at whole numbers [voxel].
        radius: R [voxel].
        sides: What the box's six sides are; where it wraps, r is the shortest way.

    Returns:
        ``out``.

    Raises:
        ValueError: If the type does not fit or the radius is not above 0.
    """
    checks.same_device(out=out)
    checks.floats(3, out=out)
    if not radius > 0:
        raise ValueError(f"radius is {radius}, expected a number above 0, in voxels")
    launch_run(reach_kernel, [wp.vec3(*centre), radius, sides], out)
    return out
