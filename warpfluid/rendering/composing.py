"""A volume and solid things in one picture."""

from collections.abc import Sequence

import numpy as np

from warpfluid.rendering.camera import Camera
from warpfluid.rendering.fires import find_fires
from warpfluid.rendering.lighting import Lighting
from warpfluid.rendering.marching import ERROR, march
from warpfluid.rendering.medium import Medium
from warpfluid.rendering.picture import Picture
from warpfluid.rendering.shadows import InnerLight
from warpfluid.rendering.surfaces import Ground, Seen, Surface, see


def render(
    medium: Medium,
    camera: Camera,
    lighting: Lighting,
    inner: InnerLight | None = None,
    *,
    surfaces: Sequence[Surface] = (),
    ground: Ground | None = None,
    error: float = ERROR,
    density: bool = True,
    interpolation: str = "linear",
) -> Picture:
    """Render a medium with solid things in it.

    Pixels at their edges are marched twice, to the surface and past it.

    Args:
        medium: What fills the volume.
        camera: Where it is seen from.
        lighting: The suns and the sky.
        inner: Light within the volume, of ``light_volume``; without it the medium only glows, and casts no shadow.
        surfaces: Bodies.
        ground: The ground, if it shows.
        error: As for ``march``.
        density: As for ``march``.
        interpolation: As for ``march``.
    """
    light = {"lighting": lighting} if inner is None else {"lighting": lighting, **inner.for_march()}
    options = light | {"error": error, "density": density, "interpolation": interpolation}
    if not surfaces and ground is None:
        return march(medium, camera, **options)
    device = next(iter(medium.fields.values())).device
    fires = inner.fires if inner else find_fires(medium)
    seen = see(surfaces, camera, lighting, ground=ground, inner=inner, fires=fires, device=device)
    near = march(medium, camera, limits=seen.depth, **options)
    edge = (seen.cover > 0) & (seen.cover < 1)
    past = march(medium, camera, limits=np.where(edge, np.inf, 0), **options) if edge.any() else near
    return _mix(near, past, seen)


def _mix(near: Picture, past: Picture, seen: Seen) -> Picture:
    """Put surfaces between what is in front of them and, at their edges, what is past them."""
    cover = seen.cover
    share = np.where(cover < 1, np.where(cover > 0, cover, 1), 1)[..., None]  # of the ray that ends
    mixed = {name: share * getattr(near, name) + (1 - share) * getattr(past, name) for name in ("color", "emission")}
    mixed["color"] += (1 - near.alpha[..., None]) * seen.color
    share = share[..., 0]
    alpha = np.where(cover > 0, cover + (1 - cover) * past.alpha, near.alpha)
    hidden = (cover >= 0.5) & (near.alpha < 0.5)
    return Picture(
        **mixed,
        alpha=alpha,
        depth=np.where(hidden, seen.depth, near.depth),
        density=share * near.density + (1 - share) * past.density,
    )
