"""What lamps within a volume send to each voxel: fire that lights the smoke around it."""

import math

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import CPU_RUN, CUDA_RUN, launch
from warpfluid.kernels.sampling import trilinear

wp.set_module_options({"enable_backward": False})

MOST_STEPS = 64


@wp.func
def light_of_lamp(extinction: wp.array3d[float], at: wp.vec3, lamp: wp.vec4, spacing: float) -> float:
    """Return the mean radiance from a ball of light of intensity 1; what hides it lies between here and the ball."""
    way = wp.vec3(lamp[0], lamp[1], lamp[2]) - at
    distance = wp.length(way)
    outside = wp.max(distance - lamp[3], 0.0)
    depth = float(0.0)
    if outside > 0.0:
        steps = wp.clamp(int(wp.ceil(outside)), 1, MOST_STEPS)
        step = outside / (distance * float(steps)) * way
        for j in range(steps):
            depth += trilinear(extinction, at + (float(j) + 0.5) * step)
        depth *= spacing * outside / float(steps)
    square = spacing * spacing * (distance * distance + lamp[3] * lamp[3])
    return wp.exp(-depth) / (4.0 * wp.pi * square)


@wp.kernel
def lamp_kernel(
    first_row: int,
    first_block: int,
    extinction: wp.array3d[float],
    places: wp.array[wp.vec4],
    colors: wp.array[wp.vec3],
    spacing: float,
    run: int,
    out: wp.array4d[float],
):
    """Add up the lamps at each voxel."""
    i, z, j = wp.tid()
    x = first_row + i
    begin = (first_block + j) * run
    for y in range(begin, wp.min(begin + run, extinction.shape[2])):
        total = wp.vec3()
        for k in range(places.shape[0]):
            at = wp.vec3(float(x), float(z), float(y))
            total += light_of_lamp(extinction, at, places[k], spacing) * colors[k]
        for channel in range(3):
            out[channel, x, z, y] = total[channel]


def light_of_lamps(
    extinction: wp.array3d[float], places: wp.array[wp.vec4], colors: wp.array[wp.vec3], *, spacing: float = 1.0
) -> wp.array4d[float]:
    """Return the mean radiance that lamps send to each voxel.

    Args:
        extinction: Shape (x, z, y).
        places: Of the lamps (x, z, y), and their radii [voxel], shape (n,).
        colors: Their radiant intensities, shape (n,).
        spacing: Edge of a voxel, in the unit of length that extinction and intensity are said for.

    Returns:
        Red, green and blue, shape (3, x, z, y).

    Raises:
        ValueError: If shapes, types or devices do not fit, or ``spacing`` is not above 0.
    """
    device = checks.same_device(extinction=extinction, places=places, colors=colors)
    checks.floats(3, extinction=extinction)
    checks.typed(wp.vec4, 1, places=places)
    checks.typed(wp.vec3, 1, colors=colors)
    checks.shape(places.shape, colors=colors)
    if not 0 < spacing < math.inf:
        raise ValueError(f"spacing is {spacing}, expected a length above 0")
    out = wp.empty((3, *extinction.shape), dtype=float, device=device)
    run = CUDA_RUN if device.is_cuda else CPU_RUN
    launch(lamp_kernel, extinction.shape, [extinction, places, colors, spacing, run], [out], device)
    return out
