"""Fewer, larger voxels: what is smooth costs less on a coarse lattice."""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import CPU_RUN, CUDA_RUN, launch
from warpfluid.kernels.sampling import coarse_place, coarse_shape, trilinear

wp.set_module_options({"enable_backward": False})


@wp.kernel
def coarsen_kernel(
    first_row: int, first_block: int, field: wp.array3d[float], factor: int, run: int, out: wp.array3d[float]
):
    """Average the fine voxels of each coarse one; beyond the border they are 0."""
    i, z, j = wp.tid()
    x = first_row + i
    begin = (first_block + j) * run
    share = 1.0 / float(factor * factor * factor)
    for y in range(begin, wp.min(begin + run, out.shape[2])):
        total = float(0.0)
        for fx in range(factor * x, wp.min(factor * (x + 1), field.shape[0])):
            for fz in range(factor * z, wp.min(factor * (z + 1), field.shape[1])):
                for fy in range(factor * y, wp.min(factor * (y + 1), field.shape[2])):
                    total += field[fx, fz, fy]
        out[x, z, y] = share * total


@wp.kernel
def refine_kernel(
    first_row: int, first_block: int, coarse: wp.array3d[float], factor: int, run: int, out: wp.array3d[float]
):
    """Read the coarse field at each fine voxel."""
    i, z, j = wp.tid()
    x = first_row + i
    begin = (first_block + j) * run
    for y in range(begin, wp.min(begin + run, out.shape[2])):
        out[x, z, y] = trilinear(coarse, coarse_place(x, z, y, factor))


def coarsen(field: wp.array3d[float], *, factor: int) -> wp.array3d[float]:
    """Average cubes of voxels.

    Args:
        field: 0 beyond the border, shape (x, z, y).
        factor: Voxels along an edge of a cube.

    Returns:
        The means, each length divided by the factor and rounded up.

    Raises:
        ValueError: If the field is no contiguous 3-D float array, or the factor below 1.
    """
    device = checks.same_device(field=field)
    checks.floats(3, field=field)
    _check_factor(factor)
    out = wp.empty(coarse_shape(field.shape, factor), dtype=float, device=device)
    launch(coarsen_kernel, out.shape, [field, factor, CUDA_RUN if device.is_cuda else CPU_RUN], [out], device)
    return out


def refine(coarse: wp.array3d[float], *, factor: int, out: wp.array3d[float]) -> wp.array3d[float]:
    """Read a coarse field at fine voxels, linearly.

    Args:
        coarse: As ``coarsen`` would return it for ``out``.
        factor: Fine voxels along an edge of a coarse one.
        out: Field to write, shape (x, z, y).

    Returns:
        ``out``.

    Raises:
        ValueError: If shapes, types or devices do not fit, or the factor is below 1.
    """
    device = checks.same_device(coarse=coarse, out=out)
    checks.floats(3, coarse=coarse, out=out)
    _check_factor(factor)
    checks.shape(coarse_shape(out.shape, factor), coarse=coarse)
    launch(refine_kernel, out.shape, [coarse, factor, CUDA_RUN if device.is_cuda else CPU_RUN], [out], device)
    return out


def _check_factor(factor: int) -> None:
    if factor < 1:
        raise ValueError(f"factor is {factor}, expected 1 or more")
