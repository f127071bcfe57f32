"""A volume in a window, whose light is added up along the rays and then coloured, as in the turntable.

VTK can add up light, but leaves the sum grey; a few lines put at the end of its shader colour it.
"""

import numpy as np

from warpfluid.rendering.ramps import RAMPS

SAMPLE = 1.0  # voxel, from one of a ray's samples to the next


def summed_volume(density: np.ndarray, look: str, *, white: float = 255.0, quick: bool = False):
    """Return the lit part of a volume, drawn ray by ray; its light is added to what is behind.

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


def image_grid(values: np.ndarray, name: str, edge: np.ndarray | float = 1.0, origin=(0.0, 0.0, 0.0)):
    """Return values at voxel centres, shape (x, z, y) or (x, z, y, 3), as a grid with axes (x, y, z)."""
    import pyvista

    upright = values.swapaxes(1, 2)
    grid = pyvista.ImageData(dimensions=upright.shape[:3], spacing=np.broadcast_to(edge, 3), origin=origin)
    grid.point_data[name] = upright.reshape(-1, *values.shape[3:], order="F") if values.ndim == 3 else _vectors(upright)
    return grid


def _lit(density: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners (x, z, y) of what is lit, with a voxel about it where there is room."""
    places = [np.flatnonzero(density.any(axis=other)) for other in ((1, 2), (0, 2), (0, 1))]
    ends = np.array([(p[0], p[-1]) if p.size else (0, 0) for p in places])
    return np.maximum(ends[:, 0] - 1, 0), np.minimum(ends[:, 1] + 2, density.shape)


def _vectors(upright: np.ndarray) -> np.ndarray:
    """Return vectors of a grid (x, y, z, 3) in the order of its points, x fastest."""
    return upright.transpose(2, 1, 0, 3).reshape(-1, 3)
