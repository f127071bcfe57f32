"""What must be true at the sides of the box and within solids, whatever the pressure."""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import elementwise
from warpfluid.kernels.sides import CLOSED, SIX, WRAP

wp.set_module_options({"enable_backward": False})


@wp.kernel
def clear_solid_kernel(fluid: wp.array[float], out: wp.array[float]):
    """Clear voxels without fluid."""
    i = wp.tid()
    if fluid[i] <= 0.0:
        out[i] = 0.0


@wp.kernel
def hold_walls_kernel(low: int, high: int, out: wp.array3d[float]):
    """Stop what goes through the walls at both ends of the first axis; join what wraps."""
    j, k = wp.tid()
    last = out.shape[0] - 1
    if low == WRAP:
        mean = 0.5 * (out[0, j, k] + out[last, j, k])
        out[0, j, k] = mean
        out[last, j, k] = mean
    if low == CLOSED:
        out[0, j, k] = 0.0
    if high == CLOSED:
        out[last, j, k] = 0.0


def clear_solid(fluid: wp.array3d[float], *, out: wp.array3d[float]) -> wp.array3d[float]:
    """Write 0 where there is no fluid.

    Args:
        fluid: Above 0 where there is, shape (x, z, y).
        out: Same shape, changed.

    Returns:
        ``out``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    return elementwise(clear_solid_kernel, [fluid], out)


def hold_walls(velocity: wp.array3d[float], *, axis: int, sides: SIX) -> wp.array3d[float]:
    """Stop what goes through closed sides and join the two faces of a wrapped side, in place.

    Args:
        velocity: Component along the axis on its faces [voxel/s].
        axis: 0 is x, 1 is z, 2 is y.
        sides: What the sides of the box are.

    Returns:
        ``velocity``.

    Raises:
        ValueError: If the type does not fit.
    """
    device = checks.same_device(velocity=velocity)
    checks.floats(3, velocity=velocity)
    ends = velocity.transpose((axis, *(other for other in range(3) if other != axis)))
    low, high = sides[2 * axis], sides[2 * axis + 1]
    wp.launch(hold_walls_kernel, dim=ends.shape[1:], inputs=[low, high], outputs=[ends], device=device)
    return velocity
