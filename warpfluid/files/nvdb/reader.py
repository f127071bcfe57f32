"""Read ``.nvdb`` files: float and vector grids."""

import math
import zlib
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Literal

import numpy as np

from warpfluid.files.grids import GridFacts, GridFile
from warpfluid.files.limits import check_box, check_promise, is_voxel_size
from warpfluid.files.nvdb import layout
from warpfluid.files.vdb.layout import LEAF, LEAF_VOXELS, LOWER, UPPER, from_file_axes
from warpfluid.files.vdb.tree import Tiles, Tree

KINDS = {number: kind for kind, number in layout.TYPES.items()}


def nvdb_facts(path: str | Path) -> list[GridFacts]:
    """Return what is known of every grid of a file, without opening the grids.

    Raises:
        ValueError: If this is no such file, or it is damaged.
        OSError: If it cannot be read.
    """
    return [_facts(path, name, entry) for name, entry, _ in _entries(path, Path(path).read_bytes())]


def read_nvdb(path: str | Path, names: Collection[str] | None = None, *, up: Literal["y", "z"] = "y") -> GridFile:
    """Read the float and vector grids of a NanoVDB file as arrays, cut to the box of their active voxels.

    Args:
        path: The file; plain, or packed with zlib.
        names: The grids to read; all by default.
        up: The file's up axis, of which it tells nothing.

    Returns:
        The grids, and where they lie, y up.

    Raises:
        ValueError: If this is no such file, it is damaged, or a grid is of a kind that is not read.
        OSError: If the file cannot be read.
    """
    names, found = ([names] if isinstance(names, str) else names), {}
    for name, entry, data in _entries(path, Path(path).read_bytes()):
        if names is None or name in names:
            found[name] = _facts(path, name, entry), data
    missing = sorted(set(names or ()) - set(found))
    if missing or not found:
        raise ValueError(f"{path}: the file has no grid {', '.join(missing)}".rstrip() + "; choose among its grids")
    for facts, _ in found.values():
        if not facts.readable:
            raise ValueError(f"{path}: grid {facts.name!r} is of type {facts.kind}; float and vec3s are read")
    try:
        return _read({name: (facts, _open(*data)) for name, (facts, data) in found.items()}, up)
    except (ValueError, zlib.error, IndexError) as error:
        raise ValueError(f"{path}: the file is damaged: {error}") from error


def _entries(path: str | Path, data: bytes) -> Iterator[tuple[str, np.ndarray, tuple[bytes, int, int]]]:
    """Yield every grid's name, its entry in the head, and its data with the packing and the size when open."""
    if len(data) < 16 or int.from_bytes(data[:8], "little") not in layout.MAGICS:
        raise ValueError(f"{path}: this is no NanoVDB file")
    at = 0
    try:
        while at < len(data):
            head = np.frombuffer(data, layout.FILE_HEAD, 1, at)[0]
            if int(head["magic"]) not in layout.MAGICS or int(head["version"]) >> 21 != layout.MAJOR:
                raise ValueError(f"its format is not {layout.MAJOR}; write it again")
            at, listed = at + layout.FILE_HEAD.itemsize, []
            for _ in range(int(head["grids"])):
                entry = np.frombuffer(data, layout.GRID_ENTRY, 1, at)[0]
                at += layout.GRID_ENTRY.itemsize + int(entry["name_bytes"])
                name = data[at - int(entry["name_bytes"]) : at].split(b"\0")[0].decode(errors="replace")
                listed.append((name, entry))
            for name, entry in listed:
                size = int(entry["size"])
                if size > len(data) - at:
                    raise ValueError("the file is cut short")
                check_promise(int(entry["memory"]), len(data))
                yield name, entry, (data[at : at + size], int(head["codec"]), int(entry["memory"]))
                at += size
    except ValueError as error:
        raise ValueError(f"{path}: the file is damaged: {error}") from error


def _facts(path: str | Path, name: str, entry: np.ndarray) -> GridFacts:
    size, box, place = entry["voxel_size"], entry["box"].astype(np.int64), entry["world_box"][0]
    active = int(entry["active"])
    with np.errstate(all="ignore"):
        cubes = bool(is_voxel_size(size[0]) and np.isfinite(size).all() and np.allclose(size, size[0]))
        # The shift of the first voxel follows from both boxes, in voxels and in the world.
        shift = np.round(place - box[0] * size, 12) if active else np.zeros(3)
    if active and ((box[0] > box[1]).any() or (cubes and not np.isfinite(shift).all())):
        raise ValueError(f"{path}: the file is damaged: grid {name!r} has a box of {box.tolist()}")
    return GridFacts(
        name=name,
        kind=KINDS.get(int(entry["type"]), f"number {int(entry['type'])}"),
        half=False,
        voxel_size=float(size[0]) if cubes else None,
        shift=tuple(shift.tolist()),
        box=box if active else None,
        whole=box if active else None,
        active=active,
        up=None,
        about={"class": "fog volume" if entry["class"] == layout.FOG_VOLUME else "unknown"},
    )


def _open(data: bytes, codec: int, size: int) -> bytes:
    if codec not in (layout.PLAIN, layout.ZIP):
        raise ValueError("a grid is packed with Blosc; write it with zip or plain")
    blob = zlib.decompressobj().decompress(data[8:], size + 1) if codec else data
    if len(blob) != size:
        raise ValueError(f"a grid has {len(blob)} bytes where {size} belong")
    return blob


def _read(grids: dict[str, tuple[GridFacts, bytes]], up: str) -> GridFile:
    trees = {name: _tree(facts, blob) for name, (facts, blob) in grids.items()}
    heads = [np.frombuffer(blob, layout.GRID, 1)[0] for _, blob in grids.values()]
    places = {(float(h["voxel_size"][0]), *h["map"]["shift"].tolist()) for h in heads}
    if len(places) > 1:
        raise ValueError(f"the grids {', '.join(grids)} differ in voxel size or place; read them one by one")
    size, *shift = places.pop()
    if not (is_voxel_size(size) and np.isfinite(shift).all()):
        raise ValueError(f"voxels of size {size} at {shift}")
    boxes = [box for box in (tree.box() for tree in trees.values()) if box is not None]
    boxes = boxes or [np.array([[0, 0, 0], [-1, -1, -1]])]
    low, high = np.min(boxes, 0)[0], np.max(boxes, 0)[1]
    check_box(math.prod((high - low + 1).tolist()), sum(tree.stored() for tree in trees.values()))
    origin = np.asarray(shift) + size * low
    if up == "z":
        origin = np.array([origin[0], origin[2], 0 - (shift[1] + size * high[1])])
    arrays = {}
    for name, tree in trees.items():
        dense = tree.fill(low, high)
        arrays[name] = np.ascontiguousarray(from_file_axes(dense if dense.shape[3] == 3 else dense[..., 0], up))
    return GridFile(grids=arrays, voxel_size=size, origin=tuple(origin.tolist()), metadata={})


def _tree(facts: GridFacts, blob: bytes) -> Tree:
    """Return a grid's leaves and tiles."""
    components, start = (1 if facts.kind == "float" else 3), layout.GRID.itemsize
    tree = np.frombuffer(blob, layout.TREE, 1, start)[0]
    root_kind, counts = layout.root_type(components), tree["nodes"].astype(np.int64)
    root = np.frombuffer(blob, root_kind, 1, start + int(tree["offset"][3]))[0]
    kinds = [layout.leaf_type(components), layout.node_type(components, 16), layout.node_type(components, 32)]
    leaves, lowers, uppers = (
        np.frombuffer(blob, kind, int(n), start + int(at)) if n else np.zeros(0, kind)
        for kind, n, at in zip(kinds, counts, tree["offset"][:3], strict=True)
    )
    tiles = [*_tiles(uppers, 32, LOWER, components, UPPER), *_tiles(lowers, 16, LEAF, components, LOWER)]
    tiles = Tiles.joined(tiles, components)
    active = np.unpackbits(leaves["head"]["active"], axis=-1, bitorder="little").astype(bool)
    first = leaves["head"]["first"].astype(np.int64) // LEAF * LEAF
    values = leaves["values"].reshape(-1, LEAF_VOXELS, components)
    return Tree(np.reshape(root["background"], components), first, active, tiles, values)


def _tiles(nodes: np.ndarray, side: int, size: int, components: int, whole: int) -> Iterator[Tiles]:
    """Yield the places of nodes that hold a value other than zero and no child."""
    for node in nodes:
        child, active = (
            np.unpackbits(node["head"][name], bitorder="little").astype(bool) for name in ("child", "active")
        )
        values = np.ascontiguousarray(node["table"][:, : 4 * components]).view("<f4")
        places = np.flatnonzero(~child & (active | values.any(1)))
        corner = node["head"]["box"][0].astype(np.int64) // whole * whole
        first = corner + np.stack(np.unravel_index(places, (side,) * 3), axis=-1) * size
        yield Tiles(first, np.full(len(places), size), values[places], active[places])
