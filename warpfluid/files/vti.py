"""Volumes as ``.vti``, VTK's XML image data, for ParaView and PyVista: one file a frame.

Values stand at points, which are the centres of the voxels, so that ParaView interpolates between them, and contours,
slices and streamlines need no conversion. Written here, for there is little to it; read by VTK.
"""

import re
import struct
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Literal
from xml.sax.saxutils import quoteattr, unescape

import numpy as np

from warpfluid.files.atomic import replacing
from warpfluid.files.grids import GridFacts, GridFile
from warpfluid.files.vdb.layout import to_file_axes

BLOCK = 2**20  # bytes packed at once
HEAD = 2**20  # bytes before which the values begin


def write_vti(
    path: str | Path,
    grids: Mapping[str, np.ndarray],
    *,
    voxel_size: float = 1.0,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    up: Literal["y", "z"] = "y",
) -> None:
    """Write grids of one lattice as VTK image data.

    Args:
        path: The file to write; its folder must exist.
        grids: Arrays by name, shape (x, y, z) or (x, y, z, 3), all of one size, y up.
        voxel_size: Side of a voxel [world unit].
        origin: Where the centre of voxel (0, 0, 0) lies [world unit], y up.
        up: The file's up axis; ``z`` turns the whole volume, vectors included: (x, y, z) becomes (x, -z, y).

    Raises:
        ValueError: If the sizes differ.
        OSError: If the file cannot be written.
    """
    shapes = {name: grid.shape[:3] for name, grid in grids.items()}
    if len(set(shapes.values())) != 1:
        raise ValueError(f"the grids of a file must have one shape, not {shapes}; write several files")
    if up == "z":
        x, y, z = origin
        grids = {name: to_file_axes(grid, "z")[0] for name, grid in grids.items()}
        shape = next(iter(grids.values())).shape[:3]
        origin = (x, 0 - z - (shape[1] - 1) * voxel_size, y)
    else:
        (shape,) = set(shapes.values())
    packed, arrays, offset = [], [], 0
    for name, grid in grids.items():
        data = _pack(np.ascontiguousarray(np.swapaxes(grid, 0, 2), "<f4").tobytes())  # x runs fastest
        arrays.append(
            f'<DataArray type="Float32" Name={quoteattr(name)} NumberOfComponents="{1 if grid.ndim == 3 else 3}" '
            f'format="appended" offset="{offset}"/>'
        )
        packed.append(data)
        offset += len(data)
    with replacing(path) as file:
        file.write(_header(shape, voxel_size, origin, arrays).encode())
        for data in packed:
            file.write(data)
        file.write(b"\n</AppendedData>\n</VTKFile>\n")


def read_vti(path: str | Path) -> GridFile:
    """Read image data whose values stand at points or in cells.

    Raises:
        ValueError: If this is no such file, it is damaged, has no arrays or no cubes for voxels.
        OSError: If the file cannot be read.
    """
    with open(path, "rb") as file:
        if b"ImageData" not in file.read(4096):
            raise ValueError(f"{path}: this is no VTK image data (.vti)")
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLImageDataReader

    reader, complaints = vtkXMLImageDataReader(), []
    reader.AddObserver("ErrorEvent", lambda *_: complaints.append(1))
    reader.SetFileName(str(path))
    reader.Update()
    image = reader.GetOutput()
    at_points = image.GetPointData().GetNumberOfArrays() > 0
    data = image.GetPointData() if at_points else image.GetCellData()
    spacing, first = np.array(image.GetSpacing()), np.array(image.GetExtent()[::2])
    if complaints or not data.GetNumberOfArrays():
        raise ValueError(f"{path}: the file is damaged, or has no arrays")
    if not np.allclose(spacing, spacing[0], rtol=1e-5) or not spacing[0] > 0:
        raise ValueError(f"{path}: its voxels are {spacing.tolist()}, no cubes; resample it")
    shape = np.array(image.GetDimensions()) - (0 if at_points else 1)
    grids = {}
    for i in range(data.GetNumberOfArrays()):
        values = vtk_to_numpy(data.GetArray(i))
        if values.ndim == 1 or values.shape[1] in (1, 3):
            vectors = (3,) if values.ndim == 2 and values.shape[1] == 3 else ()
            grids[data.GetArrayName(i)] = np.swapaxes(values.reshape(*shape[::-1], *vectors), 0, 2)
    origin = np.array(image.GetOrigin()) + spacing * (first + (0.0 if at_points else 0.5))
    return GridFile(
        grids={name: np.ascontiguousarray(grid, np.float32) for name, grid in grids.items()},
        voxel_size=float(spacing[0]),
        origin=tuple(origin.tolist()),
        metadata={"values": "at points" if at_points else "in cells"},
    )


def vti_facts(path: str | Path) -> list[GridFacts]:
    """Return what is known of every array of a file, from the lines before the values.

    Raises:
        ValueError: If this is no such file, or it is damaged.
        OSError: If it cannot be read.
    """
    with open(path, "rb") as file:
        head = file.read(HEAD).split(b"<AppendedData")[0].decode(errors="replace")
    tag = re.search(r"<ImageData\b[^>]*>", head)
    try:
        extent, origin, spacing = (_numbers(tag[0], name) for name in ("WholeExtent", "Origin", "Spacing"))
        first, last = np.array(extent, int).reshape(3, 2).T
        cubes = np.allclose(spacing, spacing[0], rtol=1e-5) and spacing[0] > 0
        found = re.findall(r"<(PointData|CellData)\b[^>]*>(.*?)</\1>", head, re.DOTALL)
        at_points, arrays = next(((kind == "PointData", body) for kind, body in found if "<DataArray" in body))
    except (TypeError, ValueError, StopIteration) as error:
        raise ValueError(f"{path}: this is no VTK image data (.vti), or it has no arrays") from error
    box = np.array([first, last if at_points else last - 1])
    shift = np.array(origin) + (0 if at_points else 0.5) * np.array(spacing)
    return [
        GridFacts(
            name=unescape(_text(array, "Name"), {"&quot;": '"'}),
            kind={"1": "float", "3": "vec3s"}.get(_text(array, "NumberOfComponents") or "1", "other"),
            half=False,
            voxel_size=float(spacing[0]) if cubes else None,
            shift=tuple(shift.tolist()),
            box=box,
            whole=box,
            active=None,
            up=None,
            about={"values": "at points" if at_points else "in cells"},
        )
        for array in re.findall(r"<DataArray\b[^>]*>", arrays)
    ]


def _numbers(tag: str, name: str) -> list[float]:
    return [float(number) for number in _text(tag, name).split()]


def _text(tag: str, name: str) -> str:
    found = re.search(rf"\b{name}=\"([^\"]*)\"|\b{name}='([^']*)'", tag)
    return (found[1] or found[2] or "") if found else ""


def _header(shape: tuple, voxel_size: float, origin: tuple, arrays: list[str]) -> str:
    """Return everything before the values."""
    extent = " ".join(f"0 {n - 1}" for n in shape)
    place = " ".join(repr(float(x)) for x in origin)
    size = repr(float(voxel_size))
    return "\n".join(
        [
            '<?xml version="1.0"?>',
            '<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64" '
            'compressor="vtkZLibDataCompressor">',
            f'<ImageData WholeExtent="{extent}" Origin="{place}" Spacing="{size} {size} {size}">',
            f'<Piece Extent="{extent}">',
            "<PointData>",
            *arrays,
            "</PointData>",
            "</Piece>",
            "</ImageData>",
            '<AppendedData encoding="raw">',
            "_",
        ]
    )


def _pack(data: bytes) -> bytes:
    """Return packed blocks, with their number and sizes in front."""
    blocks = [zlib.compress(data[at : at + BLOCK], 1) for at in range(0, len(data), BLOCK)]
    rest = len(data) % BLOCK  # size of the last block if it is not full
    return struct.pack(f"<{3 + len(blocks)}Q", len(blocks), BLOCK, rest, *map(len, blocks)) + b"".join(blocks)
