"""Pictures of a medium: rays are marched through what glows, hides and scatters light."""

import numpy as np
import warp as wp

from warpfluid.kernels.light.bricks import OVERLAP, brick_maxima
from warpfluid.kernels.light.march import CURVES, Scene, march_rays
from warpfluid.rendering.camera import Camera
from warpfluid.rendering.lighting import Lighting
from warpfluid.rendering.medium import Curve, Medium
from warpfluid.rendering.picture import Picture

ERROR = 1 / 512
MOST_FIELDS = 4
INTERPOLATIONS = ("linear", "cubic")
OVERSHOOT = 1.48  # of the greatest voxel, that cubic interpolation may reach between voxels, at most


def march(
    medium: Medium,
    camera: Camera,
    *,
    shadows: wp.array | None = None,
    ambient: wp.array | None = None,
    lighting: Lighting | None = None,
    limits: np.ndarray | None = None,
    error: float = ERROR,
    density: bool = True,
    interpolation: str = "linear",
) -> Picture:
    """Render a medium.

    A medium that only glows, by a curve that is one straight line, gives the projector's ``joseph`` ray sums.

    Args:
        medium: What fills the volume; its arrays say on which device the picture is made.
        camera: Where it is seen from.
        shadows: Transmittance from each voxel to each sun of ``lighting``, shape (sun, x, z, y).
        ambient: Mean radiance that arrives at each voxel from elsewhere, (x, z, y) vectors of red, green and blue.
        lighting: The suns that ``shadows`` is about.
        limits: How far along the camera's forward solid surfaces end the rays [voxel], infinity where there is none,
            shape (rows, columns).
        error: What a pixel may be wrong by, as a share of the greater of 1 and its brightness; in less
            than one pixel in a hundred it is up to twice as much.
        density: Sum up the density as well, also behind what is opaque.
        interpolation: How fields are read between voxels: ``linear``, or ``cubic``, which shows no voxels close up.

    Raises:
        ValueError: If a field is not finite, or shapes, devices or numbers do not fit.
    """
    if not 0 < error <= 1:
        raise ValueError(f"error is {error}, expected a number above 0, at most 1")
    if interpolation not in INTERPOLATIONS:
        raise ValueError(f"interpolation is {interpolation!r}, expected {' or '.join(INTERPOLATIONS)}")
    scene, device = Scene(), next(iter(medium.fields.values())).device
    scene.cubic = interpolation == "cubic"
    _set_medium(scene, medium, density, device)
    _set_light(scene, shadows, ambient, lighting, device)
    scene.camera = wp.array(_numbers(camera), dtype=wp.float64, device=device)
    scene.error = error
    rows, columns = camera.size[1], camera.size[0]
    if limits is not None:
        if np.shape(limits) != (rows, columns) or np.isnan(limits).any():
            raise ValueError(f"limits have shape {np.shape(limits)}, expected {(rows, columns)} numbers")
        near = np.minimum(limits, np.float32(1e30)).astype(np.float32)
        scene.limits = wp.array(near, dtype=float, device=device)
    color, emission, sums = (wp.empty((rows, columns, 3), dtype=float, device=device) for _ in range(3))
    march_rays(scene, color=color, emission=emission, sums=sums)
    alpha, depth, total = np.moveaxis(sums.numpy(), 2, 0)
    return Picture(color.numpy(), alpha.copy(), np.where(depth < 0, np.inf, depth), total.copy(), emission.numpy())


def _set_medium(scene: Scene, medium: Medium, density: bool, device: wp.Device) -> None:
    """Fill in the fields that are read, their curves, and where there is something to meet."""
    curves = [getattr(medium, name) for name in CURVES]
    names = [name for curve in curves if curve for name in (curve.field, curve.times) if name]
    names += ["density"] if density and "density" in medium.fields else []
    names = list(dict.fromkeys(names)) or [next(iter(medium.fields))]
    if len(names) > MOST_FIELDS:
        raise ValueError(f"the medium's curves read the fields {', '.join(names)}; {MOST_FIELDS} are the most")
    fields = [medium.fields[name] for name in names]
    scene.f0, scene.f1, scene.f2, scene.f3 = (fields + fields[:1] * MOST_FIELDS)[:MOST_FIELDS]
    scene.field_count = len(fields)
    scene.density_field = names.index("density") if density and "density" in names else -1
    for name, curve in zip(CURVES, curves, strict=True):
        if curve:
            entries = curve.values.reshape(len(curve.values), -1)
            entries = entries if name == "extinction" else np.broadcast_to(entries, (len(entries), 3))
            setattr(scene, name, wp.array(np.ascontiguousarray(entries), dtype=float, device=device))
    scene.reads = wp.vec3i([names.index(curve.field) if curve else 0 for curve in curves])
    scene.times = wp.vec3i([names.index(curve.times) if curve and curve.times else -1 for curve in curves])
    scene.per_entry = wp.vec3([(len(curve.values) - 1) / curve.top if curve else 0.0 for curve in curves])
    fields = dict(zip(names, fields, strict=True))
    scene.bricks = _bricks(medium, fields, density=scene.density_field >= 0, cubic=scene.cubic, device=device)
    scene.clear = not any(curve.values[0].any() for curve in (medium.extinction, medium.emission) if curve)
    scene.anisotropy, scene.edge_fade = medium.anisotropy, medium.edge_fade
    scene.adapt = medium.extinction is not None or (medium.emission is not None and not _is_straight(medium.emission))


def _set_light(scene: Scene, shadows, ambient, lighting: Lighting | None, device: wp.Device) -> None:
    """Fill in the light that arrives."""
    scene.ambient = ambient
    if shadows is not None:
        suns = lighting.suns if lighting else ()
        if len(suns) != shadows.shape[0]:
            raise ValueError(f"shadows are of {shadows.shape[0]} suns, but lighting has {len(suns)}")
        numbers = [[*sun.direction[[0, 2, 1]], *sun.color] for sun in suns]
        if numbers:
            scene.shadows = shadows
            scene.suns = wp.array(np.array(numbers), dtype=float, device=device)


def _bricks(medium: Medium, fields: dict[str, wp.array], *, density: bool, cubic: bool, device: wp.Device) -> wp.array:
    """Return the most extinction or light [1/voxel] that there may be in each brick, 0 where nothing is met."""
    overlap, factor = (OVERLAP + 1, OVERSHOOT) if cubic else (OVERLAP, 1)
    most = {name: factor * brick_maxima(field, overlap=overlap).numpy() for name, field in fields.items()}
    for name, values in most.items():
        if not np.isfinite(values).all():
            raise ValueError(f"the field {name} is not finite everywhere: it holds NaN or infinity")
    tiny = np.finfo(np.float32).tiny  # the sum of the density asks for no care between the planes
    met = tiny * (most["density"] > 0) if density else np.zeros(next(iter(most.values())).shape)
    for curve in (medium.extinction, medium.emission):
        if curve:
            times = most[curve.times] if curve.times else 1.0
            met = np.maximum(met, _most(curve, most[curve.field]) * times)
    return wp.array(met, dtype=float, device=device)


def _most(curve: Curve, field: np.ndarray) -> np.ndarray:
    """Return the greatest value of a curve between 0 and a field's value, to the next entry, without ``times``."""
    so_far = np.maximum.accumulate(curve.values.reshape(len(curve.values), -1).max(axis=1))
    last = len(so_far) - 1
    return so_far[np.minimum(np.ceil(field * (last / curve.top) * (1 + 1e-6)), last).astype(int)]


def _is_straight(curve: Curve) -> bool:
    """Tell whether a curve is one line from 0, and so its sum along a ray the sum of the field."""
    return len(curve.values) <= 2 and curve.times is None


def _numbers(camera: Camera) -> np.ndarray:
    """Return a camera as the kernel takes it, vectors in the order of arrays (x, z, y)."""
    vectors = [vector[[0, 2, 1]] for vector in (camera.eye, camera.right, camera.up, camera.forward)]
    return np.concatenate([*vectors, [camera.pixel, *camera.shift, float(camera.perspective)]])
