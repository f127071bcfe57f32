"""Write volumes as ``.nvdb``: sparse, named, with their place in the world."""

import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from warpfluid.files.atomic import replacing
from warpfluid.files.nvdb import layout
from warpfluid.files.vdb.layout import LEAF, LOWER, UPPER, to_file_axes
from warpfluid.files.vdb.leaves import Leaves, active_box, address, find_leaves

HAS_BOX = 2  # flag of a node
LOWEST, HIGHEST = np.finfo(np.float32).min, np.finfo(np.float32).max


def write_nvdb(
    path: str | Path,
    grids: Mapping[str, np.ndarray],
    *,
    voxel_size: float = 1.0,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    threshold: float | Mapping[str, float] = 0.0,
    up: Literal["y", "z"] = "y",
    packed: bool = True,
) -> None:
    """Write grids of one lattice as a NanoVDB file.

    Args:
        path: The file to write; its folder must exist.
        grids: Arrays by name, shape (x, y, z) or (x, y, z, 3), y up.
        voxel_size: Side of a voxel [world unit].
        origin: Where the centre of voxel (0, 0, 0) lies [world unit], y up.
        threshold: A voxel is dropped when no component of it is further from zero; one number, or by name.
        up: The file's up axis; ``z`` turns the whole volume, vectors included: (x, y, z) becomes (x, -z, y).
        packed: Pack the grids with zlib; programs without it want them plain.

    Raises:
        ValueError: If an argument does not fit, or a grid is not finite.
        OSError: If the file cannot be written.
    """
    x, y, z = (float(place) for place in origin)
    shift = (x, y, z) if up == "y" else (x, 0 - z, y)
    parts = []
    for name, grid in grids.items():
        if not np.isfinite(grid).all():
            raise ValueError(f"grid {name!r} holds NaN or infinity; clean it first")
        if len(name.encode()) >= layout.NAME_BYTES:
            raise ValueError(f"the grid name {name[:20]!r}... is too long; use fewer than {layout.NAME_BYTES} bytes")
        limit = threshold.get(name, 0.0) if isinstance(threshold, Mapping) else threshold
        turned, first = to_file_axes(np.asarray(grid, np.float32), up)
        blob = _grid(name, find_leaves(turned, first, limit), voxel_size, shift)
        data = zlib.compress(blob, 1) if packed else blob
        data = len(data).to_bytes(8, "little") + data if packed else data
        head = np.array((layout.MAGIC, layout.VERSION, 1, int(packed)), layout.FILE_HEAD)  # old readers want one grid
        parts += [head.tobytes(), _entry(blob, len(data), packed).tobytes(), name.encode() + b"\0", data]
    with replacing(path) as file:
        for part in parts:
            file.write(part)


@dataclass(frozen=True)
class _Level:
    """Nodes of one level, and where each stands in its parent's table."""

    first: np.ndarray  # (node, 3)
    parent: np.ndarray  # (node,)
    place: np.ndarray  # (node,)


def _grid(name: str, leaves: Leaves, size: float, shift: tuple) -> bytes:
    """Return a grid as it lies in memory."""
    components = leaves.values.shape[1]
    leaves, uppers, lowers, bottom = _levels(leaves)
    types = [layout.node_type(components, 32), layout.node_type(components, 16), layout.leaf_type(components)]
    root, tile = layout.root_type(components), layout.tile_type(components)
    counts = [len(level.first) for level in (uppers, lowers, bottom)]
    starts = np.cumsum([layout.TREE.itemsize, root.itemsize + counts[0] * tile.itemsize])
    starts = np.cumsum([starts[1], *(n * kind.itemsize for n, kind in zip(counts, types, strict=True))])
    low = _leaf_nodes(leaves, types[2])
    mid = _inner_nodes(lowers, types[1], bottom, low["head"], starts[2] - starts[1], LOWER)
    top = _inner_nodes(uppers, types[0], lowers, mid["head"], starts[1] - starts[0], UPPER)
    head = np.zeros((), root)
    head["tiles"], head["box"] = counts[0], [[2**31 - 1] * 3, [-(2**31)] * 3]
    _sum_up(head, top["head"], slice(None))
    table = np.zeros(counts[0], tile)
    table["key"] = _keys(uppers.first)
    table["child"] = root.itemsize + counts[0] * tile.itemsize + np.arange(counts[0]) * types[0].itemsize
    tree = np.zeros((), layout.TREE)
    tree["offset"] = [starts[2], starts[1], starts[0], layout.TREE.itemsize]
    tree["nodes"], tree["active"] = counts[::-1], len(leaves.values)
    parts = [part.tobytes() for part in (tree, head, table, top, mid, low)]
    total = layout.GRID.itemsize + sum(map(len, parts))
    box = active_box(leaves.first, leaves.active)
    return b"".join([_grid_head(name, total, box, size, shift, components).tobytes(), *parts])


def _levels(leaves: Leaves) -> tuple[Leaves, _Level, _Level, _Level]:
    """Return the leaves in the order of the root's keys, and the three levels of nodes."""
    keys = _keys(leaves.first)
    order = np.argsort(keys, kind="stable")  # within an upper node the order is right already
    values = np.split(leaves.values, np.cumsum(leaves.active.sum(1))[:-1]) if len(order) else []
    values = np.concatenate([values[row] for row in order]) if len(order) else leaves.values
    leaves, keys = Leaves(leaves.first[order], leaves.active[order], values), keys[order]
    upper, lower, leaf = address(leaves.first)
    begins_upper = np.flatnonzero(np.diff(keys.astype(np.int64), prepend=-1))
    begins_lower = np.flatnonzero(np.diff(keys.astype(np.int64) * 32**3 + lower, prepend=-1))
    none = np.zeros(len(begins_upper), np.int64)
    return (
        leaves,
        _Level(upper[begins_upper] * UPPER, none, none),
        _Level(
            leaves.first[begins_lower] // LOWER * LOWER,
            np.searchsorted(begins_upper, begins_lower, "right") - 1,
            lower[begins_lower],
        ),
        _Level(leaves.first, np.searchsorted(begins_lower, np.arange(len(leaf)), "right") - 1, leaf),
    )


def _keys(first: np.ndarray) -> np.ndarray:
    """Return the root's keys of the cubes of 4096 that hold voxels, uint64."""
    x, y, z = ((first // UPPER) & (2**20 - 1)).T.astype(np.uint64)
    return x << np.uint64(42) | y << np.uint64(21) | z


def _leaf_nodes(leaves: Leaves, kind: np.dtype) -> np.ndarray:
    nodes = np.zeros(len(leaves.first), kind)
    values, components = nodes["values"], leaves.values.shape[1]
    values[leaves.active] = leaves.values
    head = nodes["head"]
    for axis in range(3):
        others = tuple(1 + other for other in range(3) if other != axis)
        lit = leaves.active.reshape(-1, LEAF, LEAF, LEAF).any(others)
        low, high = lit.argmax(1), LEAF - 1 - lit[:, ::-1].argmax(1)
        head["first"][:, axis], head["extent"][:, axis] = leaves.first[:, axis] + low, high - low
    head["flags"] = HAS_BOX
    head["active"] = np.packbits(leaves.active, axis=-1, bitorder="little")
    if components == 1:
        head["low"] = np.where(leaves.active, values[..., 0], HIGHEST).min(1, keepdims=True)
        head["high"] = np.where(leaves.active, values[..., 0], LOWEST).max(1, keepdims=True)
    return nodes


def _inner_nodes(level: _Level, kind: np.dtype, children: _Level, heads: np.ndarray, gap: int, side: int) -> np.ndarray:
    """Return the nodes of a level, each with the places of its children."""
    nodes = np.zeros(len(level.first), kind)
    head, table = nodes["head"], nodes["table"]
    child = np.zeros((len(nodes), table.shape[1]), bool)
    child[children.parent, children.place] = True
    head["child"] = np.packbits(child, axis=-1, bitorder="little")
    head["flags"] = HAS_BOX
    size = heads.base.dtype.itemsize
    far = gap + np.arange(len(heads)) * size - children.parent * kind.itemsize
    table[children.parent, children.place, :8] = far.astype("<i8")[:, None].view(np.uint8)
    bounds = np.searchsorted(children.parent, np.arange(len(nodes) + 1))
    for row in range(len(nodes)):
        head["box"][row] = [level.first[row] + side - 1, level.first[row]]
        _sum_up(head[row : row + 1], heads, slice(bounds[row], bounds[row + 1]))
    return nodes


def _sum_up(head: np.ndarray, heads: np.ndarray, rows: slice) -> None:
    """Give a node the box and the range of its children, in place."""
    if not len(heads[rows]):
        return
    below = heads[rows]
    leaf = "first" in heads.dtype.names
    low = below["first"] if leaf else below["box"][:, 0]
    high = below["first"] + below["extent"] if leaf else below["box"][:, 1]
    head["box"] = [low.min(0), high.max(0)]
    head["low"], head["high"] = below["low"].min(0), below["high"].max(0)


def _grid_head(name: str, total: int, box: np.ndarray | None, size: float, shift: tuple, components: int) -> np.ndarray:
    head, kind = np.zeros((), layout.GRID), "float" if components == 1 else "vec3s"
    head["magic"], head["checksum"], head["version"] = layout.MAGIC, layout.NO_CHECKSUM, layout.VERSION
    head["flags"] = layout.HAS_BOX | layout.BREADTH_FIRST | (layout.HAS_RANGE if components == 1 else 0)
    head["count"] = 1
    head["size"] = head["blind_offset"] = total
    head["name"] = name.encode()
    matrix = head["map"]
    matrix["matrix"] = matrix["matrix_f"] = np.eye(3) * size
    matrix["inverse"] = matrix["inverse_f"] = np.eye(3) / size
    matrix["shift"] = matrix["shift_f"] = shift
    matrix["taper"] = matrix["taper_f"] = 1
    if box is not None:
        head["world_box"] = np.asarray(shift) + size * np.stack([box[0], box[1] + 1])
    head["voxel_size"] = size
    head["class"], head["type"] = (layout.FOG_VOLUME if components == 1 else layout.UNKNOWN), layout.TYPES[kind]
    return head


def _entry(blob: bytes, size: int, packed: bool) -> np.ndarray:
    """Return what the file's head says of a grid."""
    grid = np.frombuffer(blob, layout.GRID, 1)[0]
    tree = np.frombuffer(blob, layout.TREE, 1, layout.GRID.itemsize)[0]
    box = np.frombuffer(blob, "<i4", 6, layout.GRID.itemsize + layout.TREE.itemsize).reshape(2, 3)
    entry = np.zeros((), layout.GRID_ENTRY)
    entry["memory"], entry["size"], entry["active"] = len(blob), size, tree["active"]
    entry["name_hash"] = layout.name_hash(grid["name"].decode())
    entry["name_bytes"] = len(grid["name"]) + 1
    for name in ("type", "class", "world_box", "voxel_size", "version"):
        entry[name] = grid[name]
    entry["box"], entry["nodes"] = box, [*tree["nodes"], 1]
    entry["codec"] = int(packed)
    return entry
