"""The values of an array in a ``.vti`` file: as text, as base64 or as bytes behind all tags, plain or packed by zlib.

Plain values have their size in front; packed ones the number of blocks, their size, that of the last, and how long
each is when packed. All of that is held against what the tags promise before anything is made of it.
"""

import base64
import binascii
import re
import struct
import zlib
from itertools import accumulate, pairwise

import numpy as np

TYPES = {
    **{f"Float{bits}": f"f{bits // 8}" for bits in (32, 64)},
    **{f"Int{bits}": f"i{bits // 8}" for bits in (8, 16, 32, 64)},
    **{f"UInt{bits}": f"u{bits // 8}" for bits in (8, 16, 32, 64)},
}
SIZES = {"UInt32": "I", "UInt64": "Q"}  # of a number in front of values
ZLIB = "vtkZLibDataCompressor"


class Values:
    """Reads the values of a file's arrays.

    Args:
        data: The file.
        head: Attributes of its outermost tag.

    Raises:
        ValueError: If it is packed in an unknown way.
    """

    def __init__(self, data: bytes, head: dict[str, str]):
        packing, kind = head.get("compressor", ""), head.get("header_type", "UInt32")
        if packing not in ("", ZLIB) or kind not in SIZES:
            raise ValueError(f"it is packed by {packing or kind}; save it with ZLib or without compression")
        self.data, self.packed = data, bool(packing)
        self.order = ">" if head.get("byte_order") == "BigEndian" else "<"
        self.size = struct.Struct(self.order + SIZES[kind])
        tag = re.search(rb"<AppendedData\b([^>]*)>\s*_", data)
        self.appended = tag.end() if tag else None
        self.coded = bool(tag) and b"base64" in tag[1]

    def read(self, array: dict[str, str], inside: bytes, count: int) -> np.ndarray:
        """Return an array's values.

        Args:
            array: Attributes of its tag.
            inside: What stands between its tags.
            count: How many values there must be.

        Raises:
            ValueError: If there are more, fewer, or it cannot be told.
        """
        kind, form = array.get("type", ""), array.get("format", "ascii")
        if kind not in TYPES:
            raise ValueError(f"an array of type {kind[:40]!r}")
        dtype = np.dtype(self.order + TYPES[kind])
        if form == "ascii":
            values = np.array(inside.split(), np.float64)
        elif form == "appended":
            if self.appended is None or not re.fullmatch(r"\d{1,18}", array.get("offset", "")):
                raise ValueError("values that stand nowhere")
            start = self.appended + int(array["offset"])
            values = np.frombuffer(self._block(self.data, start, count * dtype.itemsize, self.coded), dtype)
        else:
            values = np.frombuffer(self._block(inside.strip(), 0, count * dtype.itemsize, True), dtype)
        if len(values) != count:
            raise ValueError(f"an array of {len(values)} values where {count} belong")
        return values

    def _block(self, source: bytes, start: int, size: int, coded: bool) -> bytes:
        """Return the ``size`` bytes of the values that begin at some byte."""
        word = self.size.size
        if not self.packed:
            whole = _take(source, start, word + size, coded)
            _expect(self.size.unpack(whole[:word])[0], size)
            return whole[word:]
        (count,) = self.size.unpack(_take(source, start, word, coded))
        if count > len(source):
            raise ValueError(f"values in {count} blocks")
        head = _take(source, start, (3 + count) * word, coded)
        _, full, last, *packed = struct.unpack(f"{self.order}{3 + count}{self.size.format[-1]}", head)
        sizes = [full] * (count - bool(last)) + ([last] if last and count else [])
        _expect(sum(sizes), size)
        body = _take(source, start + _length(len(head), coded), sum(packed), coded)
        spans = pairwise(accumulate(packed, initial=0))
        return b"".join(_unzip(body[a:b], n) for (a, b), n in zip(spans, sizes, strict=True))


def _take(source: bytes, start: int, size: int, coded: bool) -> bytes:
    """Return some bytes, decoded where they are base64."""
    part = source[start : start + _length(size, coded)]
    if len(part) != _length(size, coded):
        raise ValueError(f"no {size} bytes at byte {start}")
    if not coded:
        return part
    try:
        return base64.b64decode(part, validate=True)[:size]
    except binascii.Error as error:
        raise ValueError(f"no base64 at byte {start}") from error


def _expect(size: int, expected: int) -> None:
    if size != expected:
        raise ValueError(f"an array of {size} bytes where {expected} belong")


def _length(size: int, coded: bool) -> int:
    """Return how long bytes are in the file."""
    return -(-size // 3) * 4 if coded else size


def _unzip(data: bytes, size: int) -> bytes:
    try:
        opened = zlib.decompressobj().decompress(data, size + 1)
    except zlib.error as error:
        raise ValueError(f"a packed block cannot be opened ({error})") from error
    if len(opened) != size:
        raise ValueError(f"a block opens to {len(opened)} bytes where {size} belong")
    return opened
