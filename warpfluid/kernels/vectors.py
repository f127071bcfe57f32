"""Vector arithmetic of the solvers: fused updates, elementwise corrections, sums in float64, largest values."""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import RUN_OF_HEIGHTS, elementwise, launch, run_count

wp.set_module_options({"enable_backward": False})

RUN_DOT = (
    """
    const int heights = a.shape[2];"""
    + RUN_OF_HEIGHTS
    + """
    const size_t start = ((size_t)row * a.shape[1] + column) * heights + y;
    double sum = 0.0;
    for (int l = 0; l < count; ++l) sum += (double)a.data[start + l] * (double)b.data[start + l];
    return sum;
"""
)

# The bits of magnitudes are ordered as the magnitudes are, and NaN lies above all of them.
RUN_LARGEST = (
    """
    const int heights = a.shape[2];"""
    + RUN_OF_HEIGHTS
    + """
    const float* from = a.data + ((size_t)row * a.shape[1] + column) * heights + y;
    int found = 0;
    for (int l = 0; l < count; ++l) {
        union { float value; int bits; } here = {from[l]};
        const int bits = here.bits & 0x7fffffff;
        found = bits > found ? bits : found;
    }
    return found;
"""
)
BITS_A_FOLD = 256


@wp.func_native(snippet=RUN_DOT)
def run_dot(a: wp.array3d[float], b: wp.array3d[float], row: int, column: int, block: int) -> wp.float64:
    """Multiply and add a run of heights in float64."""


@wp.func_native(snippet=RUN_LARGEST)
def run_largest(a: wp.array3d[float], row: int, column: int, block: int) -> int:
    """Return the bits of the largest magnitude in a run of heights."""


@wp.kernel
def dot_kernel(
    first_row: int,
    first_block: int,
    a: wp.array3d[float],
    b: wp.array3d[float],
    partial: wp.array3d[wp.float64],
):
    """Multiply and add one run of heights."""
    i, column, j = wp.tid()
    row = first_row + i
    block = first_block + j
    partial[row, column, block] = run_dot(a, b, row, column, block)


@wp.kernel
def largest_kernel(first_row: int, first_block: int, a: wp.array3d[float], partial: wp.array3d[int]):
    """Find the largest magnitude of one run of heights."""
    i, column, j = wp.tid()
    row = first_row + i
    block = first_block + j
    partial[row, column, block] = run_largest(a, row, column, block)


@wp.kernel
def fold_kernel(partial: wp.array[int], out: wp.array[int]):
    """Find the largest of each group of numbers."""
    i = wp.tid()
    found = int(0)
    for j in range(i * BITS_A_FOLD, wp.min((i + 1) * BITS_A_FOLD, partial.shape[0])):
        found = wp.max(found, partial[j])
    out[i] = found


@wp.kernel
def add_scaled_kernel(a: wp.array[float], factor: float, b: wp.array[float], out: wp.array[float]):
    """Add a multiple."""
    i = wp.tid()
    out[i] = a[i] + factor * b[i]


@wp.kernel
def multiply_kernel(a: wp.array[float], b: wp.array[float], out: wp.array[float]):
    """Take the product a b."""
    i = wp.tid()
    out[i] = a[i] * b[i]


@wp.kernel
def sharpen_kernel(
    field: wp.array[float],
    fine: wp.array[float],
    coarse: wp.array[float],
    fine_weight: float,
    coarse_weight: float,
    mask: wp.array[float],
    out: wp.array[float],
):
    """Take two blurred copies away, inside a mask."""
    i = wp.tid()
    out[i] = mask[i] * (field[i] - fine_weight * fine[i] - coarse_weight * coarse[i])


@wp.kernel
def clip_kernel(low: float, out: wp.array[float]):
    """Raise what lies below a bound to it."""
    i = wp.tid()
    out[i] = wp.max(out[i], low)


@wp.kernel
def ratio_kernel(
    target: wp.array[float],
    rendered: wp.array[float],
    floor: float,
    cap: float,
    power: float,
    out: wp.array[float],
):
    """Divide the target by the rendering, 1 where the rendering is dark, never over a cap."""
    i = wp.tid()
    ratio = float(1.0)
    if rendered[i] > floor:
        ratio = wp.min(target[i] / rendered[i], cap)
        if power != 1.0:
            ratio = wp.pow(ratio, power)
    out[i] = ratio


@wp.kernel
def apply_mean_kernel(total: wp.array[float], seen: wp.array[float], out: wp.array[float]):
    """Multiply by the mean of a back-projected factor."""
    i = wp.tid()
    out[i] = out[i] * total[i] / wp.max(seen[i], 1.0e-6)


@wp.kernel
def divide_kernel(a: wp.array[float], b: wp.array[float], floor: float, out: wp.array[float]):
    """Divide, the divisor raised by a floor."""
    i = wp.tid()
    out[i] = a[i] / (b[i] + floor)


@wp.kernel
def inverse_root_kernel(a: wp.array[float], out: wp.array[float]):
    """Take 1 over the square root, 0 where there is nothing."""
    i = wp.tid()
    value = float(0.0)
    if a[i] > 0.0:
        value = 1.0 / wp.sqrt(a[i])
    out[i] = value


@wp.kernel
def fade_kernel(share: wp.array[float], cover: wp.array[float], limit: float, out: wp.array[float]):
    """Scale by 1 - share / limit, the share taken over the covered part of its neighbourhood."""
    i = wp.tid()
    smooth = share[i] / wp.max(cover[i], 1.0e-3)
    out[i] = out[i] * wp.clamp(1.0 - smooth / limit, 0.0, 1.0)


def dot(a: wp.array3d[float], b: wp.array3d[float], *, weights: list[float] | None = None) -> float:
    """Return the inner product of two volumes or sets of images, summed in float64.

    The order of the sum does not depend on the number of threads, so the same arrays give the same bits.

    Args:
        a: Shape (rows, columns, heights).
        b: The same shape.
        weights: One factor a row (an angle of a set of images); 1 when omitted.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    device = checks.same_device(a=a, b=b)
    checks.floats(3, a=a, b=b)
    checks.same_shape(a=a, b=b)
    rows, columns, heights = a.shape
    partial = wp.empty((rows, columns, run_count(heights, device)), dtype=wp.float64, device=device)
    launch(dot_kernel, a.shape, [a, b], [partial], device)
    if device.is_cuda and weights is None:
        return float(wp.utils.array_sum(partial.flatten()))
    sums = partial.numpy().sum(axis=(1, 2))
    return float(sums.sum() if weights is None else (sums * weights).sum())


def largest(a: wp.array3d[float]) -> float:
    """Return the largest magnitude in a volume, NaN if there is one.

    Args:
        a: Shape (rows, columns, heights).

    Raises:
        ValueError: If the type does not fit.
    """
    device = checks.same_device(a=a)
    checks.floats(3, a=a)
    rows, columns, heights = a.shape
    partial = wp.empty((rows, columns, run_count(heights, device)), dtype=int, device=device)
    launch(largest_kernel, a.shape, [a], [partial], device)
    folded = wp.empty(-(-partial.size // BITS_A_FOLD), dtype=int, device=device)
    wp.launch(fold_kernel, dim=folded.size, inputs=[partial.flatten()], outputs=[folded], device=device)
    return float(folded.numpy().max(keepdims=True).view("float32")[0])


def add_scaled(a: wp.array, factor: float, b: wp.array, *, out: wp.array) -> wp.array:
    """Write a + factor b; ``out`` may be ``a`` or ``b``."""
    return elementwise(add_scaled_kernel, [a, factor, b], out)


def multiply(a: wp.array, b: wp.array, *, out: wp.array) -> wp.array:
    """Write the product a b; ``out`` may be ``a`` or ``b``."""
    return elementwise(multiply_kernel, [a, b], out)


def sharpen(
    field: wp.array,
    fine: wp.array,
    coarse: wp.array,
    *,
    fine_weight: float,
    coarse_weight: float,
    mask: wp.array,
    out: wp.array,
) -> wp.array:
    """Write mask (field - fine_weight fine - coarse_weight coarse)."""
    return elementwise(sharpen_kernel, [field, fine, coarse, fine_weight, coarse_weight, mask], out)


def clip(field: wp.array, low: float = 0.0) -> wp.array:
    """Raise values below ``low`` to it, in place."""
    return elementwise(clip_kernel, [low], field)


def ratio(target: wp.array, rendered: wp.array, *, floor: float, cap: float, power: float, out: wp.array) -> wp.array:
    """Write min(target / rendered, cap) ** power, 1 where the rendering is at most ``floor``."""
    return elementwise(ratio_kernel, [target, rendered, floor, cap, power], out)


def apply_mean(field: wp.array, total: wp.array, seen: wp.array) -> wp.array:
    """Multiply a volume by total / seen, in place: a factor back-projected and averaged over its rays."""
    return elementwise(apply_mean_kernel, [total, seen], field)


def divide(a: wp.array, b: wp.array, *, floor: float, out: wp.array) -> wp.array:
    """Write a / (b + floor); ``out`` may be ``a``."""
    return elementwise(divide_kernel, [a, b, floor], out)


def inverse_root(a: wp.array, *, out: wp.array) -> wp.array:
    """Write 1 / sqrt(a), 0 where a is not above 0; ``out`` may be ``a``."""
    return elementwise(inverse_root_kernel, [a], out)


def fade(field: wp.array, share: wp.array, cover: wp.array, *, limit: float) -> wp.array:
    """Scale a volume by 1 - (share / cover) / limit, kept within 0 and 1, in place."""
    return elementwise(fade_kernel, [share, cover, limit], field)
