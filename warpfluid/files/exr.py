"""OpenEXR pictures: float light, linear by convention."""

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from warpfluid.files.atomic import replacing
from warpfluid.files.limits import FLAT_PICTURE, check_promise, check_sides
from warpfluid.files.quiet import quiet

LARGEST_HALF = 65504.0

_MAGIC = b"\x76\x2f\x31\x01"


def read_exr(path: str | Path) -> np.ndarray:
    """Read the picture in an OpenEXR file.

    Args:
        path: The file. Its picture is ``R, G, B`` (or those of a layer, if only one has them), else ``Y``,
            else the only channel, of the first part that has one. Alpha is multiplied in by convention.

    Returns:
        Light, float32, shape (rows, columns, 1 or 3), top row first. It fills the display window; outside the
        data window it is black.

    Raises:
        OSError: If the file cannot be opened.
        ValueError: If it is damaged, too large, deep, or its channels are no picture.
    """
    import OpenEXR

    with open(path, "rb") as file:  # the library has one message for what is missing and what is damaged
        if file.read(4) != _MAGIC:
            raise ValueError(f"{path} is empty or no OpenEXR file")
    try:
        with quiet():
            headers = [part.header for part in OpenEXR.File(str(path), header_only=True).parts]
            check_promise(sum(map(_promised, headers)), os.path.getsize(path), FLAT_PICTURE)
            parts = OpenEXR.File(str(path), separate_channels=True).parts
            return _picture(parts)
    except Exception as error:  # damaged files fail in many ways
        raise ValueError(f"{path} cannot be read: {error}") from error


def write_exr(path: str | Path, channels: Mapping[str, np.ndarray], half: bool = False) -> None:
    """Write an OpenEXR file with ZIP compression.

    Args:
        path: The file; its folder must exist.
        channels: Arrays by channel name, shape (rows, columns), top row first; under ``RGB`` the shape
            (rows, columns, 3), under ``RGBA`` (rows, columns, 4).
        half: Store 16-bit floats.

    Raises:
        OSError: If the file cannot be written.
        ValueError: If the shapes differ, or a value is too large for a half float.
    """
    import OpenEXR

    arrays = {name: np.asarray(array) for name, array in channels.items()}
    _check_channels(path, arrays)
    if half:
        _check_half(path, arrays)
    dtype = np.float16 if half else np.float32
    # the library writes wrong pixels, without a word, of arrays that are not contiguous
    arrays = {name: np.ascontiguousarray(array, dtype=dtype) for name, array in arrays.items()}
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    try:
        with replacing(path) as file:
            OpenEXR.File(header, arrays).write(file.name)
    except RuntimeError as error:
        raise OSError(f"{path} cannot be written: {error}") from error


def _window(header: dict, name: str) -> tuple[int, int, int, int]:
    """Return left, top, width and height of the data or display window."""
    (left, top), (right, bottom) = ([int(value) for value in corner] for corner in header[name])
    return left, top, right - left + 1, bottom - top + 1


def _promised(header: dict) -> int:
    """Return what the pixels of a part take [byte]; refuse what is too large."""
    sizes = {name: _window(header, name)[2:] for name in ("dataWindow", "displayWindow")}
    if header.get("tiles") is not None:  # one is opened whole, however little of it lies in the picture
        sizes["tile"] = (header["tiles"].xSize, header["tiles"].ySize)
    for name, size in sizes.items():
        check_sides(*size, f"its {name}")
    del sizes["displayWindow"]  # only what is shown of the picture fills it, not all channels
    return 4 * max(len(header["channels"]), 1) * max(width * height for width, height in sizes.values())


def _picture(parts: list) -> np.ndarray:
    """Return the picture of the first part that has one, shape (rows, columns, channels)."""
    found = []
    for part in parts:
        names = _picture_channels(set(part.channels))
        if names:
            planes = [part.channels[name].pixels for name in names]
            if any(plane.dtype == object for plane in planes):
                raise ValueError("it is a deep image: flatten it")
            return _fill_display_window(np.stack(planes, axis=-1).astype(np.float32), part.header)
        found += sorted(part.channels)
    if not found:  # the library leaves out what it cannot read
        raise ValueError("its pixels are damaged or cut off")
    raise ValueError(f"none of its channels make a picture: {', '.join(found)}; save R, G, B or Y")


def _picture_channels(names: set[str]) -> list[str]:
    """Return the names of the channels that are the picture, none if that is not clear."""
    layers = [name[:-1] for name in names if {name[:-1] + color for color in "RGB"} <= names]
    layers = sorted({layer for layer in layers if layer + "R" in names})
    if "" in layers or len(layers) == 1:
        layer = "" if "" in layers else layers[0]
        return [layer + color for color in "RGB"]
    if "Y" in names:
        return ["Y"]
    return list(names) if len(names) == 1 else []


def _fill_display_window(pixels: np.ndarray, header: dict) -> np.ndarray:
    """Return the picture that the display window frames; the data window may be smaller or larger."""
    data_left, data_top, *data_size = _window(header, "dataWindow")
    left, top, width, height = _window(header, "displayWindow")
    if (data_left, data_top, *data_size) == (left, top, width, height):
        return pixels
    picture = np.zeros((height, width, pixels.shape[2]), np.float32)
    x, y = data_left - left, data_top - top
    rows = slice(max(y, 0), max(min(y + data_size[1], height), 0))
    columns = slice(max(x, 0), max(min(x + data_size[0], width), 0))
    picture[rows, columns] = pixels[rows.start - y : rows.stop - y, columns.start - x : columns.stop - x]
    return picture


def _check_channels(path: str | Path, arrays: Mapping[str, np.ndarray]) -> None:
    """Refuse channels that do not fit together."""
    shapes = {name: array.shape for name, array in arrays.items()}
    depths = {name: {"RGB": (3,), "RGBA": (4,)}.get(name, ()) for name in arrays}
    sizes = {shape[:2] for shape in shapes.values()}
    wrong = [name for name, shape in shapes.items() if len(shape) < 2 or shape[2:] != depths[name]]
    if wrong or len(sizes) != 1 or 0 in next(iter(sizes)):
        found = ", ".join(f"{name} {shape}" for name, shape in shapes.items()) or "none"
        raise ValueError(f"{path} needs channels of one shape (rows, columns), RGB with 3 more, not {found}")


def _check_half(path: str | Path, arrays: Mapping[str, np.ndarray]) -> None:
    """Refuse values that would become infinite."""
    for name, array in arrays.items():
        largest = np.abs(array, where=np.isfinite(array), out=np.zeros(array.shape)).max()
        if largest > LARGEST_HALF:
            raise ValueError(f"{path}: {name} holds {largest:g}, half floats end at {LARGEST_HALF:g}: use half=False")
