"""Meshes of triangles: what stands or falls in a fluid."""

import io
import logging
import re
from pathlib import Path

import numpy as np

from warpfluid.files.polygons import cut_obj, cut_ply

MESH_SUFFIXES = (".obj", ".stl", ".ply")
NEAR = 1e-6  # of the mesh's size; vertices nearer than this are one, for STL repeats them for every triangle


def read_mesh(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Read a mesh; larger faces are cut into triangles, repeated vertices are joined.

    Args:
        path: An .obj, .stl or .ply file, y up. Materials and textures that it names are not looked for.

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
    data = path.read_bytes()
    if not data:
        raise ValueError(f"{path} is empty")
    try:
        vertices, triangles = _parse(data, ending)
    except Exception as error:  # readers fail on damaged files in every way there is
        raise ValueError(f"{path} is no mesh, or damaged: export it anew") from error
    if not np.isfinite(vertices).all():
        raise ValueError(f"{path} has vertices that are not finite numbers")
    vertices, triangles = _join(vertices, triangles)
    if not len(triangles):
        raise ValueError(f"{path} holds no triangles; export its surface, not only points or lines")
    return vertices, triangles


def _parse(data: bytes, ending: str) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices, shape (n, 3), and triangles, shape (m, 3), as they are in a file."""
    import trimesh

    logging.getLogger("trimesh").setLevel(logging.CRITICAL)  # its complaints become the one error of ours
    data = {".stl": _whole_stl, ".obj": cut_obj}.get(ending, bytes)(data)
    with np.errstate(all="ignore"):
        found = trimesh.load_mesh(io.BytesIO(data), file_type=ending[1:], process=False, skip_materials=True)
        vertices = np.array(found.vertices, np.float32).reshape(-1, 3)
    triangles = np.array(getattr(found, "faces", ()), np.int64).reshape(-1, 3)  # points alone have none
    cut = cut_ply(found.metadata.get("_ply_raw", {})) if ending == ".ply" and len(triangles) else None
    if cut:
        vertices, triangles = cut[0].astype(np.float32), cut[1]
    if triangles.size and not 0 <= triangles.min() <= triangles.max() < len(vertices):
        raise ValueError("its corners are not all there")
    if not len(vertices) and not re.search(rb"^v\s", data, re.MULTILINE):  # of points alone nothing is read
        raise ValueError("it has no corners")
    return vertices, triangles.astype(np.int32)


def _whole_stl(data: bytes) -> bytes:
    """Return a file up to the last triangle that its head tells of; text must have its last line."""
    if b"endsolid" in data[-200:].lower():
        return data
    end = 84 + 50 * int.from_bytes(data[80:84], "little")
    if len(data) < end:
        raise ValueError("it is cut off")
    return data[:end]


def _join(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Join vertices at one place; drop triangles that have lost a corner, and vertices that nothing names."""
    if not len(triangles):
        return vertices, triangles
    places = vertices.astype(np.float64) - vertices.min(axis=0)
    near = max(NEAR * places.max(), np.finfo(np.float32).tiny)
    cells = np.rint(places / near).astype(np.int64)
    _, first, place = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    triangles = first[place.reshape(-1)[triangles]]
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    used, triangles = np.unique(triangles, return_inverse=True)
    return vertices[used], triangles.reshape(-1, 3).astype(np.int32)
