"""How footage guides a simulation: its slow motion (Eqs. 8-9) and its density (Eq. 10)."""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import CPU_RUN, CUDA_RUN, elementwise, launch

wp.set_module_options({"enable_backward": False})


@wp.kernel
def guide_kernel(low: wp.array[float], target: wp.array[float], weight: float, out: wp.array[float]):
    """Replace low frequencies by others."""
    i = wp.tid()
    out[i] = out[i] + weight * (target[i] - low[i])


@wp.kernel
def blend_kernel(volume: wp.array[float], add: float, subtract: float, out: wp.array[float]):
    """Move density towards a volume, at another pace down than up."""
    i = wp.tid()
    difference = volume[i] - out[i]
    out[i] = out[i] + wp.where(difference > 0.0, add, subtract) * difference


@wp.kernel
def mix_kernel(other: wp.array[float], share: wp.array[float], out: wp.array[float]):
    """Take a share of something else."""
    i = wp.tid()
    out[i] = out[i] + share[i] * (other[i] - out[i])


@wp.kernel
def to_faces_kernel(
    first_row: int,
    first_block: int,
    field: wp.array3d[float],
    axis: int,
    scale: float,
    run: int,
    out: wp.array3d[float],
):
    """Average both neighbours of a face, the one there is at the border."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, out.shape[2])):
        i = wp.min(x, field.shape[0] - 1)
        j = wp.min(z, field.shape[1] - 1)
        k = wp.min(y, field.shape[2] - 1)
        below = field[
            wp.where(axis == 0, wp.max(x - 1, 0), i),
            wp.where(axis == 1, wp.max(z - 1, 0), j),
            wp.where(axis == 2, wp.max(y - 1, 0), k),
        ]
        out[x, z, y] = 0.5 * scale * (below + field[i, j, k])


def guide(velocity: wp.array3d[float], low: wp.array3d[float], target: wp.array3d[float], *, weight: float) -> wp.array:
    """Replace the low frequencies of one component of a velocity by the footage's, in place (Eqs. 8-9).

    Args:
        velocity: psi, on faces [voxel/s].
        low: G(psi), the same shape.
        target: G(omega), the same shape.
        weight: 1 replaces them, 0 changes nothing.

    Returns:
        ``velocity``: psi - w G(psi) + w G(omega).

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    return elementwise(guide_kernel, [low, target, weight], velocity) if weight else velocity


def blend(density: wp.array3d[float], volume: wp.array3d[float], *, add: float, subtract: float = 0.0) -> wp.array:
    """Move a density towards a volume, in place (Eq. 10).

    Args:
        density: d, shape (x, z, y).
        volume: v, the same shape.
        add: lambda, the share of the volume where the density is lower.
        subtract: The same where it is higher; 0 is Eq. 10.

    Returns:
        ``density``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    return elementwise(blend_kernel, [volume, add, subtract], density) if add or subtract else density


def mix(field: wp.array3d[float], other: wp.array3d[float], *, share: wp.array3d[float]) -> wp.array:
    """Take a share of another field that differs from voxel to voxel, in place.

    Args:
        field: Shape (x, z, y).
        other: What to take, the same shape.
        share: How much of it, 0 to 1, the same shape.

    Returns:
        ``field``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    return elementwise(mix_kernel, [other, share], field)


def to_faces(field: wp.array3d[float], *, axis: int, scale: float, out: wp.array3d[float]) -> wp.array3d[float]:
    """Average a component from the voxels to the faces.

    Args:
        field: Shape (x, z, y).
        axis: Of the component: 0 is x, 1 is z, 2 is y.
        scale: Factor on the way.
        out: Its faces, one longer along the axis.

    Returns:
        ``out``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    device = checks.same_device(field=field, out=out)
    checks.floats(3, field=field, out=out)
    checks.shape(tuple(n + (k == axis) for k, n in enumerate(field.shape)), out=out)
    launch(to_faces_kernel, out.shape, [field, axis, scale, CUDA_RUN if device.is_cuda else CPU_RUN], [out], device)
    return out
