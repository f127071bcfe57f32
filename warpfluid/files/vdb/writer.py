"""Write volumes as ``.vdb``, with NumPy and zlib alone."""

import struct
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warpfluid.files.atomic import replacing
from warpfluid.files.vdb import layout

Metadata = Mapping[str, float | int | str | bool]

COMPRESSION = layout.ZIP | layout.ACTIVE_MASK
LIBRARY = (10, 0)  # the OpenVDB whose layout this is
NO_OFFSETS = struct.pack("<3q", 0, 0, 0)
LARGEST_HALF = 65504.0


def write_vdb(
    path: str | Path,
    grids: Mapping[str, np.ndarray],
    *,
    voxel_size: float = 1.0,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    half: bool = False,
    threshold: float | Mapping[str, float] = 0.0,
    up: str = "y",
    metadata: Metadata | None = None,
) -> None:
    """Write grids of one lattice as an OpenVDB file.

    Only voxels above the threshold are stored. The same data give the same bytes, and the file appears whole or not
    at all. Scalar grids are fog volumes, vector grids are velocities (``contravariant relative``); Blender knows
    ``density``, ``temperature``, ``flame`` and ``velocity`` by name.

    Args:
        path: The file to write; its folder must exist.
        grids: Arrays by name, shape (x, y, z) or (x, y, z, 3), all of one size, y up.
        voxel_size: Side of a voxel [world unit].
        origin: Where the centre of voxel (0, 0, 0) lies [world unit], y up.
        half: Store 16-bit floats: half the size, three digits.
        threshold: A voxel is dropped when its value, or every component of it, is no further from zero than this;
            one number for all grids, or by name, 0 where a name is missing.
        up: The file's up axis: ``y`` for Houdini and Maya, ``z`` for Blender. ``z`` turns the whole volume,
            vectors included: (x, y, z) becomes (x, -z, y).
        metadata: Facts to store with the file, by name.

    Raises:
        ValueError: If an argument does not fit, or a grid holds NaN or infinity.
        OSError: If the file cannot be written.
    """
    if up not in ("y", "z"):
        raise ValueError(f"up is {up!r}; it must be 'y' (Houdini, Maya) or 'z' (Blender)")
    transform = _transform(voxel_size, origin, up)
    arrays = _checked(grids, half)
    file = bytearray(struct.pack("<qIII?", layout.MAGIC, layout.VERSION, *LIBRARY, True))
    file += bytes(layout.ID.stop - layout.ID.start)
    file += _metadata({"creator": layout.CREATOR, **(metadata or {})}) + struct.pack("<i", len(arrays))
    for name, array in arrays.items():
        limit = threshold.get(name, 0.0) if isinstance(threshold, Mapping) else threshold
        _append_grid(file, name, array, transform, half, float(limit), up)
    file[layout.ID] = layout.content_id(file)
    with replacing(path) as out:
        out.write(file)


def lost_mass(volume: np.ndarray, threshold: float) -> float:
    """Return the share of a volume's mass, 0 to 1, that writing it with ``threshold`` drops."""
    size = np.abs(volume)
    total = size.sum(dtype=np.float64)
    return float(size.sum(where=size <= threshold, dtype=np.float64) / total) if total else 0.0


def _checked(grids: Mapping[str, np.ndarray], half: bool) -> dict[str, np.ndarray]:
    """Return the grids as float32, or say what is wrong with them."""
    if not grids:
        raise ValueError("grids is empty; give at least one array, such as {'density': volume}")
    arrays = {name: _checked_grid(name, array, half) for name, array in grids.items()}
    shapes = {name: array.shape[:3] for name, array in arrays.items()}
    if len(set(shapes.values())) > 1:
        raise ValueError(f"the grids of one file share one lattice, but their shapes are {shapes}; write several files")
    return arrays


def _checked_grid(name: str, array: np.ndarray, half: bool) -> np.ndarray:
    array = np.asarray(array)
    if not isinstance(name, str) or not name:
        raise ValueError(f"the grid name {name!r} is not a word; use one such as 'density'")
    if array.ndim not in (3, 4) or array.shape[3:] not in ((), (3,)) or not array.size:
        raise ValueError(f"grid {name!r} has shape {array.shape}; it must be (x, y, z) or (x, y, z, 3), not empty")
    if array.dtype.kind not in "fiub":
        raise ValueError(f"grid {name!r} holds {array.dtype}; convert it to float32")
    with np.errstate(over="ignore"):
        array = array.astype(np.float32, copy=False)
    if not np.isfinite(array).all():
        raise ValueError(f"grid {name!r} holds NaN, infinity or numbers too large for float32; clean it first")
    if half and max(array.max(), -array.min()) > LARGEST_HALF:
        raise ValueError(f"grid {name!r} exceeds {LARGEST_HALF:g}, the largest half; scale it or write half=False")
    return array


def _append_grid(
    file: bytearray, name: str, array: np.ndarray, transform: bytes, half: bool, threshold: float, up: str
) -> None:
    """Append one grid: where its parts stand, then metadata, transform, topology, buffers."""
    turned, first = layout.to_file_axes(array, up)
    leaves = _find_leaves(turned, first, threshold)
    components = leaves.values.shape[1]
    facts = _grid_facts(name, leaves, half) | {layout.SHAPE_KEY: array.shape[:3], layout.UP_KEY: up}
    tree = next(tree for tree, count in layout.TREES.items() if count == components)
    file += _text(name) + _text(tree + layout.HALF_SUFFIX * half) + _text("")
    offsets = slice(len(file), len(file) + len(NO_OFFSETS))
    file += NO_OFFSETS
    start = len(file)
    file += struct.pack("<I", COMPRESSION) + _metadata(facts) + transform
    for part in _topology(leaves, components, half):
        file += part
    blocks = len(file)
    for part in _buffers(leaves, half):
        file += part
    file[offsets] = struct.pack("<3q", start, blocks, len(file))


# ---- cutting an array into leaves


@dataclass(frozen=True)
class _Leaves:
    """The blocks of 8^3 voxels that hold something, in the order of the tree."""

    first: np.ndarray  # index of the first voxel, shape (leaf, 3)
    masks: np.ndarray  # active voxels, shape (leaf, 512)
    values: np.ndarray  # values of active voxels, leaf after leaf, shape (voxel, components)

    @property
    def box(self) -> tuple[list[int], list[int]]:
        """The first and last index of active voxels; OpenVDB's way to say "none" is a last before the first."""
        if not len(self.first):
            return [0, 0, 0], [-1, -1, -1]
        cubes = self.masks.reshape(-1, layout.LEAF, layout.LEAF, layout.LEAF)
        low, high = [], []
        for axis in range(3):
            others = tuple(1 + other for other in range(3) if other != axis)
            index = (self.first[:, axis, None] + np.arange(layout.LEAF))[cubes.any(others)]
            low.append(int(index.min()))
            high.append(int(index.max()))
        return low, high


def _find_leaves(array: np.ndarray, first: np.ndarray, threshold: float) -> _Leaves:
    """Cut an array, whose first voxel has the index ``first``, into the leaves that hold an active voxel."""
    values = array.reshape(*array.shape[:3], -1)
    active = (np.abs(values) > threshold).any(-1)
    front = first % layout.LEAF
    padding = [(int(f), int(-(f + side) % layout.LEAF)) for f, side in zip(front, active.shape, strict=True)]
    cubes = _blocks(np.pad(active, padding))
    occupied = np.argwhere(cubes.any((3, 4, 5)))
    leaves = first - front + occupied * layout.LEAF
    order = np.lexsort(np.column_stack(_address(leaves)).T[::-1])
    occupied = tuple(occupied[order].T)
    masks = cubes[occupied]
    values = _blocks(np.pad(values, [*padding, (0, 0)]))[occupied][masks]
    return _Leaves(leaves[order], masks.reshape(-1, layout.LEAF_VOXELS), values)


def _blocks(array: np.ndarray) -> np.ndarray:
    """View a padded array (x, y, z, ...) as cubes, shape (x/8, y/8, z/8, 8, 8, 8, ...)."""
    x, y, z = (side // layout.LEAF for side in array.shape[:3])
    split = array.reshape(x, layout.LEAF, y, layout.LEAF, z, layout.LEAF, *array.shape[3:])
    return split.transpose(0, 2, 4, 1, 3, 5, *range(6, split.ndim))


def _address(leaves: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return each leaf's way down the tree: upper node (x, y, z), place of the lower node in it, of the leaf in that."""
    lower = leaves % layout.UPPER // layout.LOWER @ [32 * 32, 32, 1]
    leaf = leaves % layout.LOWER // layout.LEAF @ [16 * 16, 16, 1]
    return leaves // layout.UPPER, lower, leaf


# ---- the parts of a grid


def _topology(leaves: _Leaves, components: int, half: bool) -> Iterator[bytes]:
    """Yield the background, zero, and the nodes from the root down; neither root nor nodes have tiles."""
    upper, lower, leaf = _address(leaves.first)
    masks = np.packbits(leaves.masks, axis=-1, bitorder="little")
    runs = _runs(upper)
    yield struct.pack("<i", 1) + bytes(4 * components) + struct.pack("<2I", 0, len(runs))
    for run in runs:
        yield struct.pack("<3i", *(upper[run.start] * layout.UPPER)) + _inner_node(32**3, lower[run], half)
        for inner in _runs(lower[run, None]):
            rows = slice(run.start + inner.start, run.start + inner.stop)
            yield _inner_node(16**3, leaf[rows], half)
            yield masks[rows].tobytes()


def _runs(keys: np.ndarray) -> list[slice]:
    """Return the runs of equal rows."""
    if not len(keys):
        return []
    bounds = np.flatnonzero((keys[1:] != keys[:-1]).any(-1)) + 1
    return [slice(*run) for run in zip([0, *bounds.tolist()], [*bounds.tolist(), len(keys)], strict=True)]


def _inner_node(places: int, children: np.ndarray, half: bool) -> bytes:
    """Return a node: which places have children, which are active tiles (none), the values of those."""
    mask = np.zeros(places, bool)
    mask[children] = True
    # An empty block of values is a length of zero; but for half nothing at all, that is how OpenVDB reads it.
    return np.packbits(mask, bitorder="little").tobytes() + bytes(places // 8) + b"\0" + (b"" if half else _zip(b""))


def _buffers(leaves: _Leaves, half: bool) -> Iterator[bytes]:
    """Yield each leaf's mask, a zero for "the other voxels hold the background", and its active values."""
    masks = np.packbits(leaves.masks, axis=-1, bitorder="little").tobytes()
    values = leaves.values.astype("<f2" if half else "<f4")
    ends = np.cumsum(leaves.masks.sum(-1)) * values.itemsize * values.shape[1]
    values, start = values.tobytes(), 0
    for row, end in enumerate(ends.tolist()):
        yield masks[64 * row : 64 * row + 64] + b"\0" + _zip(values[start:end])
        start = end


def _zip(data: bytes) -> bytes:
    """Return data with its length in front, packed where that helps; a negative length means as it is."""
    packed = zlib.compress(data, 1)
    if len(packed) < len(data):
        return struct.pack("<q", len(packed)) + packed
    return struct.pack("<q", -len(data)) + data


def _transform(voxel_size: float, origin: tuple[float, float, float], up: str) -> bytes:
    """Return the map from indices to the world: a uniform scale and a shift."""
    size, place = float(voxel_size), np.asarray(origin, np.float64)
    if not (np.isfinite(size) and size > 0):
        raise ValueError(f"voxel_size is {voxel_size!r}; it must be a positive number")
    if place.shape != (3,) or not np.isfinite(place).all():
        raise ValueError(f"origin is {origin!r}; it must be three finite numbers")
    x, y, z = place
    shift = (x, y, z) if up == "y" else (x, -z, y)
    scales = (size, size, 1 / size, 1 / size**2, 0.5 / size)  # scale, voxel size, and three of OpenVDB's shortcuts
    return _text("UniformScaleTranslateMap") + struct.pack("<18d", *shift, *np.repeat(scales, 3))


def _grid_facts(name: str, leaves: _Leaves, half: bool) -> dict:
    """Return the metadata that OpenVDB keeps with a grid."""
    vector = leaves.values.shape[1] == 3
    low, high = leaves.box
    facts = {
        "class": "unknown" if vector else "fog volume",
        "file_bbox_max": high,
        "file_bbox_min": low,
        "file_compression": "zip + active values",
        "file_voxel_count": len(leaves.values),
        "is_saved_as_half_float": half,
        "name": name,
    }
    return facts | ({"vector_type": "contravariant relative"} if vector else {})


def _metadata(facts: Mapping[str, object]) -> bytes:
    """Return facts with their types, in the order of their names."""
    parts = [struct.pack("<I", len(facts))]
    for name in sorted(facts):
        kind, data = _typed(name, facts[name])
        parts += [_text(name), _text(kind), _text(data)]
    return b"".join(parts)


def _typed(name: str, value: object) -> tuple[str, bytes]:
    """Return the OpenVDB type of a value and its bytes."""
    value = value.item() if isinstance(value, np.generic) else value
    if isinstance(value, str):
        return "string", value.encode()
    if isinstance(value, list | tuple):
        return "vec3i", struct.pack("<3i", *value)
    kind = {bool: "bool", int: "int64", float: "double"}.get(type(value))
    if kind is None or (kind == "int64" and not -(2**63) <= value < 2**63):
        raise ValueError(f"metadata {name!r} is {value!r}; only text, bool, float and 64-bit integers can be stored")
    return kind, struct.pack(layout.METADATA[kind], value)


def _text(value: str | bytes) -> bytes:
    data = value.encode() if isinstance(value, str) else value
    return struct.pack("<I", len(data)) + data
