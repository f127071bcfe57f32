"""Read ``.vti`` files: image data in one piece, whose values stand at points or in cells."""

import math
import re
from dataclasses import dataclass
from html import unescape
from pathlib import Path

import numpy as np

from warpfluid.files.grids import GridFacts, GridFile
from warpfluid.files.limits import check_promise, is_voxel_size
from warpfluid.files.vti.values import Values

HEAD = 2**20  # bytes before which the values begin, if they do not stand among the tags
STRAIGHT = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
FARTHEST = 2**31  # index that a voxel may have
KINDS = {1: "float", 3: "vec3s"}  # by components


@dataclass(frozen=True)
class _Image:
    """What the tags say.

    Attributes:
        first: Index of the first voxel, shape (3,).
        shape: Voxels (x, y, z).
        spacing: Sides of a voxel, shape (3,).
        shift: Where the voxel of index (0, 0, 0) has its centre, shape (3,).
        cubes: Whether voxels are upright cubes.
        at_points: Whether values stand at points, or in cells.
        head: Attributes of the whole file.
        arrays: Attributes of every array, and what stands between its tags.
    """

    first: np.ndarray
    shape: tuple[int, ...]
    spacing: np.ndarray
    shift: np.ndarray
    cubes: bool
    at_points: bool
    head: dict[str, str]
    arrays: list[tuple[dict[str, str], bytes]]

    @property
    def about(self) -> dict[str, str]:
        return {"values": "at points" if self.at_points else "in cells"}


def read_vti(path: str | Path) -> GridFile:
    """Read image data whose values stand at points or in cells.

    Raises:
        ValueError: If this is no such file, it is damaged, has no arrays or no cubes for voxels.
        OSError: If the file cannot be read.
    """
    data = Path(path).read_bytes()
    image = _parse(path, data)
    if not image.cubes:
        raise ValueError(f"{path}: its voxels are {image.spacing.tolist()}, no cubes; resample it")
    try:
        grids = _grids(image, Values(data, image.head))
    except ValueError as error:
        raise ValueError(f"{path}: the file is damaged: {error}") from error
    origin = image.shift + image.spacing * image.first
    return GridFile(
        grids=grids, voxel_size=float(image.spacing[0]), origin=tuple(origin.tolist()), metadata=dict(image.about)
    )


def vti_facts(path: str | Path) -> list[GridFacts]:
    """Return what is known of every array of a file, from the tags before the values.

    Raises:
        ValueError: If this is no such file, or it is damaged.
        OSError: If it cannot be read.
    """
    with open(path, "rb") as file:
        head = file.read(HEAD)
        image = _parse(path, head if b"<AppendedData" in head else head + file.read())
    box = np.array([image.first, image.first + image.shape - 1])
    return [
        GridFacts(
            name=array.get("Name", ""),
            kind=KINDS.get(_components(array), "other"),
            half=False,
            voxel_size=float(image.spacing[0]) if image.cubes else None,
            shift=tuple(image.shift.tolist()),
            box=box,
            whole=box,
            active=None,
            up=None,
            about=dict(image.about),
        )
        for array, _ in image.arrays
    ]


def _grids(image: _Image, values: Values) -> dict[str, np.ndarray]:
    """Return the arrays of numbers and of vectors, shape (x, y, z[, 3])."""
    voxels, size = math.prod(image.shape), len(values.data)
    arrays = [(array, inside, _components(array)) for array, inside in image.arrays]
    check_promise(4 * voxels * sum(components for *_, components in arrays), size)
    found = {}
    for array, inside, components in arrays:
        if components in KINDS:
            numbers = values.read(array, inside, voxels * components)
            turned = numbers.reshape(*image.shape[::-1], *((3,) if components == 3 else ()))  # x runs fastest
            with np.errstate(over="ignore"):
                found[array.get("Name", "")] = np.ascontiguousarray(np.swapaxes(turned, 0, 2), np.float32)
    if not found:
        raise ValueError("it has no arrays of numbers or vectors")
    return found


def _parse(path: str | Path, data: bytes) -> _Image:
    """Return what the tags say."""
    text = data.split(b"<AppendedData")[0]
    try:
        whole = _attributes(re.search(_tag("ImageData"), text)[1])
        extent, origin, spacing = _extent(whole["WholeExtent"]), _numbers(whole["Origin"]), _numbers(whole["Spacing"])
        first, last = extent.T
        pieces = [_attributes(tag) for tag in re.findall(_tag("Piece"), text)]
        found = re.findall(rb"<(PointData|CellData)\b[^>]*>(.*?)</\1>", text, re.DOTALL)
        kind, body = next(part for part in found if b"<DataArray" in part[1])
        (other,) = (_extent(piece["Extent"]) for piece in pieces)
        sound = len(origin) == len(spacing) == 3 and np.isfinite([*origin, *spacing]).all()
        if not sound or (other != extent).any():
            raise ValueError("its numbers do not fit together")
        straight = _numbers(whole.get("Direction", "")).tolist() in ([], STRAIGHT)
        head = _attributes(re.search(_tag("VTKFile"), text)[1])
    except (TypeError, ValueError, KeyError, StopIteration) as error:
        raise ValueError(f"{path}: this is no VTK image data (.vti) in one piece, or it has no arrays") from error
    at_points = kind == b"PointData"
    shape = last - first + (1 if at_points else 0)
    if shape.min() < 1:
        raise ValueError(f"{path}: the file is damaged: {shape.tolist()} voxels")
    cubes = bool(straight and is_voxel_size(spacing[0]) and np.allclose(spacing, spacing[0], rtol=1e-5))
    shift = origin + (0 if at_points else 0.5) * spacing
    arrays = re.findall(_tag("DataArray", rb"(?:/>|>(.*?)</DataArray>)"), body, re.DOTALL)
    arrays = [(_attributes(tag), re.sub(rb"<.*>", b"", inside, flags=re.DOTALL)) for tag, inside in arrays]
    return _Image(first, tuple(shape.tolist()), spacing, shift, cubes, at_points, head, arrays)


def _tag(name: str, end: bytes = b">") -> bytes:
    """Return the pattern of a tag, whose attributes may hold any sign but their quotation mark."""
    return rb"<%s\b((?:[^>\"'/]|\"[^\"]*\"|'[^']*')*+)%s" % (name.encode(), end)


def _attributes(tag: bytes) -> dict[str, str]:
    """Return the attributes of a tag."""
    found = re.findall(r"([\w:]+)\s*=\s*(?:\"([^\"]*)\"|'([^']*)')", tag.decode(errors="replace"))
    return {name: unescape(double or single) for name, double, single in found}


def _numbers(text: str) -> np.ndarray:
    return np.array([float(number) for number in text.split()])


def _extent(text: str) -> np.ndarray:
    """Return the first and the last index of every axis, shape (3, 2)."""
    numbers = [int(number) for number in text.split()]
    if len(numbers) != 6 or max(map(abs, numbers)) > FARTHEST:
        raise ValueError("an extent is six numbers")
    return np.array(numbers, np.int64).reshape(3, 2)


def _components(array: dict[str, str]) -> int:
    """Return how many numbers a voxel has, 0 where that cannot be told."""
    text = array.get("NumberOfComponents", "1")
    return int(text) if re.fullmatch(r"\d{1,4}", text) else 0
