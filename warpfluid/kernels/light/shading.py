"""How solid surfaces are lit: by suns, the sky, and fire in the volume, through smoke and past each other.

Vectors are (x, y, z) here, as the meshes' are; only what is read from volumes is (x, z, y).
"""

import warp as wp

from warpfluid.kernels.sampling import trilinear

wp.set_module_options({"enable_backward": False})

FAR = 1.0e6  # voxels; no ray goes further
NEAR = 0.01  # voxels that a ray to a light begins above its surface
SKY_RAYS = 12  # a sample, to tell how much of the sky the triangles hide
GOLDEN_ANGLE = 2.399963


@wp.struct
class Stage:
    """Surfaces and their light.

    Attributes:
        mesh: The triangles; 0 for none.
        normals: Of the triangles' corners, shape (3 m,).
        colors: Share of light that each triangle reflects, shape (m,).
        ground: Height of the ground, the middle (x, z) of the shown part, and its radius; a radius of 0 for none.
        ground_color: Share of light that it reflects.
        sun_directions: To each sun, unit vectors, shape (sun,).
        sun_colors: Irradiance, shape (sun,).
        shadows: Transmittance of the volume to each sun, shape (sun, x, z, y).
        ambient: Mean radiance within the volume, shape (x, z, y).
        light: The sky's part of it that was not scattered, the share of the sky that is open, and the fires' part, on a
            coarse lattice, shape (7, x, z, y).
        factor: Voxels along an edge of one of that lattice.
        sky: Harmonics of the irradiance from the sky, shape (9,).
        fires: Where fire is, and half the width of what each stands for, shape (fire,).
        fire_colors: Radiance times voxels of each, shape (fire,).
    """

    mesh: wp.uint64
    normals: wp.array[wp.vec3]
    colors: wp.array[wp.vec3]
    ground: wp.vec4
    ground_color: wp.vec3
    sun_directions: wp.array[wp.vec3]
    sun_colors: wp.array[wp.vec3]
    shadows: wp.array4d[float]
    ambient: wp.array3d[wp.vec3]
    light: wp.array4d[float]
    factor: int
    sky: wp.array[wp.vec3]
    fires: wp.array[wp.vec4]
    fire_colors: wp.array[wp.vec3]


@wp.struct
class Hit:
    """Where a ray meets a surface: distance, or -1; normals of the triangle and of the surface; colour and cover."""

    distance: float
    flat: wp.vec3
    normal: wp.vec3
    color: wp.vec3
    cover: float


@wp.func
def hidden(stage: Stage, start: wp.vec3, towards: wp.vec3, reach: float) -> bool:
    """Tell whether a triangle lies on the way."""
    if stage.mesh == wp.uint64(0):
        return False
    return wp.mesh_query_ray_anyhit(stage.mesh, start, towards, reach)


@wp.func
def through_volume(shadow: wp.array3d[float], at: wp.vec3, towards: wp.vec3) -> float:
    """Return how much of a sun's light comes through the box to a point anywhere."""
    size = wp.vec3(float(shadow.shape[0]), float(shadow.shape[2]), float(shadow.shape[1]))
    near = float(0.0)
    far = float(FAR)
    for i in range(3):
        if wp.abs(towards[i]) > 1.0e-6:
            one = (-0.5 - at[i]) / towards[i]
            other = (size[i] - 0.5 - at[i]) / towards[i]
            near = wp.max(near, wp.min(one, other))
            far = wp.min(far, wp.max(one, other))
        elif at[i] < -0.5 or at[i] > size[i] - 0.5:
            far = -1.0
    if near >= far:
        return 1.0
    entry = at + near * towards
    return trilinear(shadow, wp.vec3(entry[0], entry[2], entry[1]))


@wp.func
def from_sky(sky: wp.array[wp.vec3], n: wp.vec3) -> wp.vec3:
    """Return the irradiance from the sky; the functions are those of ``rendering/harmonics.py``."""
    total = 0.28209479 * sky[0] + 0.48860251 * (n[1] * sky[1] + n[2] * sky[2] + n[0] * sky[3])
    total += 1.09254843 * (n[0] * n[1] * sky[4] + n[1] * n[2] * sky[5] + n[0] * n[2] * sky[7])
    total += 0.31539157 * (3.0 * n[2] * n[2] - 1.0) * sky[6] + 0.54627422 * (n[0] * n[0] - n[1] * n[1]) * sky[8]
    return wp.max(total, wp.vec3())


@wp.func
def scattered_light(stage: Stage, at: wp.vec3, coarse: wp.vec3) -> wp.vec3:
    """Return the radiance within the volume that has been scattered."""
    total = wp.vec3()
    size = wp.vec3i(stage.ambient.shape[0], stage.ambient.shape[2], stage.ambient.shape[1])
    low = wp.vec3i()
    share = wp.vec3()
    for i in range(3):
        inside = wp.clamp(at[i], 0.0, float(size[i] - 1))
        low[i] = wp.min(int(inside), wp.max(size[i] - 2, 0))
        share[i] = inside - float(low[i])
    for corner in range(8):
        weight = float(1.0)
        place = wp.vec3i()
        for i in range(3):
            bit = (corner >> i) & 1
            place[i] = wp.min(low[i] + bit, size[i] - 1)
            weight *= wp.where(bit == 1, share[i], 1.0 - share[i])
        total += weight * stage.ambient[place[0], place[2], place[1]]
    for channel in range(3):
        straight = trilinear(stage.light[channel], coarse) + trilinear(stage.light[4 + channel], coarse)
        total[channel] = wp.max(total[channel] - straight, 0.0)
    return total


@wp.func
def from_around(stage: Stage, at: wp.vec3, normal: wp.vec3) -> wp.vec3:
    """Return the irradiance from the sky through the volume and from the volume; far from the box only the former."""
    size = wp.vec3(float(stage.ambient.shape[0]), float(stage.ambient.shape[2]), float(stage.ambient.shape[1]))
    beyond = wp.vec3()
    for i in range(3):
        beyond[i] = wp.max(wp.max(-0.5 - at[i], at[i] - size[i] + 0.5), 0.0)
    coarse = (wp.vec3(at[0], at[2], at[1]) + wp.vec3(0.5, 0.5, 0.5)) / float(stage.factor) - wp.vec3(0.5, 0.5, 0.5)
    far = wp.clamp(2.0 * wp.length(beyond) / wp.max(size), 0.0, 1.0)
    far = far * far * (3.0 - 2.0 * far)
    open = wp.lerp(trilinear(stage.light[3], coarse), 1.0, far)
    return open * from_sky(stage.sky, normal) + (1.0 - far) * wp.pi * scattered_light(stage, at, coarse)


@wp.func
def unhidden_sky(stage: Stage, at: wp.vec3, normal: wp.vec3, turn: float) -> float:
    """Return the share of the sky, by the cosine, that triangles leave; a spiral of rays, turned in each sample."""
    if stage.mesh == wp.uint64(0):
        return 1.0
    side = wp.vec3(1.0, 0.0, 0.0)
    if wp.abs(normal[0]) > 0.7:
        side = wp.vec3(0.0, 0.0, 1.0)
    across = wp.normalize(wp.cross(normal, side))
    along = wp.cross(normal, across)
    seen = float(0.0)
    for i in range(SKY_RAYS):
        square = (float(i) + 0.5) / float(SKY_RAYS)
        angle = GOLDEN_ANGLE * float(i) + turn
        flat = wp.cos(angle) * across + wp.sin(angle) * along
        if not hidden(stage, at, wp.sqrt(square) * flat + wp.sqrt(1.0 - square) * normal, FAR):
            seen += 1.0 / float(SKY_RAYS)
    return seen


@wp.func
def shade(stage: Stage, at: wp.vec3, hit: Hit, turn: float) -> wp.vec3:
    """Return the light that a matt surface reflects."""
    above = at + NEAR * hit.flat
    light = unhidden_sky(stage, above, hit.flat, turn) * from_around(stage, above, hit.normal)
    for k in range(stage.sun_directions.shape[0]):
        towards = stage.sun_directions[k]
        cosine = wp.dot(towards, hit.normal)
        if cosine > 0.0 and wp.dot(towards, hit.flat) > 0.0 and not hidden(stage, above, towards, FAR):
            light += cosine * through_volume(stage.shadows[k], at, towards) * stage.sun_colors[k]
    for k in range(stage.fires.shape[0]):
        fire = stage.fires[k]
        way = wp.vec3(fire[0], fire[1], fire[2]) - at
        distance = wp.length(way)
        cosine = wp.dot(way, hit.normal) / wp.max(distance, NEAR)
        if cosine > 0.0 and not hidden(stage, above, way / wp.max(distance, NEAR), wp.max(distance - fire[3], 0.0)):
            light += cosine / (distance * distance + fire[3] * fire[3]) * stage.fire_colors[k]
    return wp.cw_mul(hit.color, light) / wp.pi
