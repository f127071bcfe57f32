"""What writing and reading a ``.vdb`` file share: constants, axes, the checksum."""

import hashlib
import uuid

import numpy as np

MAGIC = 0x56444220
VERSION = 224
READABLE_VERSIONS = range(222, 226)  # 222 brought the masks of today; 225 only adds a new kind of tree

ZIP, ACTIVE_MASK, BLOSC = 1, 2, 4  # bits of a grid's compression
HALF_SUFFIX = "_HalfFloat"
TREES = {"Tree_float_5_4_3": 1, "Tree_vec3s_5_4_3": 3}  # components of a value

LEAF, LOWER, UPPER = 8, 128, 4096  # voxels a side of a leaf and of the two kinds of inner node
LEAF_VOXELS = LEAF**3

METADATA = {
    "bool": "<?",
    "int32": "<i",
    "int64": "<q",
    "float": "<f",
    "double": "<d",
    "vec3i": "<3i",
    "vec3s": "<3f",
    "vec3d": "<3d",
}

CREATOR = "warpfluid"
SHAPE_KEY = "warpfluid_shape"  # of the array as it was given: empty voxels on its outside leave no other trace
UP_KEY = "warpfluid_up"

ID = slice(21, 57)  # where the file's id stands


def content_id(file: bytes | bytearray) -> bytes:
    """Return the id of a file: a hash of all its bytes but the id itself.

    Equal volumes make equal files, and a reader can tell whether a file is whole. OpenVDB draws its ids at
    random and so never marks them as version 5 (made from content), as this one is.
    """
    digest = hashlib.blake2b(file[: ID.start], digest_size=16)
    digest.update(memoryview(file)[ID.stop :])
    return str(uuid.UUID(bytes=digest.digest(), version=5)).encode()


def is_content_id(identity: bytes) -> bool:
    """Tell whether an id was made by ``content_id`` and not drawn at random."""
    return identity[14:15] == b"5"


def to_file_axes(array: np.ndarray, up: str) -> tuple[np.ndarray, np.ndarray]:
    """Turn an array into the axes of the file.

    With z up, (x, y, z) becomes (x, -z, y), a rotation: handedness stays. The voxel (x, y, z) gets the index
    (x, -z, y) too, so no shape enters the transform to the world and a sequence of any size stays in place.

    Args:
        array: Grid, shape (x, y, z) or (x, y, z, 3), y up.
        up: The file's up axis, ``y`` or ``z``.

    Returns:
        The array, shape (i, j, k[, 3]), and the index of its first voxel.
    """
    if up == "y":
        return array, np.zeros(3, np.int64)
    turned = np.swapaxes(array, 1, 2)[:, ::-1]
    if turned.ndim == 4:
        turned = turned[..., [0, 2, 1]]
        turned[..., 1] = 0 - turned[..., 1]  # not -turned, which makes -0 of 0
    return turned, np.array([0, 1 - turned.shape[1], 0])


def from_file_axes(array: np.ndarray, up: str) -> np.ndarray:
    """Turn an array back from the axes of the file: the inverse of ``to_file_axes``."""
    if up == "y":
        return array
    if array.ndim == 4:
        array = array[..., [0, 2, 1]]
        with np.errstate(invalid="ignore"):  # the values may be anything
            array[..., 2] = 0 - array[..., 2]
    return np.swapaxes(array[:, ::-1], 1, 2)


def whole_numbers(value: object) -> tuple[int, ...] | None:
    """Return a fact that is three whole numbers; None for any other."""
    sound = isinstance(value, tuple) and len(value) == 3 and all(isinstance(number, int) for number in value)
    return value if sound else None


def index_box(shape: tuple[int, ...], up: str) -> np.ndarray:
    """Return the first and the last index in the file, shape (2, 3), of an array of ``shape`` (x, y, z)."""
    x, y, z = (int(side) for side in shape)
    if up == "y":
        return np.array([[0, 0, 0], [x - 1, y - 1, z - 1]])
    return np.array([[0, 1 - z, 0], [x - 1, 0, y - 1]])
