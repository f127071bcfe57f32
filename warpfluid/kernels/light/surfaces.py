"""Solid surfaces as a camera sees them: triangles and level ground. ``shading`` says how they are lit."""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import launch
from warpfluid.kernels.light.shading import FAR, Hit, Stage, shade

wp.set_module_options({"enable_backward": False})


@wp.func
def find_surface(stage: Stage, start: wp.vec3, towards: wp.vec3) -> Hit:
    """Return the first surface on a ray."""
    hit = Hit()
    hit.distance = -1.0
    if stage.mesh != wp.uint64(0):
        query = wp.mesh_query_ray(stage.mesh, start, towards, FAR)
        if query.result:
            first = 3 * query.face
            hit.distance = query.t
            hit.flat = query.normal * wp.sign(query.sign)
            smooth = query.u * stage.normals[first] + query.v * stage.normals[first + 1]
            smooth += (1.0 - query.u - query.v) * stage.normals[first + 2]
            hit.normal = wp.normalize(smooth) * wp.sign(query.sign)
            hit.color = stage.colors[query.face]
            hit.cover = 1.0
    if stage.ground[3] > 0.0 and towards[1] < 0.0:
        distance = (stage.ground[0] - start[1]) / towards[1]
        at = start + distance * towards
        away = wp.length(wp.vec2(at[0] - stage.ground[1], at[2] - stage.ground[2])) / stage.ground[3]
        fade = wp.clamp(2.0 - 2.0 * away, 0.0, 1.0)
        if distance > 0.0 and fade > 0.0 and (hit.distance < 0.0 or distance < hit.distance):
            hit.distance = distance
            hit.flat = wp.vec3(0.0, 1.0, 0.0)
            hit.normal = hit.flat
            hit.color = stage.ground_color
            hit.cover = fade * fade * (3.0 - 2.0 * fade)
    return hit


@wp.kernel
def surface_kernel(
    first_row: int,
    first_block: int,
    stage: Stage,
    camera: wp.array[wp.vec3],
    perspective: bool,
    samples: int,
    color: wp.array2d[wp.vec3],
    sums: wp.array2d[wp.vec2],
):
    """Follow the rays of a pixel's samples; the camera is eye, steps to the right and up, forward, and first pixel."""
    i, column, _ = wp.tid()
    row = first_row + i
    light = wp.vec3()
    cover = float(0.0)
    depth = float(0.0)
    share = 1.0 / float(samples * samples)
    state = wp.rand_init(7, row * color.shape[1] + column)
    for sample in range(samples * samples):
        right = float(column) + (float(sample % samples) + 0.5) / float(samples) - 0.5
        down = float(row) + (float(sample // samples) + 0.5) / float(samples) - 0.5
        across = camera[4] + right * camera[1] - down * camera[2]
        start = camera[0]
        towards = camera[3]
        if perspective:
            towards = wp.normalize(towards + across)
        else:
            start += across
        hit = find_surface(stage, start, towards)
        turn = 6.2831853 * wp.randf(state)
        if hit.distance >= 0.0:
            light += share * hit.cover * shade(stage, start + hit.distance * towards, hit, turn)
            depth += share * hit.cover * hit.distance * wp.dot(towards, camera[3])
            cover += share * hit.cover
    color[row, column] = light
    sums[row, column] = wp.vec2(cover, depth)


def see_surfaces(
    stage: Stage,
    camera: wp.array[wp.vec3],
    *,
    perspective: bool,
    samples: int,
    color: wp.array2d[wp.vec3],
    sums: wp.array2d[wp.vec2],
) -> None:
    """Render surfaces.

    Args:
        stage: The surfaces and their light.
        camera: Eye, a pixel's step to the right and up, forward, and the way from the middle of the picture to its
            first pixel, at distance 1 for perspective, shape (5,).
        perspective: Whether rays meet in the eye.
        samples: Samples a pixel and axis.
        color: Light of what is covered, to write, shape (rows, columns).
        sums: Share of the pixel that is covered, and the depth along forward times that share, to write.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    device = checks.same_device(camera=camera, color=color, sums=sums)
    checks.typed(wp.vec3, 1, camera=camera)
    checks.typed(wp.vec3, 2, color=color)
    checks.typed(wp.vec2, 2, sums=sums)
    checks.shape((5,), camera=camera)
    checks.same_shape(color=color, sums=sums)
    if samples < 1:
        raise ValueError(f"samples is {samples}, expected 1 or more")
    launch(surface_kernel, (*color.shape, 1), [stage, camera, perspective, samples], [color, sums], device)
