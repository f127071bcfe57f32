"""Meshes of triangles: what stands or falls in a fluid."""

from pathlib import Path

import numpy as np

MESH_SUFFIXES = (".obj", ".stl", ".ply")
NEAR = 1e-6  # of the mesh's size; vertices nearer than this are one, for STL repeats them for every triangle


def read_mesh(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Read a mesh; larger faces are cut into triangles, repeated vertices are joined.

    Args:
        path: An .obj, .stl or .ply file, y up.

    Returns:
        Vertices, float32, shape (n, 3), components (x, y, z), in the file's unit; and triangles, int32, shape (m, 3).

    Raises:
        OSError: If the file cannot be opened.
        ValueError: If its ending is none of these, or it is damaged or holds no triangles.
    """
    path = Path(path)
    ending = path.suffix.lower()
    if ending not in MESH_SUFFIXES:
        raise ValueError(f"{path} ends in {ending!r}; a mesh is one of {', '.join(MESH_SUFFIXES)}")
    with open(path, "rb") as file:
        if not file.read(1):
            raise ValueError(f"{path} is empty")
    surface, damaged = _read_surface(path, ending)
    vertices = np.array(surface.points, np.float32).reshape(-1, 3)
    if damaged or not surface.n_points:
        raise ValueError(f"{path} is no mesh, or damaged: export it anew")
    if not np.isfinite(vertices).all():
        raise ValueError(f"{path} has vertices that are not finite numbers")
    triangles = np.array(surface.triangulate().regular_faces, np.int32).reshape(-1, 3)
    vertices, triangles = _join(vertices, triangles)
    if not len(triangles):
        raise ValueError(f"{path} holds no triangles; export its surface, not only points or lines")
    return vertices, triangles


def _read_surface(path: Path, ending: str):
    """Return what is in a file, and whether it is damaged; the reader never raises."""
    import pyvista
    from vtkmodules.vtkCommonCore import vtkOutputWindow

    complaints = []
    listener, before = vtkOutputWindow(), vtkOutputWindow.GetInstance()
    listener.SetDisplayModeToNever()
    listener.AddObserver("ErrorEvent", lambda _, name: complaints.append(name))
    with pyvista.vtk_verbosity("off"):
        vtkOutputWindow.SetInstance(listener)
        try:
            surface = pyvista.get_reader(str(path), force_ext=ending).read()
        finally:
            vtkOutputWindow.SetInstance(before)
    corners = pyvista.convert_array(surface.GetPolys().GetConnectivityArray())
    if corners.size and not 0 <= corners.min() <= corners.max() < surface.n_points:
        complaints.append("corners")
    return surface, bool(complaints)


def _join(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Join vertices at one place; drop triangles that have lost a corner, and vertices that nothing names."""
    if not len(triangles):
        return vertices, triangles
    size = np.ptp(vertices, axis=0).max()
    cells = np.rint((vertices - vertices.min(axis=0)) / max(NEAR * size, np.finfo(np.float32).tiny)).astype(np.int64)
    _, first, place = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    triangles = first[place.reshape(-1)[triangles]]
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    used, triangles = np.unique(triangles, return_inverse=True)
    return vertices[used], triangles.reshape(-1, 3).astype(np.int32)
