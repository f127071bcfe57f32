"""Light that reaches a voxel from all around, and how often it is scattered there.

Light that is scattered at a voxel leaves the volume with the probability P, the mean transmittance over all directions,
or meets matter again, nearby, where the light is much the same. If that goes on, a mean incoming radiance of J, before
any scattering, becomes ``J / (1 - albedo (1 - P))``: the closure of Lucy et al. (1991) and of Varosi and Dwek (1999).
In uniform light of radiance L, J is P L, so with an albedo of 1 the light within is L everywhere, which is exact. For
suns and fires the gain is held to that deep in a half-space (Chandrasekhar 1960): P knows not what leaves their way.
"""

import math

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import CPU_RUN, CUDA_RUN, launch
from warpfluid.kernels.light.curves import place_on_curve
from warpfluid.kernels.sampling import coarse_place, coarse_shape, trilinear

wp.set_module_options({"enable_backward": False})

MOST_GAIN = 5.0  # of a sun's light: what matter without end that absorbs nothing comes to, sqrt(3) H(1) = 5.04
DARK = 1e-30  # P below this cannot be told from 0; nothing from there is ever seen


@wp.kernel
def add_light_kernel(
    first_row: int,
    first_block: int,
    transmittance: wp.array3d[float],
    weight: float,
    radiance: wp.vec3,
    run: int,
    light: wp.array4d[float],
):
    """Add what comes from a direction, and the share of directions that are open."""
    i, z, j = wp.tid()
    x = first_row + i
    begin = (first_block + j) * run
    for y in range(begin, wp.min(begin + run, transmittance.shape[2])):
        share = weight * transmittance[x, z, y]
        for channel in range(3):
            light[channel, x, z, y] += share * radiance[channel]
        light[3, x, z, y] += share


@wp.kernel
def scatter_again_kernel(
    first_row: int,
    first_block: int,
    light: wp.array4d[float],
    factor: int,
    field: wp.array3d[float],
    albedo: wp.array[wp.vec3],
    top: float,
    suns: wp.array4d[float],
    irradiance: wp.array[wp.vec3],
    run: int,
    out: wp.array3d[wp.vec3],
):
    """Let the light from all around and that of the suns be scattered until it escapes or is absorbed."""
    i, z, j = wp.tid()
    x = first_row + i
    begin = (first_block + j) * run
    last = albedo.shape[0] - 1
    for y in range(begin, wp.min(begin + run, out.shape[2])):
        at = place_on_curve(field[x, z, y], last, top)
        below = int(at)
        kept = wp.lerp(albedo[below], albedo[wp.min(below + 1, last)], at - float(below))
        place = coarse_place(x, z, y, factor)
        escape = wp.clamp(trilinear(light[3], place), DARK, 1.0)
        total = wp.vec3()
        leaving = wp.max(escape, 1.0 / MOST_GAIN)
        for channel in range(3):
            sky = wp.max(trilinear(light[channel], place), 0.0)
            fire = wp.max(trilinear(light[4 + channel], place), 0.0)
            total[channel] = sky / (1.0 - kept[channel] + kept[channel] * escape)
            total[channel] += fire / (1.0 - kept[channel] + kept[channel] * leaving)
        for k in range(suns.shape[0]):
            arriving = suns[k, x, z, y]
            leaving = wp.max(escape, arriving / MOST_GAIN)
            for channel in range(3):
                again = kept[channel] * (1.0 - leaving) / (1.0 - kept[channel] + kept[channel] * leaving)
                total[channel] += irradiance[k][channel] * arriving * again / (4.0 * wp.pi)
        out[x, z, y] = total


def add_light(
    transmittance: wp.array3d[float], *, weight: float, radiance: tuple[float, float, float], light: wp.array4d[float]
) -> None:
    """Add the light of one of the directions that stand for all, in place.

    Args:
        transmittance: From each voxel into the direction, shape (x, z, y).
        weight: Share of all directions that this one stands for.
        radiance: Red, green and blue from there.
        light: Mean radiance of the sky, share of open directions, and what is not touched, shape (7, x, z, y).

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    device = checks.same_device(transmittance=transmittance, light=light)
    checks.floats(3, transmittance=transmittance)
    checks.floats(4, light=light)
    checks.shape((7, *transmittance.shape), light=light)
    run = CUDA_RUN if device.is_cuda else CPU_RUN
    inputs = [transmittance, weight, wp.vec3(*map(float, radiance)), run]
    launch(add_light_kernel, transmittance.shape, inputs, [light], device)


def scatter_again(
    light: wp.array4d[float],
    field: wp.array3d[float],
    albedo: wp.array[wp.vec3],
    suns: wp.array4d[float],
    irradiance: wp.array[wp.vec3],
    *,
    factor: int,
    top: float,
) -> wp.array3d[wp.vec3]:
    """Return mean incoming radiance with all scattering, but for what comes straight from the suns.

    Args:
        light: Sum of ``add_light`` and mean radiance of fires on a lattice coarser than the field, shape (7, x, z, y).
        field: What the albedo depends on, shape (x, z, y).
        albedo: Curve over the field, shape (n,).
        suns: Transmittance to each sun, shape (sun, x, z, y); there may be none.
        irradiance: Of each sun, shape (sun,).
        factor: Voxels of the field along an edge of one of the light's.
        top: Field value of the curve's last entry.

    Returns:
        Radiance, shape (x, z, y).

    Raises:
        ValueError: If shapes, types or devices do not fit, or ``top`` is not above 0.
    """
    device = checks.same_device(light=light, field=field, albedo=albedo, suns=suns, irradiance=irradiance)
    checks.floats(3, field=field)
    checks.floats(4, light=light, suns=suns)
    checks.typed(wp.vec3, 1, albedo=albedo, irradiance=irradiance)
    checks.shape((*irradiance.shape, *field.shape), suns=suns)
    if not (factor >= 1 and 0 < top < math.inf and albedo.size):
        raise ValueError(f"factor is {factor}, top {top} and albedo has {albedo.size} entries: all must be above 0")
    checks.shape((7, *coarse_shape(field.shape, factor)), light=light)
    out = wp.empty(field.shape, dtype=wp.vec3, device=device)
    run = CUDA_RUN if device.is_cuda else CPU_RUN
    inputs = [light, factor, field, albedo, top, suns, irradiance, run]
    launch(scatter_again_kernel, field.shape, inputs, [out], device)
    return out
