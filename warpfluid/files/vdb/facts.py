"""What a ``.vdb`` file holds, told from its metadata and trees, without the values of its voxels."""

import mmap
from collections.abc import Collection
from pathlib import Path

import numpy as np

from warpfluid.files.grids import GridFacts
from warpfluid.files.vdb import layout
from warpfluid.files.vdb.reader import read_header, read_transform
from warpfluid.files.vdb.stream import Packing, Stream
from warpfluid.files.vdb.tree import read_topology


def vdb_facts(path: str | Path) -> list[GridFacts]:
    """Return what is known of every grid of a file.

    Little of the file is read: most programs store the box of the active voxels with a grid. Where it is missing, the
    tree is read, down to the masks of the leaves.

    Args:
        path: The file.

    Raises:
        ValueError: If this is no such file, or it is damaged.
        OSError: If the file cannot be read.
    """
    with open(path, "rb") as file:
        try:
            data = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        except ValueError as error:  # an empty file has nothing to map
            raise ValueError(f"{path}: this is not an OpenVDB file") from error
        with data:
            try:
                return _facts(Stream(data))
            except ValueError as error:
                raise ValueError(f"{path}: {error}") from error


def _facts(stream: Stream) -> list[GridFacts]:
    has_offsets, _ = read_header(stream)
    stream.metadata()
    count = stream.number("<i")
    if count > 1 and not has_offsets:
        raise ValueError("its grids do not tell where they end; save it again with OpenVDB")
    found: dict[str, GridFacts] = {}
    for _ in range(count):
        facts = _grid(stream, found)
        found[facts.name] = facts
    return list(found.values())


def _grid(stream: Stream, names: Collection[str]) -> GridFacts:
    name, number = stream.text().partition("\x1e")[::2]
    name = f"{name}[{number}]" if name in names else name
    tree, parent = stream.text(), stream.text()
    _, _, end = stream.unpack("<3q")
    half, tree = tree.endswith(layout.HALF_SUFFIX), tree.removesuffix(layout.HALF_SUFFIX)
    components = layout.TREES.get(tree)
    packing = Packing(stream.number("<I"), half, components or 1)
    about = stream.metadata()
    voxel_size, shift = None, (0.0, 0.0, 0.0)
    box, active = _stored_box(about), _stored_count(about)
    try:
        voxel_size, shift = read_transform(stream, name)
    except ValueError:
        pass  # turned, or no cubes: that is told, and nothing is read
    else:
        if components and not parent and (box is None or active is None):
            topology = read_topology(stream, packing)
            box, active = topology.box(), topology.count()
    if end:
        stream.seek(end)
    return GridFacts(
        name=name,
        kind=f"copy of {parent}" if parent else tree.removeprefix("Tree_").removesuffix("_5_4_3"),
        half=half,
        voxel_size=voxel_size,
        shift=tuple(shift),
        box=None if active == 0 else box,
        whole=_whole_box(about, box, active),
        active=active,
        up=about.get(layout.UP_KEY),
        about=about,
    )


def _stored_box(about: dict) -> np.ndarray | None:
    """Return the box that the file tells; None where it tells none, or that of nothing."""
    low, high = (layout.whole_numbers(about.get(f"file_bbox_{end}")) for end in ("min", "max"))
    if low is None or high is None or any(a > b for a, b in zip(low, high, strict=True)):
        return None
    return np.array([low, high], np.int64)


def _stored_count(about: dict) -> int | None:
    count = about.get("file_voxel_count")
    return count if type(count) is int and count >= 0 else None


def _whole_box(about: dict, box: np.ndarray | None, active: int | None) -> np.ndarray | None:
    """Return the box of the array that was written, with any voxels that others have added."""
    boxes = [] if box is None or active == 0 else [box]
    shape = layout.whole_numbers(about.get(layout.SHAPE_KEY))
    if shape and min(shape) > 0:
        boxes.append(layout.index_box(shape, "z" if about.get(layout.UP_KEY) == "z" else "y"))
    return np.array([np.min(boxes, 0)[0], np.max(boxes, 0)[1]]) if boxes else None
