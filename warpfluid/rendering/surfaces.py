"""Solid things in the picture of a volume: rigid bodies and the ground, with the shadows of both and of the smoke."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import warp as wp

from warpfluid.kernels.light.shading import Stage
from warpfluid.kernels.light.surfaces import see_surfaces
from warpfluid.rendering.camera import Camera
from warpfluid.rendering.fires import Fires
from warpfluid.rendering.harmonics import COSINE
from warpfluid.rendering.lighting import Lighting
from warpfluid.rendering.normals import corner_normals
from warpfluid.rendering.shadows import InnerLight, empty_inner_light

SAMPLES = 2  # a pixel and axis, so that edges are smooth
GREY = (0.5, 0.5, 0.52)
WIDE = 2.5  # box widths that the ground reaches; from half of that on it fades


@dataclass(frozen=True, eq=False)
class Surface:
    """A closed surface of triangles.

    Attributes:
        vertices: Index coordinates (x, y, z) [voxel], shape (n, 3).
        triangles: Indices, anticlockwise seen from outside, shape (m, 3).
        color: Share of red, green and blue light that it reflects.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    color: tuple[float, float, float] = GREY

    @cached_property
    def normals(self) -> np.ndarray:
        """Of the triangles' corners, shape (m, 3, 3)."""
        return corner_normals(np.asarray(self.vertices, np.float64), np.asarray(self.triangles))


@dataclass(frozen=True)
class Ground:
    """Level ground below a box, which fades into the background all around.

    Attributes:
        shape: Of the volume (x, z, y), on whose floor it is.
        color: Share of red, green and blue light that it reflects.
    """

    shape: tuple[int, int, int]
    color: tuple[float, float, float] = (0.25, 0.25, 0.26)


@dataclass(frozen=True)
class Seen:
    """What a camera sees of surfaces; the top row first.

    Attributes:
        color: Their light times the cover, shape (rows, columns, 3).
        cover: Share of each pixel that they cover, shape (rows, columns).
        depth: How far along the camera's forward [voxel], infinity where there is none, shape (rows, columns).
    """

    color: np.ndarray
    cover: np.ndarray
    depth: np.ndarray


def see(
    surfaces: Sequence[Surface],
    camera: Camera,
    lighting: Lighting,
    *,
    ground: Ground | None = None,
    inner: InnerLight | None = None,
    fires: Fires | None = None,
    samples: int = SAMPLES,
    device: wp.Device | str | None = None,
) -> Seen:
    """Render surfaces alone, as if nothing were in front of them.

    Args:
        surfaces: Bodies.
        camera: Where they are seen from.
        lighting: The suns and the sky.
        ground: The ground, if it shows.
        inner: Light within a volume, which casts shadows on them.
        fires: Fire that lights them.
        samples: Samples a pixel and axis.
        device: Where to compute.
    """
    size = (camera.size[1], camera.size[0])
    stage, mesh = Stage(), _mesh(surfaces, device)
    _set_surfaces(stage, surfaces, ground, mesh, device)
    _set_light(stage, lighting, inner, fires, device)
    color, sums = wp.empty(size, dtype=wp.vec3, device=device), wp.empty(size, dtype=wp.vec2, device=device)
    vectors = wp.array(_vectors(camera), dtype=wp.vec3, device=device)
    see_surfaces(stage, vectors, perspective=camera.perspective, samples=samples, color=color, sums=sums)
    cover, depth = np.moveaxis(sums.numpy(), 2, 0)
    cover = np.where(cover > 1 - 1e-5, np.float32(1), cover)
    return Seen(color.numpy(), cover, np.where(cover > 0, depth / np.maximum(cover, 1e-6), np.inf))


def _mesh(surfaces: Sequence[Surface], device) -> wp.Mesh | None:
    """Return all triangles in one tree, which must live until the picture is done."""
    if not surfaces:
        return None
    begins = np.cumsum([0, *(len(surface.vertices) for surface in surfaces)])
    corners = [np.asarray(s.triangles) + begin for s, begin in zip(surfaces, begins, strict=False)]
    points = wp.array(np.concatenate([s.vertices for s in surfaces]), dtype=wp.vec3, device=device)
    return wp.Mesh(points, wp.array(np.concatenate(corners).reshape(-1), dtype=int, device=device))


def _set_surfaces(stage: Stage, surfaces, ground: Ground | None, mesh: wp.Mesh | None, device) -> None:
    """Fill in what there is to be seen."""
    normals = [surface.normals.reshape(-1, 3) for surface in surfaces] or [np.zeros((0, 3))]
    colors = [np.tile(surface.color, (len(surface.triangles), 1)) for surface in surfaces] or [np.zeros((0, 3))]
    stage.normals = wp.array(np.concatenate(normals), dtype=wp.vec3, device=device)
    stage.colors = wp.array(np.concatenate(colors), dtype=wp.vec3, device=device)
    stage.mesh = wp.uint64(mesh.id if mesh else 0)
    if ground:
        width, depth, _ = ground.shape
        stage.ground = wp.vec4(-0.5, (width - 1) / 2, (depth - 1) / 2, WIDE * max(ground.shape))
        stage.ground_color = wp.vec3(*ground.color)


def _set_light(stage: Stage, lighting: Lighting, inner: InnerLight | None, fires: Fires | None, device) -> None:
    """Fill in where light comes from, and what takes it away."""
    suns, fires = lighting.suns, fires or Fires.none()
    vectors = {
        "sun_directions": [sun.direction for sun in suns],
        "sun_colors": [sun.color for sun in suns],
        "sky": COSINE[:, None] * lighting.ambient,
        "fire_colors": fires.escaping,
    }
    for name, values in vectors.items():
        setattr(stage, name, wp.array(np.reshape(values, (-1, 3)), dtype=wp.vec3, device=device))
    stage.fires = wp.array(fires.places, dtype=wp.vec4, device=device)
    if inner is None:
        inner = empty_inner_light(len(suns), device)
    stage.shadows, stage.ambient, stage.light, stage.factor = inner.shadows, inner.ambient, inner.light, inner.factor


def _vectors(camera: Camera) -> np.ndarray:
    """Return eye, a pixel's step to the right and up, forward, and the way to the first pixel's middle."""
    right, up = camera.pixel * camera.right, camera.pixel * camera.up
    width, height = camera.size
    first = (camera.shift[0] - (width - 1) / 2) * right + ((height - 1) / 2 + camera.shift[1]) * up
    return np.stack([camera.eye, right, up, camera.forward, first])
