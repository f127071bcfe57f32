"""What a field holds in total, and keeping it: interpolation neither makes nor loses only on average."""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import CPU_RUN, CUDA_RUN, elementwise, launch, run_count

wp.set_module_options({"enable_backward": False})


@wp.kernel
def add_kernel(first_row: int, first_block: int, field: wp.array3d[float], run: int, partial: wp.array3d[wp.float64]):
    """Add up one run of heights."""
    row, z, j = wp.tid()
    x = first_row + row
    block = first_block + j
    total = wp.float64(0.0)
    for y in range(block * run, wp.min((block + 1) * run, field.shape[2])):
        total += wp.float64(field[x, z, y])
    partial[x, z, block] = total


@wp.kernel
def scale_kernel(factor: float, out: wp.array[float]):
    """Multiply by a number."""
    i = wp.tid()
    out[i] = factor * out[i]


def total(field: wp.array3d[float]) -> float:
    """Return the sum of a field, in float64: the same bits whatever the number of threads.

    Args:
        field: Shape (x, z, y).

    Raises:
        ValueError: If the type does not fit.
    """
    device = checks.same_device(field=field)
    checks.floats(3, field=field)
    rows, columns, heights = field.shape
    partial = wp.empty((rows, columns, run_count(heights, device)), dtype=wp.float64, device=device)
    launch(add_kernel, field.shape, [field, CUDA_RUN if device.is_cuda else CPU_RUN], [partial], device)
    return float(partial.numpy().sum())


def scale(field: wp.array, factor: float) -> wp.array:
    """Multiply a field by a number, in place; by 1 it keeps its bits."""
    return field if factor == 1.0 else elementwise(scale_kernel, [float(factor)], field)
