"""The faces of a MAC grid (Harlow and Welch 1965): their arrays, and the two voxels that share one.

Face i along an axis lies between voxels i - 1 and i. A velocity is three arrays, one an axis, each one longer along
its own axis than the box has voxels.
"""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import CPU_RUN, CUDA_RUN, launch
from warpfluid.kernels.sides import CLOSED, SIX, WRAP

wp.set_module_options({"enable_backward": False})


@wp.func
def cell_or_none(i: int, n: int, wraps: bool) -> int:
    """Return the voxel at an index one beyond the border at most: the one across, or -1 where there is none."""
    if i >= 0 and i < n:
        return i
    if not wraps:
        return -1
    return wp.where(i < 0, i + n, i - n)


@wp.func
def on_wall(axis: int, x: int, z: int, y: int, cells: wp.vec3i, sides: SIX) -> bool:
    """Tell whether a face lies on a closed side, where nothing moves through."""
    i = wp.where(axis == 0, x, wp.where(axis == 1, z, y))
    if i == 0:
        return sides[2 * axis] == CLOSED
    return i == cells[axis] and sides[2 * axis + 1] == CLOSED


@wp.func
def face_mean(field: wp.array3d[float], axis: int, x: int, z: int, y: int, sides: SIX) -> float:
    """Average the two voxels that share a face; outside an open side there is 0."""
    i = wp.where(axis == 0, x, wp.where(axis == 1, z, y))
    n = field.shape[axis]
    wraps = sides[2 * axis] == WRAP
    total = float(0.0)
    for side in range(2):
        cell = cell_or_none(i - side, n, wraps)
        if cell >= 0:
            a = wp.where(axis == 0, cell, x)
            b = wp.where(axis == 1, cell, z)
            c = wp.where(axis == 2, cell, y)
            total += 0.5 * field[a, b, c]
    return total


def check_faces(
    velocity_x: wp.array3d[float], velocity_z: wp.array3d[float], velocity_y: wp.array3d[float], **cells: wp.array
) -> tuple[tuple[int, int, int], wp.Device]:
    """Check the arrays of a velocity, and those that have a value a voxel.

    Args:
        velocity_x: Shape (nx + 1, nz, ny).
        velocity_z: Shape (nx, nz + 1, ny).
        velocity_y: Shape (nx, nz, ny + 1).
        **cells: Shape (nx, nz, ny).

    Returns:
        (nx, nz, ny), and where the arrays are.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    faces = {"velocity_x": velocity_x, "velocity_z": velocity_z, "velocity_y": velocity_y}
    device = checks.same_device(**faces, **cells)
    checks.floats(3, **faces, **cells)
    nx, nz, ny = velocity_x.shape[0] - 1, velocity_x.shape[1], velocity_x.shape[2]
    if nx < 1:
        raise ValueError(f"velocity_x has shape {tuple(velocity_x.shape)}, expected two faces or more along x")
    checks.shape((nx, nz + 1, ny), velocity_z=velocity_z)
    checks.shape((nx, nz, ny + 1), velocity_y=velocity_y)
    checks.shape((nx, nz, ny), **cells)
    return (nx, nz, ny), device


def launch_run(kernel: wp.Kernel, inputs: list, out: wp.array3d[float]) -> None:
    """Launch a kernel in which a thread loops over a run of heights.

    Args:
        kernel: Takes ``first_row`` and ``first_block`` before ``inputs``, then ``run``, the heights of a run, and
            ``out``.
        inputs: Further inputs.
        out: What is written; its shape is what is launched over.
    """
    run = CUDA_RUN if out.device.is_cuda else CPU_RUN
    launch(kernel, out.shape, [*inputs, run], [out], out.device)
