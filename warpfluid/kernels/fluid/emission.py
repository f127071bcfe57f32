"""Let in density, fuel, heat and motion where an emitter is, flickering with a noise that moves on in time."""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import CPU_RUN, CUDA_RUN, elementwise, launch

wp.set_module_options({"enable_backward": False})

SECOND_OCTAVE = 0.5  # amplitude of noise at twice the frequency
FULL = 1.6  # brings the noise's usual swing to -1..1


@wp.func
def flicker(seed: int, at: wp.vec3, phase: float, amount: float) -> float:
    """Return a factor around 1 from two octaves of Perlin noise, never negative while the amount is at most 1."""
    state = wp.rand_init(seed)
    coarse = wp.noise(state, wp.vec4(at[0], at[1], at[2], phase))
    fine = wp.noise(state + wp.uint32(1), wp.vec4(2.0 * at[0], 2.0 * at[1], 2.0 * at[2], 2.0 * phase))
    return 1.0 + amount * wp.clamp(FULL * (coarse + SECOND_OCTAVE * fine), -1.0, 1.0)


@wp.kernel
def cover_kernel(share: wp.array[float], factor: float, out: wp.array[float]):
    """Turn the share outside into the share inside."""
    i = wp.tid()
    out[i] = factor * (1.0 - share[i])


@wp.kernel
def soften_kernel(distance: wp.array[float], width: float, out: wp.array[float]):
    """Rise smoothly from 0 to 1 on the way in, half at the surface."""
    i = wp.tid()
    t = wp.clamp(0.5 - distance[i] / width, 0.0, 1.0)
    out[i] = t * t * (3.0 - 2.0 * t)


@wp.kernel
def let_in_kernel(
    first_row: int,
    first_block: int,
    weight: wp.array3d[float],
    first: wp.vec3i,
    added: wp.vec2,
    hot: float,
    noise: wp.vec3,
    seed: int,
    run: int,
    density: wp.array3d[float],
    fuel: wp.array3d[float],
    temperature: wp.array3d[float],
):
    """Add density and fuel, and hold the temperature; noise is its amount, frequency and phase."""
    row, column, block = wp.tid()
    i = first_row + row
    begin = (first_block + block) * run
    for k in range(begin, wp.min(begin + run, weight.shape[2])):
        share = weight[i, column, k]
        if share > 0.0:
            x = first[0] + i
            z = first[1] + column
            y = first[2] + k
            factor = float(1.0)
            if noise[0] > 0.0:
                factor = flicker(seed, noise[1] * wp.vec3(float(x), float(z), float(y)), noise[2], noise[0])
            density[x, z, y] += factor * share * added[0]
            fuel[x, z, y] += factor * share * added[1]
            held = wp.min(factor, 1.0) * wp.min(share, 1.0) * hot
            now = temperature[x, z, y]
            temperature[x, z, y] = wp.where(hot >= 0.0, wp.max(now, held), wp.min(now, held))


@wp.kernel
def drive_kernel(
    first_row: int,
    first_block: int,
    weight: wp.array3d[float],
    first: wp.vec3i,
    axis: int,
    target: float,
    rate: float,
    heights: int,
    run: int,
    velocity: wp.array3d[float],
):
    """Draw the faces of a block towards a velocity; a face has the mean weight of its two voxels."""
    row, j, block = wp.tid()
    i = first_row + row
    begin = (first_block + block) * run
    step = wp.vec3i(int(axis == 0), int(axis == 1), int(axis == 2))
    for k in range(begin, wp.min(begin + run, heights)):
        share = float(0.0)
        if i < weight.shape[0] and j < weight.shape[1] and k < weight.shape[2]:
            share = 0.5 * weight[i, j, k]
        if i >= step[0] and j >= step[1] and k >= step[2]:
            share += 0.5 * weight[i - step[0], j - step[1], k - step[2]]
        x = first[0] + i
        z = first[1] + j
        y = first[2] + k
        at = step[0] * x + step[1] * z + step[2] * y
        if share > 0.0 and at > 0 and at < velocity.shape[axis] - 1:
            now = velocity[x, z, y]
            velocity[x, z, y] = target + (now - target) * wp.exp(-rate * share)


def cover(share: wp.array, *, factor: float = 1.0) -> wp.array:
    """Turn shares that lie outside into shares that lie inside times a factor, in place."""
    return elementwise(cover_kernel, [share, factor], share)


def soften(distance: wp.array, *, width: float) -> wp.array:
    """Turn signed distances into weights that rise from 0 to 1 over a width around the surface, in place."""
    return elementwise(soften_kernel, [distance, width], distance)


def let_in(
    weight: wp.array3d[float],
    density: wp.array3d[float],
    fuel: wp.array3d[float],
    temperature: wp.array3d[float],
    *,
    first: tuple[int, int, int],
    added: tuple[float, float],
    hot: float,
    noise: tuple[float, float, float] = (0.0, 0.0, 0.0),
    seed: int = 0,
) -> None:
    """Add density and fuel and hold the temperature in a block of voxels, in place.

    Args:
        weight: Share of each voxel of the block that emits.
        density: Shape (x, z, y).
        fuel: The same shape.
        temperature: The same shape; raised to ``hot`` times the weight where it is lower (lowered to it if
            ``hot`` is negative), so that it does not matter how often a second is cut into steps.
        first: First voxel (x, z, y) of the block.
        added: Density and fuel added to a voxel of weight 1.
        hot: Temperature.
        noise: Amount from 0 to 1, frequency [cycle/voxel] and phase [cycle] of the flicker.
        seed: Which noise.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    fields = {"density": density, "fuel": fuel, "temperature": temperature}
    device = checks.same_device(weight=weight, **fields)
    checks.floats(3, weight=weight, **fields)
    checks.same_shape(**fields)
    checks.block(first, weight.shape, **fields)
    run = CUDA_RUN if device.is_cuda else CPU_RUN
    inputs = [weight, wp.vec3i(*first), wp.vec2(*added), hot, wp.vec3(*noise), seed, run]
    launch(let_in_kernel, weight.shape, inputs, [density, fuel, temperature], device)


def drive(
    weight: wp.array3d[float],
    velocity: wp.array3d[float],
    *,
    axis: int,
    first: tuple[int, int, int],
    target: float,
    rate: float,
) -> None:
    """Draw one component of the velocity towards a target in a block, in place; the grid's outermost faces stay.

    Args:
        weight: Share of each voxel of the block that emits.
        velocity: Component at the faces across the axis [voxel/s].
        axis: 0 is x, 1 is z, 2 is y.
        first: First voxel (x, z, y) of the block.
        target: [voxel/s].
        rate: Rate times time step; the difference falls by its exponential.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    device = checks.same_device(weight=weight, velocity=velocity)
    checks.floats(3, weight=weight, velocity=velocity)
    faces = tuple(n + (k == axis) for k, n in enumerate(weight.shape))
    checks.block(first, faces, velocity=velocity)
    run = CUDA_RUN if device.is_cuda else CPU_RUN
    inputs = [weight, wp.vec3i(*first), axis, target, rate, faces[2], run]
    launch(drive_kernel, faces, inputs, [velocity], device)
