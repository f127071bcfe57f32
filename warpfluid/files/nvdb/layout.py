"""How the parts of a NanoVDB file lie in memory, as NumPy types (format 32, little-endian)."""

import numpy as np

MAGIC = 0x304244566F6E614E  # "NanoVDB0", which old and new readers take
MAGICS = (MAGIC, 0x314244566F6E614E, 0x324244566F6E614E)
MAJOR = 32
VERSION = MAJOR << 21 | 3 << 10 | 3
PLAIN, ZIP = 0, 1  # how grids are packed
NO_CHECKSUM = 2**64 - 1
HAS_BOX, HAS_RANGE, BREADTH_FIRST = 2, 4, 32  # flags of a grid
TYPES = {"float": 1, "vec3s": 6}
UNKNOWN, FOG_VOLUME = 0, 2  # classes
NAME_BYTES = 256

FILE_HEAD = np.dtype([("magic", "<u8"), ("version", "<u4"), ("grids", "<u2"), ("codec", "<u2")])
GRID_ENTRY = np.dtype(
    [
        ("memory", "<u8"),
        ("size", "<u8"),
        ("name_hash", "<u8"),
        ("active", "<u8"),
        ("type", "<u4"),
        ("class", "<u4"),
        ("world_box", "<f8", (2, 3)),
        ("box", "<i4", (2, 3)),
        ("voxel_size", "<f8", 3),
        ("name_bytes", "<u4"),
        ("nodes", "<u4", 4),
        ("tiles", "<u4", 3),
        ("codec", "<u2"),
        ("padding", "<u2"),
        ("version", "<u4"),
    ]
)
MAP = np.dtype(
    [
        ("matrix_f", "<f4", (3, 3)),
        ("inverse_f", "<f4", (3, 3)),
        ("shift_f", "<f4", 3),
        ("taper_f", "<f4"),
        ("matrix", "<f8", (3, 3)),
        ("inverse", "<f8", (3, 3)),
        ("shift", "<f8", 3),
        ("taper", "<f8"),
    ]
)
GRID = np.dtype(
    [
        ("magic", "<u8"),
        ("checksum", "<u8"),
        ("version", "<u4"),
        ("flags", "<u4"),
        ("index", "<u4"),
        ("count", "<u4"),
        ("size", "<u8"),
        ("name", f"S{NAME_BYTES}"),
        ("map", MAP),
        ("world_box", "<f8", (2, 3)),
        ("voxel_size", "<f8", 3),
        ("class", "<u4"),
        ("type", "<u4"),
        ("blind_offset", "<i8"),
        ("blind_count", "<u4"),
        ("rest", "<u4", 5),
    ]
)
TREE = np.dtype([("offset", "<i8", 4), ("nodes", "<u4", 3), ("tiles", "<u4", 3), ("active", "<u8")])


def root_type(components: int) -> np.dtype:
    """Return the root's head; its table follows."""
    fields = [("box", "<i4", (2, 3)), ("tiles", "<u4"), *_values(components, "background", "low", "high")]
    return _padded([*fields, ("mean", "<f4"), ("deviation", "<f4")], 32)


def tile_type(components: int) -> np.dtype:
    """Return an entry of the root's table."""
    return _padded([("key", "<u8"), ("child", "<i8"), ("state", "<u4"), *_values(components, "value")], 32)


def node_type(components: int, side: int) -> np.dtype:
    """Return a node with side^3 places: the upper kind has 32 a side, the lower kind 16."""
    mask, stride = side**3 // 8, 8 if components == 1 else 16
    fields = [
        ("box", "<i4", (2, 3)),
        ("flags", "<u8"),
        ("active", "u1", mask),
        ("child", "u1", mask),
        *_values(components, "low", "high"),
        ("mean", "<f4"),
        ("deviation", "<f4"),
    ]
    head = _padded(fields, 32)
    return np.dtype([("head", head), ("table", np.uint8, (side**3, stride))])


def leaf_type(components: int) -> np.dtype:
    """Return a leaf: head, mask of active voxels, values."""
    fields = [
        ("first", "<i4", 3),
        ("extent", "u1", 3),
        ("flags", "u1"),
        ("active", "u1", 64),
        *_values(components, "low", "high"),
        ("mean", "<f4"),
        ("deviation", "<f4"),
    ]
    return np.dtype([("head", _padded(fields, 32)), ("values", "<f4", (512, components))])


def name_hash(name: str) -> int:
    """Return the number by which a grid is found in a file."""
    number = 0
    for byte in name.encode():
        number = (number * 67 + byte + (number >> 56)) % 2**64
    return number


def _values(components: int, *names: str) -> list[tuple]:
    return [(name, "<f4", components) for name in names]


def _padded(fields: list[tuple], multiple: int) -> np.dtype:
    """Return a type without gaps, as long as a multiple of some bytes."""
    plain = np.dtype(fields)
    size = -(-plain.itemsize // multiple) * multiple
    offsets = [plain.fields[name][1] for name in plain.names]
    kinds = [plain.fields[name][0] for name in plain.names]
    return np.dtype({"names": plain.names, "formats": kinds, "offsets": offsets, "itemsize": size})
