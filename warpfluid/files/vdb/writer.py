"""Write volumes as ``.vdb``, with NumPy and zlib alone."""

import struct
import zlib
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Literal

import numpy as np

from warpfluid.files.atomic import replacing
from warpfluid.files.vdb import layout
from warpfluid.files.vdb.leaves import Leaves, active_box, address, find_leaves

COMPRESSION = layout.ZIP | layout.ACTIVE_MASK
LIBRARY = (10, 0)  # the OpenVDB whose layout this is
NO_OFFSETS = struct.pack("<3q", 0, 0, 0)
LARGEST_HALF = 65504.0
LEAVES_A_JOB = 64  # packed by one thread: zlib lets others work meanwhile


def write_vdb(
    path: str | Path,
    grids: Mapping[str, np.ndarray],
    *,
    voxel_size: float = 1.0,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    half: bool = False,
    threshold: float | Mapping[str, float] = 0.0,
    up: Literal["y", "z"] = "y",
    metadata: Mapping[str, float | int | str | bool] | None = None,
) -> None:
    """Write grids of one lattice as an OpenVDB file.

    Only voxels above the threshold are stored. The same data give the same bytes, and the file appears whole
    or not at all. Scalar grids are fog volumes, vector grids are velocities (``contravariant relative``);
    Blender knows ``density``, ``temperature``, ``flame`` and ``velocity`` by name.

    Args:
        path: The file to write; its folder must exist.
        grids: Arrays by name, shape (x, y, z) or (x, y, z, 3), all of one size, y up.
        voxel_size: Side of a voxel [world unit].
        origin: Where the centre of voxel (0, 0, 0) lies [world unit], y up.
        half: Store 16-bit floats: half the size, three digits.
        threshold: A voxel is dropped when its value, or every component of it, is no further from zero than
            this; one number for all grids, or by name, 0 where a name is missing.
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
        if not limit >= 0:
            raise ValueError(f"the threshold of grid {name!r} is {limit!r}; it must be 0 or more")
        turned, first = layout.to_file_axes(array, up)
        facts = {layout.SHAPE_KEY: array.shape[:3], layout.UP_KEY: up}
        _append_grid(file, name, find_leaves(turned, first, limit), facts, transform, half)
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
        raise ValueError(f"the grids of a file must have one shape, not {shapes}; write several files")
    return arrays


def _checked_grid(name: str, array: np.ndarray, half: bool) -> np.ndarray:
    array = np.asarray(array)
    if not (isinstance(name, str) and name and name.isprintable()):
        raise ValueError(f"the grid name {name!r} is not a word; use one such as 'density'")
    if array.ndim not in (3, 4) or array.shape[3:] not in ((), (3,)) or not array.size:
        raise ValueError(f"grid {name!r} has shape {array.shape}; it must be (x, y, z) or (x, y, z, 3)")
    if array.dtype.kind not in "fiub":
        raise ValueError(f"grid {name!r} holds {array.dtype}; convert it to float32")
    with np.errstate(over="ignore"):
        array = array.astype(np.float32, copy=False)
    if not np.isfinite(array).all():
        raise ValueError(f"grid {name!r} holds NaN, infinity or more than float32 can; clean it first")
    if half and max(array.max(), -array.min()) > LARGEST_HALF:
        raise ValueError(f"grid {name!r} exceeds {LARGEST_HALF:g}, the largest half; scale it or use half=False")
    return array


def _append_grid(file: bytearray, name: str, leaves: Leaves, facts: dict, transform: bytes, half: bool) -> None:
    """Append one grid: where its parts stand, then metadata, transform, topology, buffers."""
    components = leaves.values.shape[1]
    tree = next(tree for tree, count in layout.TREES.items() if count == components)
    file += _text(name) + _text(tree + layout.HALF_SUFFIX * half) + _text("")
    offsets = slice(len(file), len(file) + len(NO_OFFSETS))
    file += NO_OFFSETS
    start = len(file)
    file += struct.pack("<I", COMPRESSION) + _metadata(facts | _grid_facts(name, leaves, half)) + transform
    for part in _topology(leaves, components, half):
        file += part
    blocks = len(file)
    for part in _buffers(leaves, half):
        file += part
    file[offsets] = struct.pack("<3q", start, blocks, len(file))


def _topology(leaves: Leaves, components: int, half: bool) -> Iterator[bytes]:
    """Yield the background, zero, and the nodes from the root down; neither root nor nodes have tiles."""
    upper, lower, leaf = address(leaves.first)
    masks = np.packbits(leaves.active, axis=-1, bitorder="little")
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
    packed = np.packbits(mask, bitorder="little").tobytes()
    # An empty block of values is a length of zero, but for half nothing at all: that is how OpenVDB reads it.
    return packed + bytes(places // 8) + b"\0" + (b"" if half else _zip(b""))


def _buffers(leaves: Leaves, half: bool) -> Iterator[bytes]:
    """Yield each leaf's mask, a zero for "the other voxels hold the background", and its active values."""
    masks = np.packbits(leaves.active, axis=-1, bitorder="little").tobytes()
    values = leaves.values.astype("<f2" if half else "<f4")
    ends = np.cumsum(leaves.active.sum(-1)) * values.itemsize * values.shape[1]
    values = values.tobytes()
    ends = [0, *ends.tolist()]

    def pack(first: int) -> bytes:
        rows = range(first, min(first + LEAVES_A_JOB, len(ends) - 1))
        return b"".join(
            masks[64 * row : 64 * row + 64] + b"\0" + _zip(values[ends[row] : ends[row + 1]]) for row in rows
        )

    with ThreadPoolExecutor() as pool:
        yield from pool.map(pack, range(0, len(ends) - 1, LEAVES_A_JOB))


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
    shift = (x, y, z) if up == "y" else (x, 0 - z, y)
    scales = (size, size, 1 / size, 1 / size**2, 0.5 / size)  # scale, voxel size, three shortcuts of OpenVDB
    return _text("UniformScaleTranslateMap") + struct.pack("<18d", *shift, *np.repeat(scales, 3))


def _grid_facts(name: str, leaves: Leaves, half: bool) -> dict:
    """Return the metadata that OpenVDB keeps with a grid."""
    vector = leaves.values.shape[1] == 3
    box = active_box(leaves.first, leaves.active)
    low, high = ([0, 0, 0], [-1, -1, -1]) if box is None else box.tolist()  # OpenVDB's way to say "none"
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
        raise ValueError(f"metadata {name!r} is {value!r}; it must be text, bool, float or a 64-bit integer")
    return kind, struct.pack(layout.METADATA[kind], value)


def _text(value: str | bytes) -> bytes:
    data = value.encode() if isinstance(value, str) else value
    return struct.pack("<I", len(data)) + data
