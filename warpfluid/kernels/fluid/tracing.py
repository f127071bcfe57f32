"""Where the fluid came from, or goes to, in one time step: paths through a velocity on faces.

A path is found with the midpoint rule (second-order Runge-Kutta). The velocity in between is interpolated linearly,
each component from its own faces; beyond the box it is that of the border.
"""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import RUN_OF_HEIGHTS, launch
from warpfluid.kernels.sampling import LINEAR
from warpfluid.kernels.sides import SIX

wp.set_module_options({"enable_backward": False})

CENTRE = 3  # where a value lives: on the faces along axis 0, 1 or 2, or in the centre of a voxel

TRACE = (
    """
    const int heights = path.shape[3];"""
    + RUN_OF_HEIGHTS
    + LINEAR
    + """
    const wp::array_t<float>* const components[3] = {&velocity_x, &velocity_z, &velocity_y};
    const int cells[3] = {velocity_y.shape[0], velocity_y.shape[1], velocity_x.shape[2]};
    float start[3][RUN], moved[3][RUN];
    for (int axis = 0; axis < 3; ++axis) {
        // The mean of the faces around the place: two along the component's axis, and two along the place's.
        const float* data = components[axis]->data;
        const int* size = components[axis]->shape.dims;
        const int here[3] = {x, z, y};
        int low[3] = {x, z, 0}, high[3] = {x, z, 0};
        for (int k = 0; k < 2 && axis != place; ++k) {
            const bool wraps = sides[2 * k] == 2;
            if (k == axis) high[k] = here[k] + 1;
            if (k == place) {
                low[k] = here[k] > 0 ? here[k] - 1 : (wraps ? cells[k] - 1 : 0);
                high[k] = here[k] < cells[k] ? here[k] : (wraps ? 0 : cells[k] - 1);
            }
        }
        const float* a = data + ((size_t)low[0] * size[1] + low[1]) * size[2];
        const float* b = data + ((size_t)low[0] * size[1] + high[1]) * size[2];
        const float* c = data + ((size_t)high[0] * size[1] + low[1]) * size[2];
        const float* d = data + ((size_t)high[0] * size[1] + high[1]) * size[2];
        if (place == 2 && axis != 2)
            for (int l = 0; l < count; ++l) {
                const int under = y + l > 0 ? y + l - 1 : (sides[4] == 2 ? cells[2] - 1 : 0);
                const int over = y + l < cells[2] ? y + l : (sides[4] == 2 ? 0 : cells[2] - 1);
                start[axis][l] = 0.125f * (((a[under] + b[under]) + (c[under] + d[under]))
                                           + ((a[over] + b[over]) + (c[over] + d[over])));
            }
        else {
            const int up = axis == 2 && place != 2;
            for (int l = 0; l < count; ++l)
                start[axis][l] = 0.125f * (((a[y + l] + b[y + l]) + (c[y + l] + d[y + l]))
                                           + ((a[y + l + up] + b[y + l + up]) + (c[y + l + up] + d[y + l + up])));
        }
    }
    for (int axis = 0; axis < 3; ++axis) {
        const float* data = components[axis]->data;
        const int* dims = components[axis]->shape.dims;
        const int size[3] = {dims[0], dims[1], dims[2]};
        const int period[3] = {
            sides[0] == 2 ? cells[0] : 0, sides[2] == 2 ? cells[1] : 0, sides[4] == 2 ? cells[2] : 0};
        const float at_x = (float)x + 0.5f * (float)((axis == 0) - (place == 0));
        const float at_z = (float)z + 0.5f * (float)((axis == 1) - (place == 1));
        const float at_y = (float)y + 0.5f * (float)((axis == 2) - (place == 2));
        const float half = 0.5f * time_step;
        for (int l = 0; l < count; ++l)
            moved[axis][l] = linear(data, size, period, at_x + half * start[0][l], at_z + half * start[1][l],
                                    at_y + (float)l + half * start[2][l]);
    }
    const size_t places = (size_t)path.shape[1] * path.shape[2] * heights;
    float* to = path.data + ((size_t)x * path.shape[2] + z) * heights + y;
    for (int l = 0; l < count; ++l) {
        to[l] = (float)x + time_step * moved[0][l];
        to[places + l] = (float)z + time_step * moved[1][l];
        to[2 * places + l] = (float)(y + l) + time_step * moved[2][l];
    }
"""
)


@wp.func_native(snippet=TRACE)
def trace_run(
    velocity_x: wp.array3d[float],
    velocity_z: wp.array3d[float],
    velocity_y: wp.array3d[float],
    sides: SIX,
    place: int,
    time_step: float,
    x: int,
    z: int,
    block: int,
    path: wp.array4d[float],
):
    """Follow the paths that start in a run of heights."""


@wp.kernel
def trace_kernel(
    first_row: int,
    first_block: int,
    velocity_x: wp.array3d[float],
    velocity_z: wp.array3d[float],
    velocity_y: wp.array3d[float],
    sides: SIX,
    place: int,
    time_step: float,
    path: wp.array4d[float],
):
    """Go half a step with the velocity here, then the whole step with the velocity there."""
    i, z, j = wp.tid()
    x = first_row + i
    block = first_block + j
    trace_run(velocity_x, velocity_z, velocity_y, sides, place, time_step, x, z, block, path)


def trace(
    velocity_x: wp.array3d[float],
    velocity_z: wp.array3d[float],
    velocity_y: wp.array3d[float],
    sides: SIX,
    *,
    place: int,
    time_step: float,
    out: wp.array4d[float] | None = None,
) -> wp.array4d[float]:
    """Follow the fluid from each place for one time step (midpoint rule).

    Args:
        velocity_x: Component along x on its faces [voxel/s], shape (nx + 1, nz, ny).
        velocity_z: Along z, shape (nx, nz + 1, ny).
        velocity_y: Along y, up, shape (nx, nz, ny + 1).
        sides: What the six sides are.
        place: 0, 1 or 2 for paths from the faces along x, z or y; ``CENTRE`` for paths from the voxels' centres.
        time_step: Duration [s]; negative to go back.
        out: Array to write, of the shape of what is returned; a new one when omitted.

    Returns:
        Where the paths end, shape (3, x, z, y) of the places, in their own index coordinates: at rest a path ends at
        its own index. Ends beyond the box are left there.

    Raises:
        ValueError: If shapes, types or devices do not fit, or the place is none.
    """
    velocity = {"velocity_x": velocity_x, "velocity_z": velocity_z, "velocity_y": velocity_y}
    device = checks.same_device(**velocity)
    checks.floats(3, **velocity)
    if place not in (0, 1, 2, CENTRE):
        raise ValueError(f"place is {place}, expected 0, 1, 2 or {CENTRE}")
    nx, nz, ny = velocity_y.shape[0], velocity_y.shape[1], velocity_x.shape[2]
    checks.shape((nx + 1, nz, ny), velocity_x=velocity_x)
    checks.shape((nx, nz + 1, ny), velocity_z=velocity_z)
    checks.shape((nx, nz, ny + 1), velocity_y=velocity_y)
    shape = (nx + (place == 0), nz + (place == 1), ny + (place == 2))
    if (nx + 1) * (nz + 1) * (ny + 1) >= 2**31:
        raise ValueError(
            f"the box has {nx} x {nz} x {ny} voxels, expected less than 2^31 in all: reduce the resolution"
        )
    out = wp.empty((3, *shape), dtype=float, device=device) if out is None else out
    checks.same_device(velocity_x=velocity_x, out=out)
    checks.floats(4, out=out)
    checks.shape((3, *shape), out=out)
    launch(
        trace_kernel,
        shape,
        [velocity_x, velocity_z, velocity_y, sides, place, time_step],
        [out],
        device,
        whole_columns=True,
    )
    return out
