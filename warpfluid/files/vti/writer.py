"""Write volumes as ``.vti``."""

import struct
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Literal
from xml.sax.saxutils import quoteattr

import numpy as np

from warpfluid.files.atomic import replacing
from warpfluid.files.vdb.layout import to_file_axes

BLOCK = 2**20  # bytes packed at once


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
