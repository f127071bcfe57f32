"""How the light around a volume reaches its inside: shadows of the suns, and what comes from the sky and is scattered.

The sky is gathered from 14 directions, which integrate every polynomial up to order 5 exactly (Lebedev's rule of degree
5), on a coarse lattice, for such light changes slowly. See ``kernels/light/scattered.py`` for what becomes of it.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
import warp as wp

from warpfluid.kernels.coarsen import coarsen, refine
from warpfluid.kernels.light.curves import look_up
from warpfluid.kernels.light.lamps import light_of_lamps
from warpfluid.kernels.light.scattered import add_light, scatter_again
from warpfluid.kernels.light.shadow import shadow
from warpfluid.kernels.sampling import coarse_shape
from warpfluid.rendering.fires import Fires, find_fires
from warpfluid.rendering.harmonics import radiance
from warpfluid.rendering.lighting import Lighting, Sun
from warpfluid.rendering.medium import Curve, Medium

SHADOW_VOXELS = 3 << 20  # shadows of larger volumes are found on a lattice half as fine
SKY_VOXELS = 3 << 19
FIRE_VOXELS = 1 << 17
SIDES = [sign * np.eye(3)[axis] for axis in range(3) for sign in (-1, 1)]
CORNERS = [np.array(corner) / np.sqrt(3) for corner in product((-1, 1), repeat=3)]
AROUND = [(side, 1 / 15) for side in SIDES] + [(corner, 3 / 40) for corner in CORNERS]  # (x, y, z) and weight


@dataclass(frozen=True)
class InnerLight:
    """Light within a volume.

    Attributes:
        shadows: Transmittance to each sun, shape (sun, x, z, y).
        ambient: Mean incoming radiance but for what comes straight from the suns, vec3, shape (x, z, y).
        light: The part of it that was never scattered: red, green and blue of the sky's, the share of all directions
            that are open, red, green and blue of the fires'; on a lattice ``factor`` times coarser, shape (7, x, z, y).
        factor: Voxels along an edge of one of that lattice.
        fires: What glows, as lamps.
    """

    shadows: wp.array
    ambient: wp.array
    light: wp.array
    factor: int
    fires: Fires

    def for_march(self) -> dict[str, wp.array]:
        """Return what ``march`` takes."""
        return {"shadows": self.shadows, "ambient": self.ambient}


def light_volume(medium: Medium, lighting: Lighting) -> InnerLight:
    """Find the light within a volume.

    Args:
        medium: What fills it.
        lighting: What is around it.

    Returns:
        What ``march`` and surfaces need.
    """
    extinction = extinction_of(medium)
    shadows = cast_shadows(extinction, lighting.suns, factor=_factor(extinction.shape, SHADOW_VOXELS))
    factor = max(2, _factor(extinction.shape, SKY_VOXELS))
    light = gather_sky(extinction, lighting.ambient, factor=factor)
    fires = _light_fires(medium, extinction, factor, light)
    albedo = medium.albedo or Curve(next(iter(medium.fields)), 1.0, np.zeros(1))
    if albedo.times:
        raise ValueError(f"albedo is multiplied by {albedo.times}, but it is a share: use its entries alone")
    values = np.broadcast_to(albedo.values.reshape(len(albedo.values), -1), (len(albedo.values), 3))
    device = extinction.device
    ambient = scatter_again(
        light,
        medium.fields[albedo.field],
        wp.array(values, dtype=wp.vec3, device=device),
        shadows,
        wp.array(np.array([sun.color for sun in lighting.suns]).reshape(-1, 3), dtype=wp.vec3, device=device),
        factor=factor,
        top=albedo.top,
    )
    return InnerLight(shadows, ambient, light, factor, fires)


def empty_inner_light(suns: int, device: wp.Device | str | None) -> InnerLight:
    """Return the light where there is no volume: a voxel that hides nothing."""
    light = wp.array(np.eye(7)[3].reshape(7, 1, 1, 1), dtype=float, device=device)
    shadows = wp.ones((suns, 1, 1, 1), dtype=float, device=device)
    return InnerLight(shadows, wp.zeros((1, 1, 1), dtype=wp.vec3, device=device), light, 1, Fires.none())


def extinction_of(medium: Medium) -> wp.array:
    """Return the extinction of a medium in each voxel, shape (x, z, y) [1/voxel]."""
    curve = medium.extinction
    if curve is None:
        return wp.zeros_like(next(iter(medium.fields.values())))
    field = medium.fields[curve.field]
    values = wp.array(curve.values, dtype=float, device=field.device)
    times = medium.fields.get(curve.times)
    return look_up(field, values, top=curve.top, times=times, edge_fade=medium.edge_fade)


def cast_shadows(extinction: wp.array, suns: tuple[Sun, ...], *, factor: int = 1) -> wp.array:
    """Return the share of each sun's light that comes through to each voxel.

    Args:
        extinction: Shape (x, z, y) [1/voxel].
        suns: The lights.
        factor: Shadows are found on a lattice so many times coarser.

    Returns:
        Transmittance from 0 to 1, shape (sun, x, z, y).
    """
    out = wp.empty((len(suns), *extinction.shape), dtype=float, device=extinction.device)
    coarse = coarsen(extinction, factor=factor) if factor > 1 and suns else extinction
    for k, sun in enumerate(suns):
        if factor == 1:
            shadow(coarse, _swapped(sun.direction), out=out[k])
        else:
            refine(shadow(coarse, _swapped(sun.direction), spacing=factor), factor=factor, out=out[k])
    return out


def gather_sky(extinction: wp.array, ambient: np.ndarray, *, factor: int) -> wp.array:
    """Return what reaches each voxel of a coarse lattice from all around, without any scattering.

    Args:
        extinction: Shape (x, z, y) [1/voxel].
        ambient: Radiance all around as harmonics, shape (9, 3).
        factor: How many times coarser the lattice is.

    Returns:
        Light as in ``InnerLight``, without fires, shape (7, x, z, y).
    """
    coarse = coarsen(extinction, factor=factor)
    light = wp.zeros((7, *coarse.shape), dtype=float, device=extinction.device)
    through = wp.empty_like(coarse)
    for direction, weight in AROUND:
        shadow(coarse, _swapped(direction), spacing=factor, out=through)
        add_light(through, weight=weight, radiance=tuple(radiance(ambient, direction)), light=light)
    return light


def _light_fires(medium: Medium, extinction: wp.array, factor: int, light: wp.array) -> Fires:
    """Return the fires, and add what they send to the voxels of a coarse lattice; it is found on a coarser one."""
    if medium.emission is None:
        return Fires.none()
    coarse, device = coarsen(extinction, factor=factor), extinction.device
    fires = find_fires(medium, extinction=coarse.numpy(), open=light[3].numpy(), factor=factor)
    further = _factor(coarse.shape, FIRE_VOXELS)
    places = fires.places[:, [0, 2, 1, 3]] + [0.5, 0.5, 0.5, 0]
    places = places / (factor * further) - [0.5, 0.5, 0.5, 0]
    lit = light_of_lamps(
        coarsen(coarse, factor=further),
        wp.array(places, dtype=wp.vec4, device=device),
        wp.array(fires.colors, dtype=wp.vec3, device=device),
        spacing=factor * further,
    )
    for channel in range(3):
        refine(lit[channel], factor=further, out=light[4 + channel])
    return fires


def _swapped(direction: np.ndarray) -> tuple[float, float, float]:
    """Return a direction (x, y, z) as kernels know it, (x, z, y)."""
    x, y, z = direction
    return float(x), float(z), float(y)


def _factor(shape: tuple[int, ...], most: int) -> int:
    """Return by how much a lattice must be coarsened to have no more than some voxels."""
    return next(factor for factor in range(1, max(shape) + 2) if np.prod(coarse_shape(shape, factor)) <= most)
