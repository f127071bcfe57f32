"""Look a field up in a ramp: lines between a few pairs of numbers, constant beyond the first and the last."""

import numpy as np
import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.fluid.faces import launch_run

wp.set_module_options({"enable_backward": False})


@wp.kernel
def ramp_kernel(
    first_row: int,
    first_block: int,
    field: wp.array3d[float],
    scale: float,
    inputs: wp.array[float],
    values: wp.array[float],
    run: int,
    out: wp.array3d[float],
):
    """Find the pairs around each value."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    last = inputs.shape[0] - 1
    for y in range(begin, wp.min(begin + run, out.shape[2])):
        at = scale * field[x, z, y]
        found = values[0]
        for k in range(last):
            if at > inputs[k]:
                share = wp.min((at - inputs[k]) / (inputs[k + 1] - inputs[k]), 1.0)
                found = (1.0 - share) * values[k] + share * values[k + 1]
        out[x, z, y] = found


def look_up(
    field: wp.array3d[float],
    *,
    inputs: np.ndarray,
    values: np.ndarray,
    scale: float = 1.0,
    out: wp.array3d[float] | None = None,
) -> wp.array3d[float]:
    """Look every voxel of a field up in a ramp.

    Args:
        field: Shape (x, z, y).
        inputs: Values of ``scale * field``, rising.
        values: The ramp at each.
        scale: Factor of the field.
        out: Array to write; it may be ``field``; a new one when omitted.

    Returns:
        The ramp at each voxel, shape of ``field``.

    Raises:
        ValueError: If shapes, types or devices do not fit, or the inputs do not rise.
    """
    checks.same_device(field=field)
    out = wp.empty_like(field) if out is None else out
    device = checks.same_device(field=field, out=out)
    checks.floats(3, field=field, out=out)
    checks.same_shape(field=field, out=out)
    if len(inputs) != len(values) or not len(inputs) or (np.diff(inputs) <= 0).any():
        raise ValueError(f"inputs are {list(inputs)} for {len(values)} values, expected as many, which rise")
    pairs = [wp.array(np.asarray(numbers), dtype=float, device=device) for numbers in (inputs, values)]
    launch_run(ramp_kernel, [field, scale, *pairs], out)
    return out
