"""March rays through a medium that gives off, hides and scatters light: one pixel a thread, one ray a pixel.

``reading`` says what a ray meets, ``ray`` how it goes on. Bricks with nothing to meet are skipped: no bit changes.
"""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import launch
from warpfluid.kernels.light.bricks import BRICK
from warpfluid.kernels.light.ray import CAMERA, DARK, ERRORS, GEOMETRY, HALF_WAY, HALVE, PASS
from warpfluid.kernels.light.reading import MEET, MOST_SUNS, PLACE

wp.set_module_options({"enable_backward": False})

CURVES = ("extinction", "emission", "albedo")
OPTIONAL = (*CURVES, "suns", "shadows", "ambient", "limits")
OPAQUE = 1 / 16  # of the tolerance: less than this of the light behind is not followed

MARCH = (
    GEOMETRY
    + PLACE
    + MEET
    + PASS
    + ERRORS
    + HALVE
    + HALF_WAY
    + DARK
    + f"""
    Sample start = near > nearest ? Sample{{from}} : meet(from);
    int known = 0;
    for (double q = from; near < far && way * (to - q) > 0.0;) {{
        const double plane = way > 0 ? wp::floor(q) : wp::ceil(q);
        if (--known < 0 && dark(q, known)) {{
            q = plane + way * known;
            start = {{way * (to - q) < 0.0 ? to : q}};
            known = 0;
            mark(q);
            continue;
        }}
        q = plane + way;
        if (way * (to - q) < 0.0) q = to;
        const bool opaque = open < {OPAQUE} * scene.error;
        if (opaque && scene.density_field < 0) break;
        const Sample end = meet(q);
        density_sum += 0.5f * length * (float)wp::abs(q - start.q) * (start.density + end.density);
        const float met = start.extinction + end.extinction + start.light[0] + start.light[1] + start.light[2]
            + end.light[0] + end.light[1] + end.light[2];
        const bool split = scene.adapt && !opaque && may_err(start, end) > bound();
        if (split)
            halve(start, end);
        else if (met > 0.0f)
            pass(start, end);
        if (split || met > 0.0f || total == 0.0f) mark(q);
        start = end;
    }}
    const size_t pixel = (size_t)row * width + column;
    for (int c = 0; c < 3; ++c) color.data[3 * pixel + c] = seen[c], emission.data[3 * pixel + c] = glow[c];
    sums.data[3 * pixel] = hidden;
    sums.data[3 * pixel + 1] = total > 0.0f ? (float)half_way() : -1.0f;
    sums.data[3 * pixel + 2] = density_sum;
"""
)


@wp.struct
class Scene:
    """What the rays meet, and what is asked about it.

    Attributes:
        camera: Eye, right, up and forward, each (x, z, y), then pixel, shift right and up, and 1 for perspective.
        f0: A field, shape (x, z, y); f1 to f3 are others, or the same again.
        field_count: How many of them differ.
        cubic: They are read cubically, not linearly.
        density_field: Which of them is summed up unattenuated; -1 for none.
        extinction: Entries of the curve [1/voxel], shape (n, 1); none for no extinction.
        emission: Light given off [1/voxel], shape (n, 3), or none.
        albedo: Share of the lost light that is scattered, shape (n, 3), or none.
        reads: Which field each of the three curves reads.
        times: Which field multiplies it, or -1.
        per_entry: Entries a unit of the field.
        bricks: The most extinction or light in each brick of voxels [1/voxel], 0 where there is nothing to meet.
        suns: Direction to each sun (x, z, y) and its colour, shape (sun, 6).
        shadows: Transmittance to each, shape (sun, x, z, y), or none.
        ambient: Mean radiance from elsewhere, shape (x, z, y), or none.
        limits: Depth at which each ray ends, or none.
        anisotropy: g of the phase function.
        edge_fade: Voxels over which the medium begins at the sides.
        error: What a pixel may be wrong by.
        adapt: Whether intervals may be halved.
        clear: Nothing is met where all fields are 0.
    """

    camera: wp.array[wp.float64]
    f0: wp.array3d[float]
    f1: wp.array3d[float]
    f2: wp.array3d[float]
    f3: wp.array3d[float]
    field_count: int
    cubic: bool
    density_field: int
    extinction: wp.array2d[float]
    emission: wp.array2d[float]
    albedo: wp.array2d[float]
    reads: wp.vec3i
    times: wp.vec3i
    per_entry: wp.vec3
    bricks: wp.array3d[float]
    suns: wp.array2d[float]
    shadows: wp.array4d[float]
    ambient: wp.array3d[wp.vec3]
    limits: wp.array2d[float]
    anisotropy: wp.float64
    edge_fade: wp.float64
    error: float
    adapt: bool
    clear: bool


@wp.func_native(snippet=MARCH)
def march_ray(
    row: int,
    column: int,
    scene: Scene,
    color: wp.array3d[float],
    emission: wp.array3d[float],
    sums: wp.array3d[float],
):
    """Follow the ray of a pixel."""


@wp.kernel
def march_kernel(
    first_row: int,
    first_block: int,
    scene: Scene,
    color: wp.array3d[float],
    emission: wp.array3d[float],
    sums: wp.array3d[float],
):
    """Follow the rays of a row of pixels."""
    i, column, j = wp.tid()
    if first_block + j == 0:
        march_ray(first_row + i, column, scene, color, emission, sums)


def march_rays(scene: Scene, *, color: wp.array3d[float], emission: wp.array3d[float], sums: wp.array3d[float]) -> None:
    """Render a picture.

    Args:
        scene: What the rays meet.
        color: Light of each pixel to write, shape (rows, columns, 3), the top row first.
        emission: The part of it that the medium gives off.
        sums: Opacity, depth or -1 where there is nothing, and the sum of the density.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    device = _check(scene, color, emission, sums)
    launch(march_kernel, (*color.shape[:2], 1), [scene], [color, emission, sums], device, whole_columns=True)


def _check(scene: Scene, color: wp.array, emission: wp.array, sums: wp.array) -> wp.Device:
    """Check all arrays of a scene and return their device."""
    pictures = {"color": color, "emission": emission, "sums": sums}
    fields = {name: getattr(scene, name) for name in ("f0", "f1", "f2", "f3")}
    given = {name: array for name in OPTIONAL if (array := getattr(scene, name)) is not None}
    curves = {f"curve of {name}": given.pop(name) for name in CURVES if name in given}
    device = checks.same_device(**pictures, camera=scene.camera, bricks=scene.bricks, **fields, **curves, **given)
    checks.floats(3, bricks=scene.bricks, **pictures, **fields)
    checks.floats(2, **curves)
    checks.typed(wp.float64, 1, camera=scene.camera)
    checks.same_shape(**fields)
    checks.shape((*color.shape[:2], 3), **pictures)
    checks.shape((CAMERA,), camera=scene.camera)
    checks.shape(tuple(-(-n // BRICK) for n in scene.f0.shape), bricks=scene.bricks)
    _check_light(given, scene.f0.shape, color.shape)
    for name, curve in curves.items():
        channels = 1 if name.endswith("extinction") else 3
        if curve.shape[0] < 1 or curve.shape[1] != channels:
            raise ValueError(f"{name} has shape {curve.shape}, expected (n, {channels})")
    return device


def _check_light(light: dict[str, wp.array], volume: tuple[int, ...], picture: tuple[int, ...]) -> None:
    """Check what is given of suns, shadows, ambient light and limits."""
    if "shadows" in light:
        suns = light["shadows"].shape[0]
        if suns > MOST_SUNS or "suns" not in light:
            raise ValueError(f"shadows are of {suns} suns, expected at most {MOST_SUNS}, and the suns with them")
        checks.floats(4, shadows=light["shadows"])
        checks.floats(2, suns=light["suns"])
        checks.shape((suns, *volume), shadows=light["shadows"])
        checks.shape((suns, 6), suns=light["suns"])
    if "ambient" in light:
        checks.typed(wp.vec3, 3, ambient=light["ambient"])
        checks.shape(volume, ambient=light["ambient"])
    if "limits" in light:
        checks.floats(2, limits=light["limits"])
        checks.shape(picture[:2], limits=light["limits"])
