"""The things in a window, as pyvista draws them, each made of a frame of the scene.

World coordinates are index coordinates (x, y, z): voxel centres are whole numbers.
"""

import numpy as np

from warpfluid.preview.surroundings import Solid
from warpfluid.rendering.ramps import RAMPS, apply_ramp

ARROWS = 500  # about so many are drawn
LINES = 160
LATTICE = 56  # voxels a side that motion is shown on
PICTURE_DISTANCE = 0.82  # of the box's width, from its middle to an input picture
RING = 1.04  # radius over half the diagonal of the floor
SAMPLE = 1.0  # voxel, from one of a ray's samples to the next
LINE_COLOUR, WORD_COLOUR = "#78849c", "#c4ccdc"
BODY_COLOUR, OBSTACLE_COLOUR = "#d9a066", "#8a93a6"
SLICE_STEPS = 256


def image_grid(values: np.ndarray, name: str, edge: np.ndarray | float = 1.0, origin=(0.0, 0.0, 0.0)):
    """Return values at voxel centres, shape (x, z, y) or (x, z, y, 3), as a grid with axes (x, y, z)."""
    import pyvista

    upright = values.swapaxes(1, 2)
    grid = pyvista.ImageData(dimensions=upright.shape[:3], spacing=np.broadcast_to(edge, 3), origin=origin)
    grid.point_data[name] = upright.reshape(-1, *values.shape[3:], order="F") if values.ndim == 3 else _vectors(upright)
    return grid


def volume(density: np.ndarray, look: str, *, white: float = 255.0, quick: bool = False):
    """Return the lit part of a volume, its light added up along every ray and coloured, as the turntable does.

    VTK can add up light, but leaves the sum grey; a few lines put at the end of its shader colour it. The light is
    added to what is behind.

    Args:
        density: Shape (x, z, y).
        look: Name of a colour ramp.
        white: Ray sum that is the brightest colour.
        quick: Draw coarser while the camera moves.
    """
    import vtkmodules.vtkRenderingVolumeOpenGL2 as vtk_volumes
    from vtkmodules.vtkCommonDataModel import vtkPiecewiseFunction
    from vtkmodules.vtkRenderingCore import vtkVolume, vtkVolumeProperty

    low, high = _lit(density)
    inside = np.pad(density[tuple(map(slice, low, high))], 1)  # VTK counts from the smallest value: let it be 0
    full, drawing = vtkPiecewiseFunction(), vtkVolumeProperty()
    full.AddPoint(0.0, 1.0)
    drawing.SetScalarOpacity(full)
    drawing.SetInterpolationTypeToLinear()
    drawing.ShadeOff()
    mapper = vtk_volumes.vtkOpenGLGPUVolumeRayCastMapper()
    mapper.SetInputData(image_grid(inside, "density", origin=low[[0, 2, 1]] - 1))
    mapper.SetBlendModeToAdditive()
    mapper.SetAutoAdjustSampleDistances(quick)
    mapper.SetSampleDistance(SAMPLE)
    made = vtkVolume()
    made.SetMapper(mapper)
    made.SetProperty(drawing)
    colouring = _colouring(RAMPS[look], float(inside.max()) / white)
    made.GetShaderProperty().AddFragmentShaderReplacement("//VTK::Shading::Exit", True, colouring, False)
    return made


def _colouring(stops: dict[float, tuple[int, int, int]], gain: float) -> str:
    """Return the end of VTK's shader: from a sum of values between 0 and 1 to its colour in a ramp."""
    count = len(stops)
    levels = ", ".join(f"{grey / 255:.6f}" for grey in stops)
    colours = ", ".join(f"vec3({r / 255:.6f}, {g / 255:.6f}, {b / 255:.6f})" for r, g, b in stops.values())
    return f"""
  float level = clamp(l_sumValue.x * in_sampleDistance * {gain:.8e}, 0.0, 1.0);
  float stops[{count}] = float[{count}]({levels});
  vec3 colours[{count}] = vec3[{count}]({colours});
  vec3 seen = colours[0];
  for (int i = 0; i + 1 < {count}; ++i)
    seen = mix(seen, colours[i + 1], clamp((level - stops[i]) / (stops[i + 1] - stops[i]), 0.0, 1.0));
  g_fragColor = vec4(seen, 0.0);
"""


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


def solid(made: Solid):
    """Return the surface of a body or an obstacle."""
    import pyvista

    return pyvista.PolyData.from_regular_faces(made.vertices.astype(np.float32), made.triangles)


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


def _lit(density: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners (x, z, y) of what is lit, with a voxel about it where there is room."""
    places = [np.flatnonzero(density.any(axis=other)) for other in ((1, 2), (0, 2), (0, 1))]
    ends = np.array([(p[0], p[-1]) if p.size else (0, 0) for p in places])
    return np.maximum(ends[:, 0] - 1, 0), np.minimum(ends[:, 1] + 2, density.shape)


def _vectors(upright: np.ndarray) -> np.ndarray:
    """Return vectors of a grid (x, y, z, 3) in the order of its points, x fastest."""
    return upright.transpose(2, 1, 0, 3).reshape(-1, 3)
