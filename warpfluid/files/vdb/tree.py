"""Read the tree of one grid: nodes from the root down, then the values of the leaves."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, fields, replace

import numpy as np

from warpfluid.files.vdb import layout
from warpfluid.files.vdb.leaves import active_box, as_cubes
from warpfluid.files.vdb.stream import Packing, Stream


@dataclass(frozen=True)
class Tiles:
    """Cubes of one value.

    Attributes:
        first: Index of each one's first voxel, shape (tile, 3).
        side: Voxels a side, shape (tile,).
        value: Shape (tile, components).
        active: Whether it counts as filled, shape (tile,).
    """

    first: np.ndarray
    side: np.ndarray
    value: np.ndarray
    active: np.ndarray

    @classmethod
    def joined(cls, parts: Iterable["Tiles"], components: int) -> "Tiles":
        """Return the tiles of all parts."""
        none = cls(np.zeros((0, 3), np.int64), np.zeros(0, np.int64), np.zeros((0, components)), np.zeros(0, bool))
        parts = [none, *parts]
        return cls(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(cls)))


@dataclass
class Topology:
    """Which voxels a grid holds.

    Attributes:
        background: The value everywhere else, shape (components,).
        leaves: Index of each leaf's first voxel, shape (leaf, 3).
        active: Each leaf's active voxels, shape (leaf, 512).
        tiles: The larger cubes.
    """

    background: np.ndarray
    leaves: np.ndarray
    active: np.ndarray
    tiles: Tiles

    def count(self) -> int:
        """Return the number of active voxels."""
        return int(np.count_nonzero(self.active)) + sum(side**3 for side in self.tiles.side[self.tiles.active].tolist())

    def stored(self) -> int:
        """Return the number of active values that a file holds for this; a tile counts as a leaf."""
        return int(np.count_nonzero(self.active)) + layout.LEAF_VOXELS * int(np.count_nonzero(self.tiles.active))

    def box(self) -> np.ndarray | None:
        """Return the first and the last index of active voxels, shape (2, 3), or None where there is none."""
        first, side = self.tiles.first[self.tiles.active], self.tiles.side[self.tiles.active, None]
        leaves = active_box(self.leaves, self.active)
        corners = np.concatenate([first, first + side - 1, *([] if leaves is None else [leaves])])
        return np.array([corners.min(0), corners.max(0)]) if len(corners) else None


@dataclass
class Tree(Topology):
    """What a grid holds apart from its background.

    Attributes:
        values: Each leaf's values, shape (leaf, 512, components).
    """

    values: np.ndarray

    def fill(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Return the voxels from index ``low`` to ``high``, float32 of shape (i, j, k, components).

        Raises:
            ValueError: If tiles lie upon one another.
        """
        start = low // layout.LEAF * layout.LEAF
        blocks = (high - start) // layout.LEAF + 1
        dense = np.zeros((*(blocks * layout.LEAF), len(self.background)), np.float32)
        if self.background.any():
            dense[:] = self.background
        self._fill_tiles(dense, start)
        place = (self.leaves - start) // layout.LEAF
        inside = ((place >= 0) & (place < blocks)).all(1)
        cubes = as_cubes(dense)
        cubes[tuple(place[inside].T)] = self.values[inside].reshape(-1, *cubes.shape[3:])
        return dense[tuple(map(slice, low - start, high - start + 1))]

    def _fill_tiles(self, dense: np.ndarray, start: np.ndarray) -> None:
        begin = np.maximum(self.tiles.first - start, 0)
        end = np.minimum(self.tiles.first - start + self.tiles.side[:, None], dense.shape[:3])
        rows = np.flatnonzero((end > begin).all(1))
        if (end - begin)[rows].prod(axis=1).sum() > math.prod(dense.shape[:3]):
            raise ValueError("the file is damaged: its tiles lie upon one another")
        for row in rows:
            dense[tuple(map(slice, begin[row], end[row]))] = self.tiles.value[row]


def read_topology(stream: Stream, packing: Packing) -> Topology:
    """Read which voxels there are, up to the values of the leaves.

    Args:
        stream: The file, at the grid's topology.
        packing: How the grid's values are stored; the background is read here.

    Raises:
        ValueError: If the bytes make no tree.
    """
    buffers = stream.number("<i")
    if buffers != 1:
        raise ValueError(f"the file is damaged or not of this kind: a tree of {buffers} buffers")
    nodes = _Nodes(stream, replace(packing, background=packing.vector(stream)))
    nodes.read_root()
    leaves = np.concatenate([np.zeros((0, 3), np.int64), *nodes.leaves])
    tiles = Tiles.joined(nodes.tiles, packing.components)
    active = np.unpackbits(np.frombuffer(b"".join(nodes.masks), np.uint8), bitorder="little").view(bool)
    return Topology(nodes.packing.background, leaves, active.reshape(len(leaves), layout.LEAF_VOXELS), tiles)


def read_tree(stream: Stream, packing: Packing) -> Tree:
    """Read topology and buffers.

    Args:
        stream: The file, at the grid's topology.
        packing: How the grid's values are stored; the background is read here.

    Returns:
        The tree.

    Raises:
        ValueError: If the bytes make no tree.
    """
    found = read_topology(stream, packing)
    packing, active = replace(packing, background=found.background), found.active
    if 65 * len(active) > stream.left:
        raise ValueError(f"the file is damaged or cut short: no {len(active)} leaves at byte {stream.position}")
    masks = np.packbits(active, axis=-1, bitorder="little").tobytes()
    values = np.empty((*active.shape, packing.components), np.float32)
    values[:] = found.background
    for row in range(len(active)):
        if stream.take(64) != masks[64 * row : 64 * row + 64]:
            raise ValueError(f"the file is damaged: a leaf's two masks differ (byte {stream.position})")
        packing.read(stream, active[row], values[row])
    return Tree(found.background, found.leaves, active, found.tiles, values)


@dataclass
class _Nodes:
    """The topology while it is read."""

    stream: Stream
    packing: Packing
    leaves: list = field(default_factory=list)
    masks: list = field(default_factory=list)
    tiles: list = field(default_factory=list)

    def read_root(self) -> None:
        tiles, children = self.stream.unpack("<2I")
        for _ in range(tiles):
            first = np.array(self.stream.unpack("<3i"), np.int64)
            value, active = self.packing.vector(self.stream), bool(self.stream.number("<B"))
            if active or (value != self.packing.background).any():
                self.add_tiles(first[None], layout.UPPER, value[None], np.array([active]))
        for _ in range(children):
            first = np.array(self.stream.unpack("<3i"), np.int64)
            if (first % layout.UPPER).any():
                raise ValueError(f"the file is damaged: a node begins at {first.tolist()}, not at a cube of 4096")
            for lower in self.read_node(first, 32, layout.LOWER):
                leaves = self.read_node(lower, 16, layout.LEAF)
                self.leaves.append(leaves)
                self.masks.append(self.stream.take(64 * len(leaves)))

    def read_node(self, first: np.ndarray, side: int, size: int) -> np.ndarray:
        """Read a node of side^3 places of size^3 voxels; return its children's first voxels, (child, 3)."""
        child, active = self.stream.mask(side**3), self.stream.mask(side**3)
        values = np.empty((side**3, self.packing.components), np.float32)
        values[:] = self.packing.background
        self.packing.read(self.stream, active, values)
        places = first + np.argwhere(np.ones((side,) * 3, bool)) * size
        tiles = ~child & (active | (values != self.packing.background).any(1))
        if tiles.any():
            self.add_tiles(places[tiles], size, values[tiles], active[tiles])
        return places[child]

    def add_tiles(self, first: np.ndarray, size: int, value: np.ndarray, active: np.ndarray) -> None:
        self.tiles.append(Tiles(first, np.full(len(first), size), value, active))
