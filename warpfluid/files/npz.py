"""Volumes as ``.npz``: the format for NumPy users, one file a frame.

The key ``density`` holds the volume, float32, shape (x, y, z), y up; every other key is one number or text.
"""

import io
import struct
import zipfile
import zlib
from pathlib import Path
from typing import BinaryIO

import numpy as np

from warpfluid.files.atomic import replacing

DENSITY = "density"

# What zipfile and NumPy raise for a file that is no archive, or a damaged one.
DAMAGE = (
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
    EOFError,
    KeyError,
    MemoryError,
    OSError,
    RuntimeError,
    ValueError,
)


def write_npz(path: str | Path, density: np.ndarray, **metadata: float | int | str | bool) -> None:
    """Write a volume and facts about it.

    Args:
        path: The file to write; its folder must exist.
        density: Volume, shape (x, y, z), y up.
        **metadata: Single numbers or text by name, such as ``voxel_size`` and ``frame``.

    Raises:
        ValueError: If an argument does not fit.
        OSError: If the file cannot be written.
    """
    density = np.asarray(density)
    if density.ndim != 3 or density.dtype.kind not in "fiub":
        raise ValueError(f"density is {density.dtype} of shape {density.shape}; it must be numbers, (x, y, z)")
    facts = {name: np.asarray(value) for name, value in metadata.items()}
    for name, fact in facts.items():
        if fact.ndim or fact.dtype.kind not in "fiubU":
            raise ValueError(f"metadata {name!r} is {metadata[name]!r}; it must be one number or text")
    arrays = {DENSITY: density.astype(np.float32, copy=False), **facts}
    with (
        replacing(path) as file,
        zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
    ):
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, array, allow_pickle=False)


def read_npz(path: str | Path) -> tuple[np.ndarray, dict[str, float | int | str | bool]]:
    """Read a volume and the facts about it.

    Args:
        path: A file with the key ``density``, shape (x, y, z) or (1, x, y, z).

    Returns:
        The volume, float32 of shape (x, y, z), and all single numbers and texts in the file by name.

    Raises:
        ValueError: If this is no such file, or it is damaged.
        OSError: If the file cannot be read.
    """
    with open(path, "rb") as file:
        try:
            arrays = _arrays(file)
        except DAMAGE as error:
            raise ValueError(f"{path}: this is no .npz file of plain arrays, or it is damaged: {error}") from error
    if DENSITY not in arrays:
        found = ", ".join(arrays) or "nothing"
        raise ValueError(f"{path}: no key {DENSITY!r}, only {found}; save the volume under that key")
    density = arrays.pop(DENSITY)
    volume = density[0] if density.ndim == 4 and len(density) == 1 else density
    if volume.ndim != 3 or volume.dtype.kind not in "fiub":
        raise ValueError(f"{path}: density is {density.dtype} of shape {density.shape}; it must be (x, y, z)")
    scalars = {name: array for name, array in arrays.items() if not array.ndim and array.dtype.kind in "fiubU"}
    return np.ascontiguousarray(volume, np.float32), {name: array.item() for name, array in scalars.items()}


def _arrays(file: BinaryIO) -> dict[str, np.ndarray]:
    """Return a file's arrays; unlike ``np.load``, check each against its checksum before using its header."""
    with zipfile.ZipFile(file) as archive:
        members = {name.removesuffix(".npy"): archive.read(name) for name in archive.namelist()}
    return {name: np.lib.format.read_array(io.BytesIO(data)) for name, data in members.items()}
