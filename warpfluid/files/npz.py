"""Volumes as ``.npz``: the format for NumPy users, one file a frame.

The key ``density`` holds the volume, float32, shape (x, y, z), y up; there may be further grids of that size, vectors
(x, y, z, 3) among them. Every other key is one number or text, but for ``origin``: where the centre of voxel (0, 0, 0)
lies, three numbers.
"""

import io
import math
import os
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from warpfluid.files.atomic import replacing
from warpfluid.files.grids import GridFacts, GridFile
from warpfluid.files.limits import check_promise, is_voxel_size

DENSITY, ORIGIN = "density", "origin"
SMALL = 4096  # bytes of an array that may be a fact


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
    for name, value in metadata.items():
        fact = np.asarray(value)
        if fact.ndim or fact.dtype.kind not in "fiubU":
            raise ValueError(f"metadata {name!r} is {value!r}; it must be one number or text")
    facts = {name: np.asarray(value) for name, value in metadata.items()}
    _write(path, {DENSITY: density.astype(np.float32, copy=False), **facts})


def write_npz_grids(
    path: str | Path,
    grids: Mapping[str, np.ndarray],
    *,
    voxel_size: float,
    origin: tuple[float, float, float],
    half: bool = False,
    frame: int = 1,
) -> None:
    """Write several grids of one lattice, and where they lie.

    Args:
        path: The file to write; its folder must exist.
        grids: Arrays by name, shape (x, y, z) or (x, y, z, 3), y up.
        voxel_size: Side of a voxel [world unit].
        origin: Where the centre of voxel (0, 0, 0) lies [world unit].
        half: Store 16-bit floats.
        frame: Number of the frame.

    Raises:
        ValueError: If the sizes differ, or a name is taken by a fact.
        OSError: If the file cannot be written.
    """
    facts = {"voxel_size": np.float64(voxel_size), ORIGIN: np.asarray(origin, np.float64), "frame": np.int64(frame)}
    shapes = {name: grid.shape[:3] for name, grid in grids.items()}
    if len(set(shapes.values())) != 1 or set(facts) & set(shapes):
        raise ValueError(f"the grids of a file must have one shape, and other names than {', '.join(facts)}: {shapes}")
    kind = np.float16 if half else np.float32
    _write(path, {**{name: grid.astype(kind, copy=False) for name, grid in grids.items()}, **facts})


def _write(path: str | Path, arrays: dict[str, np.ndarray]) -> None:
    odd = [name for name in arrays if not name.isprintable() or set(name) & set("/\\:")]
    if odd:  # it becomes the name of a file for whoever unpacks the archive
        raise ValueError(f"{path}: {odd[0]!r} cannot be a name in an .npz file; choose other grids, or rename it")
    with (
        replacing(path) as file,
        zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
    ):
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asarray(array), allow_pickle=False)


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
    arrays = _opened(path, _arrays)
    if DENSITY not in arrays:
        found = ", ".join(arrays) or "nothing"
        raise ValueError(f"{path}: no key {DENSITY!r}, only {found}; save the volume under that key")
    return _volume(path, DENSITY, arrays.pop(DENSITY)), _facts(arrays)


def read_npz_grids(path: str | Path) -> GridFile:
    """Read all grids of a file: arrays of one size, shape (x, y, z) or (x, y, z, 3).

    Returns:
        The grids and where they lie: at the origin, and with voxels of 1 unit, where the file does not tell.

    Raises:
        ValueError: If this is no such file, it is damaged, or there is no grid.
        OSError: If the file cannot be read.
    """
    arrays = _opened(path, _arrays)
    grids = {name: array for name, array in arrays.items() if array.ndim >= 3 and array.dtype.kind in "fiub"}
    grids = {name: _volume(path, name, array) for name, array in grids.items()}
    if not grids or len({grid.shape[:3] for grid in grids.values()}) > 1:
        found = ", ".join(f"{name} {array.shape}" for name, array in arrays.items()) or "nothing"
        raise ValueError(f"{path}: no volumes of one size, only {found}; save shape (x, y, z) under 'density'")
    size, origin = _place(path, arrays)
    return GridFile(
        grids=grids,
        voxel_size=size,
        origin=origin,
        metadata=_facts(arrays) | ({ORIGIN: origin} if ORIGIN in arrays else {}),
    )


def npz_facts(path: str | Path) -> list[GridFacts]:
    """Return what is known of every grid of a file; of the arrays only the heads are read.

    ``about`` says with ``placed`` whether the file tells where its grids lie.

    Raises:
        ValueError: If this is no such file, or it is damaged.
        OSError: If the file cannot be read.
    """
    arrays, shapes = _opened(path, _heads)
    size, origin = _place(path, arrays)
    found = []
    for name, (shape, dtype) in shapes.items():
        shape = shape[1:] if len(shape) == 4 and shape[0] == 1 else shape
        if len(shape) not in (3, 4) or dtype.kind not in "fiub" or not min(shape):
            continue
        box = np.array([[0, 0, 0], [n - 1 for n in shape[:3]]])
        found.append(
            GridFacts(
                name=name,
                kind="float" if len(shape) == 3 else "vec3s" if shape[3] == 3 else f"{shape[3]} numbers",
                half=dtype == np.float16,
                voxel_size=size,
                shift=origin,
                box=box,
                whole=box,
                active=None,
                up=None,
                about={"placed": ORIGIN in arrays},
            )
        )
    return found


def _opened(path: str | Path, read: Callable[[BinaryIO], Any]) -> Any:
    with open(path, "rb") as file:
        try:
            return read(file)
        except Exception as error:  # zipfile and NumPy fail on damaged files in every way there is
            raise ValueError(f"{path}: this is no .npz file of plain arrays, or it is damaged: {error}") from error


def _place(path: str | Path, arrays: Mapping[str, np.ndarray]) -> tuple[float, tuple[float, ...]]:
    """Return the voxel size and where the first voxel lies, as the file tells or by default."""
    size, origin = _facts(arrays).get("voxel_size", 1.0), np.asarray(arrays.get(ORIGIN, (0.0, 0.0, 0.0)))
    if origin.shape != (3,) or origin.dtype.kind not in "fiu" or not np.isfinite(origin).all():
        raise ValueError(f"{path}: origin is {str(origin.tolist())[:80]}; it must be three numbers")
    if not (isinstance(size, int | float) and is_voxel_size(size)):
        raise ValueError(f"{path}: voxel_size is {str(size)[:80]}; it must be a positive number")
    return float(size), tuple(origin.astype(float).tolist())


def _volume(path: str | Path, name: str, array: np.ndarray) -> np.ndarray:
    """Return an array as float32; a leading axis of one is taken off."""
    volume = array[0] if array.ndim == 4 and len(array) == 1 else array
    vectors = name != DENSITY and volume.ndim == 4 and volume.shape[3] == 3
    if (volume.ndim != 3 and not vectors) or volume.dtype.kind not in "fiub":
        raise ValueError(f"{path}: {name} is {array.dtype} of shape {array.shape}; it must be (x, y, z)")
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(volume, np.float32)


def _facts(arrays: Mapping[str, np.ndarray]) -> dict[str, float | int | str | bool]:
    return {name: array.item() for name, array in arrays.items() if not array.ndim and array.dtype.kind in "fiubU"}


def _arrays(file: BinaryIO) -> dict[str, np.ndarray]:
    """Return a file's arrays; unlike ``np.load``, check each against its checksum before using its header."""
    with _archive(file) as archive:
        return {_name(info): _array(archive.read(info)) for info in archive.infolist()}


def _heads(file: BinaryIO) -> tuple[dict[str, np.ndarray], dict[str, tuple]]:
    """Return a file's small arrays, and the shape and type of the others."""
    arrays, shapes = {}, {}
    with _archive(file) as archive:
        for info in archive.infolist():
            if info.file_size <= SMALL:
                array = arrays[_name(info)] = _array(archive.read(info))
                shapes[_name(info)] = array.shape, array.dtype
                continue
            with archive.open(info) as member:
                shapes[_name(info)] = _head(member, info.file_size)
    return arrays, shapes


def _archive(file: BinaryIO) -> zipfile.ZipFile:
    """Return an open archive that is packed in the usual way and opens to no more than it can hold."""
    archive = zipfile.ZipFile(file)
    if any(info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) for info in archive.infolist()):
        raise ValueError("it is packed in another way than np.savez packs")
    check_promise(sum(info.file_size for info in archive.infolist()), os.fstat(file.fileno()).st_size)
    return archive


def _name(info: zipfile.ZipInfo) -> str:
    return info.filename.removesuffix(".npy")


def _array(data: bytes) -> np.ndarray:
    _head(io.BytesIO(data), len(data))
    array = np.lib.format.read_array(io.BytesIO(data), allow_pickle=False)
    if array.dtype.kind == "U":
        array.tolist()  # fails where bytes are no letters
    return array


def _head(member: BinaryIO, size: int) -> tuple[tuple[int, ...], np.dtype]:
    """Return the shape and type of an array; they must agree with its size in bytes, head and all."""
    version = np.lib.format.read_magic(member)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, dtype = read(member)
    if dtype.hasobject or math.prod(shape) * dtype.itemsize != size - member.tell():
        raise ValueError(f"an array of {dtype} and shape {shape} does not have {size} bytes")
    return shape, dtype
