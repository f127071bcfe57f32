"""Read ``.vdb`` files: what ``write_vdb`` wrote, exactly, and ordinary files of others."""

import math
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from warpfluid.files.grids import GridFile
from warpfluid.files.limits import check_box, is_voxel_size
from warpfluid.files.vdb import layout
from warpfluid.files.vdb.stream import Packing, Stream
from warpfluid.files.vdb.tree import Tree, read_tree


@dataclass(frozen=True)
class _Grid:
    """A grid as it stands in the file."""

    facts: dict
    up: str
    voxel_size: float
    shift: tuple[float, ...]
    tree: Tree

    @property
    def lattice(self) -> tuple:
        return self.up, self.voxel_size, self.shift

    def boxes(self) -> list[np.ndarray]:
        """Return the boxes that the array must hold: the active voxels and the array that was written."""
        boxes = [self.tree.box()]
        shape = layout.whole_numbers(self.facts.get(layout.SHAPE_KEY))
        if shape and min(shape) > 0:
            boxes.append(layout.index_box(shape, self.up))
        return [box for box in boxes if box is not None]


def read_vdb(path: str | Path, names: Collection[str] | None = None, *, up: Literal["y", "z"] = "y") -> GridFile:
    """Read the float and vector grids of an OpenVDB file as arrays.

    A file of ``write_vdb`` gives back the arrays that were written, in their axes whatever the file's up
    axis, with 0 where a voxel was dropped. Files of other programs are read as they are, cut to the box of
    all active voxels; they may be packed with zip, with Blosc's LZ4, or not at all.

    Args:
        path: The file.
        names: The grids to read; all by default.
        up: The up axis of a file that does not tell.

    Returns:
        The grids, and where they lie, y up.

    Raises:
        ValueError: If this is no such file, or it is damaged, or a grid is of a kind that is not read.
        OSError: If the file cannot be read.
    """
    names = [names] if isinstance(names, str) else names
    data = Path(path).read_bytes()
    try:
        return _read(Stream(data), names, up)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    except MemoryError as error:
        raise ValueError(f"{path}: its volumes do not fit into memory; choose with names=[...]") from error


def _read(stream: Stream, names: Collection[str] | None, up: str) -> GridFile:
    has_offsets, identity = read_header(stream)
    metadata = stream.metadata()
    own = metadata.get("creator") == layout.CREATOR and layout.is_content_id(identity)
    if own and layout.content_id(stream.data) != identity:
        raise ValueError("the file is damaged or cut short: its checksum does not fit; write it again")
    grids, found = {}, []
    for _ in range(stream.number("<i")):
        name, number = stream.text().partition("\x1e")[::2]  # OpenVDB numbers grids of one name so
        found.append(name)
        name = f"{name}[{number}]" if name in grids else name
        grid = _read_grid(stream, name, has_offsets, up, wanted=names is None or name in names)
        if grid:
            grids[name] = grid
    missing = sorted(set(names or ()) - set(grids))
    if missing or not grids:
        wanted = f"no grid {', '.join(missing)}" if missing else "no grid"
        raise ValueError(f"the file has {wanted}; it has {', '.join(found) or 'none'}")
    return _on_one_lattice(grids, metadata, trusted=own)


def read_header(stream: Stream) -> tuple[bool, bytes]:
    """Read what all files begin with; return whether grids tell where they end, and the file's id."""
    if stream.data[:8] != layout.MAGIC.to_bytes(8, "little"):
        raise ValueError("this is not an OpenVDB file")
    _, version, _, _, has_offsets = stream.unpack("<qIIIB")
    if version not in layout.READABLE_VERSIONS:
        readable = f"{layout.READABLE_VERSIONS[0]} to {layout.READABLE_VERSIONS[-1]}"
        raise ValueError(f"its format is {version}, not {readable}; save it again with another OpenVDB")
    return bool(has_offsets), stream.take(layout.ID.stop - layout.ID.start)


def _read_grid(stream: Stream, name: str, has_offsets: bool, up: str, wanted: bool) -> _Grid | None:
    """Read one grid, or pass over it."""
    kind, parent = stream.text(), stream.text()
    _, _, end = stream.unpack("<3q")
    if not wanted and has_offsets:
        stream.seek(end)
        return None
    components = layout.TREES.get(kind.removesuffix(layout.HALF_SUFFIX))
    if components is None or parent:
        what = "a copy of another grid" if parent else f"of type {kind!r}"
        raise ValueError(f"grid {name!r} is {what}, not a float or vec3s tree; leave it out with names=[...]")
    packing = Packing(stream.number("<I"), kind.endswith(layout.HALF_SUFFIX), components)
    facts = stream.metadata()
    voxel_size, shift = read_transform(stream, name)
    up = "z" if facts.get(layout.UP_KEY, up) == "z" else "y"
    grid = _Grid(facts, up, voxel_size, shift, read_tree(stream, packing))
    return grid if wanted else None


def read_transform(stream: Stream, name: str) -> tuple[float, tuple[float, ...]]:
    """Read the map to the world; return the voxel size and where the voxel of index (0, 0, 0) lies."""
    kind, shift = stream.text(), (0.0, 0.0, 0.0)
    if kind == "TranslationMap":
        scale, shift, straight = np.ones(3), stream.unpack("<3d"), True
    elif kind in ("AffineMap", "UnitaryMap"):
        matrix = np.array(stream.unpack("<16d")).reshape(4, 4)
        scale, shift = np.diag(matrix)[:3], tuple(matrix[3, :3].tolist())
        straight = not matrix[:3][~np.eye(3, 4, dtype=bool)].any()
    else:
        straight = kind in ("UniformScaleMap", "ScaleMap", "UniformScaleTranslateMap", "ScaleTranslateMap")
        if straight and kind.endswith("TranslateMap"):
            shift = stream.unpack("<3d")
        scale = np.array(stream.unpack("<15d")[:3]) if straight else None
    if not (straight and np.isfinite([*scale, *shift]).all() and is_voxel_size(scale[0]) and (scale == scale[0]).all()):
        raise ValueError(f"grid {name!r} is turned or has no cubes for voxels ({kind}); resample it")
    return float(scale[0]), shift


def _on_one_lattice(grids: dict[str, _Grid], metadata: dict, trusted: bool) -> GridFile:
    """Fill arrays that hold all grids."""
    lattices = {grid.lattice for grid in grids.values()}
    if len(lattices) > 1:
        raise ValueError(f"the grids {', '.join(grids)} differ in voxel size or place; choose with names=[...]")
    up, voxel_size, shift = lattices.pop()
    boxes = [box for grid in grids.values() for box in grid.boxes()] or [np.array([[0, 0, 0], [-1, -1, -1]])]
    low, high = np.min(boxes, 0)[0], np.max(boxes, 0)[1]
    voxels = math.prod(int(side) for side in high - low + 1)
    if not trusted:  # a fire of ours may begin with nothing
        check_box(voxels, sum(grid.tree.stored() for grid in grids.values()))
    place = [at + voxel_size * index for at, index in zip(shift, low.tolist(), strict=True)]
    if up == "z":
        place = [place[0], place[2], 0 - (shift[1] + voxel_size * int(high[1]))]
    arrays = {name: _array(grid.tree, low, high, up) for name, grid in grids.items()}
    return GridFile(grids=arrays, voxel_size=voxel_size, origin=tuple(place), metadata=metadata)


def _array(tree: Tree, low: np.ndarray, high: np.ndarray, up: str) -> np.ndarray:
    dense = tree.fill(low, high)
    return np.ascontiguousarray(layout.from_file_axes(dense if dense.shape[3] == 3 else dense[..., 0], up))
