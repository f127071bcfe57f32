"""The things in a window, as pyvista draws them, each made of a frame of the scene.

World coordinates are index coordinates (x, y, z): voxel centres are whole numbers.
"""

import numpy as np

from warpfluid.preview.summing import image_grid
from warpfluid.rendering.ramps import apply_ramp

ARROWS = 500  # about so many are drawn
LINES = 160
LATTICE = 56  # voxels a side that motion is shown on
PICTURE_DISTANCE = 0.82  # of the box's width, from its middle to an input picture
RING = 1.04  # radius over half the diagonal of the floor
LINE_COLOUR, WORD_COLOUR = "#78849c", "#c4ccdc"
SLICE_STEPS = 256


def slices(density: np.ndarray, height: float, top: float):
    """Return three slices, the horizontal one at a share of the height, and their colours."""
    import pyvista

    grid = image_grid(density, "density")
    width, depth, tall = (n - 1 for n in density.shape)
    table = apply_ramp(np.arange(SLICE_STEPS), "jet", SLICE_STEPS - 1)
    seen = np.minimum(np.linspace(0, 8, SLICE_STEPS), 1)[:, None] * 235
    colours = pyvista.LookupTable(values=np.concatenate([table, seen], axis=1).astype(np.uint8), scalar_range=(0, top))
    return grid.slice_orthogonal(x=width / 2, y=height * tall, z=depth / 2), colours


def arrows(density: np.ndarray, velocity: np.ndarray):
    """Return arrows along the motion of what is lit; None where nothing is.

    Args:
        density: Shape (x, z, y).
        velocity: Shape (x, z, y, 3), components (x, z, y) [voxel/s].
    """
    import pyvista

    lit = np.argwhere(density > 0.05 * density.max())
    if not len(lit):
        return None
    step = max(1, round((len(lit) / ARROWS) ** (1 / 3)))
    places = lit[(lit % step == step // 2).all(axis=1)]
    vectors = velocity[tuple(places.T)][:, [0, 2, 1]]
    speed = np.linalg.norm(vectors, axis=1)
    if not len(places) or not speed.max() > 0:
        return None
    points = pyvista.PolyData(places[:, [0, 2, 1]].astype(np.float32))
    points["speed"] = speed
    points["length"] = 3 * step * np.maximum(speed / np.quantile(speed, 0.98), 0.05).clip(max=1.3)
    points["velocity"] = vectors
    return points.glyph(
        orient="velocity", scale="length", factor=1.0, geom=pyvista.Arrow(shaft_radius=0.05, tip_radius=0.13)
    )


def streamlines(density: np.ndarray, velocity: np.ndarray):
    """Return tubes along the motion through what is lit; None where there is none. Arguments as for ``arrows``."""
    import pyvista

    step = max(1, max(density.shape) // LATTICE)
    coarse = velocity[::step, ::step, ::step][..., [0, 2, 1]]
    grid = image_grid(coarse, "velocity", edge=step)
    lit = np.argwhere(density > 0.15 * density.max())
    if not len(lit) or not np.any(coarse):
        return None
    chosen = lit[np.linspace(0, len(lit) - 1, min(LINES, len(lit))).astype(int)]
    seeds = pyvista.PolyData(chosen[:, [0, 2, 1]].astype(np.float32))
    lines = grid.streamlines_from_source(
        seeds,
        vectors="velocity",
        integration_direction="both",
        max_length=1.2 * max(density.shape),
        initial_step_length=0.5,
    )
    if not lines.n_points:
        return None
    lines["speed"] = np.linalg.norm(lines["velocity"], axis=1)
    return lines.tube(radius=max(density.shape) / 900)


def picture(image: np.ndarray, angle_deg: float, shape: tuple[int, int, int]):
    """Return the plane on which an input picture stands behind the box, and its texture.

    Args:
        image: Grey levels, shape (u, v).
        angle_deg: Where its camera stands.
        shape: Voxels of the volume (x, z, y), which the picture is as wide and high as.
    """
    import pyvista

    towards, right = facing(angle_deg)
    width, height = shape[0], shape[2]
    middle = box_middle(shape) - PICTURE_DISTANCE * width * towards
    foot = middle - width / 2 * right - [0, height / 2, 0]
    aside, above = width * right, np.array([0, height, 0])
    corners = np.array([foot, foot + aside, foot + aside + above, foot + above])
    plane = pyvista.PolyData(corners, faces=[4, 0, 1, 2, 3])
    plane.active_texture_coordinates = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    texture = pyvista.Texture(np.ascontiguousarray(apply_ramp(image.T[::-1], "gray")))
    texture.interpolate = True
    return plane, texture


def solid(vertices: np.ndarray, triangles: np.ndarray):
    """Return the surface of a body or an obstacle: vertices (x, y, z) [voxel], and their indices."""
    import pyvista

    return pyvista.PolyData.from_regular_faces(vertices.astype(np.float32), triangles)


def outline(shape: tuple[int, int, int]):
    """Return the edges of the box and a ring about its floor."""
    import pyvista

    width, depth, height = shape
    box = pyvista.Box((-0.5, width - 0.5, -0.5, height - 0.5, -0.5, depth - 0.5)).extract_feature_edges()
    turn = np.radians(np.arange(0, 361, 3))
    return box.merge(pyvista.lines_from_points(_ring(turn, shape)).extract_all_edges())


def view_marks(angles_deg, shape: tuple[int, int, int]) -> tuple[np.ndarray, list[str]]:
    """Return where on the ring the cameras of the views stand, and their names."""
    return _ring(np.radians(np.asarray(angles_deg, float)), shape), [f"{angle:g}°" for angle in angles_deg]


def facing(angle_deg: float, elevation_deg: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return the direction to a camera and that to its right, (x, y, z)."""
    t, e = np.radians([angle_deg, elevation_deg])
    towards = np.array([-np.sin(t) * np.cos(e), np.sin(e), np.cos(t) * np.cos(e)])
    return towards, np.array([np.cos(t), 0.0, np.sin(t)])


def box_middle(shape: tuple[int, int, int]) -> np.ndarray:
    """Return the middle of the box (x, y, z)."""
    return (np.array([shape[0], shape[2], shape[1]]) - 1) / 2


def _ring(angles: np.ndarray, shape: tuple[int, int, int]) -> np.ndarray:
    radius = RING * np.hypot(shape[0], shape[1]) / 2
    foot = box_middle(shape) - [0, shape[2] / 2, 0]
    return foot + radius * np.stack([-np.sin(angles), 0 * angles, np.cos(angles)], axis=-1)
