"""Read the bytes of a ``.vdb`` file without trusting them.

Every length is held against what is left of the file before anything is made from it, so that a damaged file
ends in an error and not in gigabytes. Errors here do not know the file's name; ``read_vdb`` adds it.
"""

import mmap
import struct
import zlib
from dataclasses import dataclass

import numpy as np

from warpfluid.files.vdb import blosc, layout


@dataclass
class Stream:
    """The bytes of a file, or a file that is mapped into memory, and the place up to which they are read."""

    data: bytes | mmap.mmap
    position: int = 0

    def take(self, size: int) -> bytes:
        """Return the next ``size`` bytes."""
        end = self.position + size
        if size < 0 or end > len(self.data):
            raise ValueError(f"the file is damaged or cut short: no {size} bytes at byte {self.position}")
        start, self.position = self.position, end
        return self.data[start:end]

    @property
    def left(self) -> int:
        """Bytes that are not read yet."""
        return len(self.data) - self.position

    def seek(self, position: int) -> None:
        """Go to a place further on."""
        if not self.position <= position <= len(self.data):
            raise ValueError(f"the file is damaged or cut short: no byte {position} after byte {self.position}")
        self.position = position

    def unpack(self, form: str) -> tuple:
        """Return the next values in the form of ``struct``."""
        return struct.unpack(form, self.take(struct.calcsize(form)))

    def number(self, form: str) -> int:
        """Return the next single value."""
        return self.unpack(form)[0]

    def text(self) -> str:
        """Return the next string."""
        return self.take(self.number("<I")).decode(errors="replace")

    def mask(self, bits: int) -> np.ndarray:
        """Return the next bit mask, bool of shape (bits,)."""
        packed = np.frombuffer(self.take(bits // 8), np.uint8)
        return np.unpackbits(packed, bitorder="little").view(bool)

    def metadata(self) -> dict:
        """Return the next metadata by name; kinds that only OpenVDB itself can use are left out."""
        facts = {}
        for _ in range(self.number("<I")):
            name, kind, data = self.text(), self.text(), self.take(self.number("<I"))
            form = layout.METADATA.get(kind)
            if kind == "string":
                facts[name] = data.decode(errors="replace")
            elif form and struct.calcsize(form) == len(data):
                values = struct.unpack(form, data)
                facts[name] = values if len(values) > 1 else values[0]
        return facts


@dataclass(frozen=True)
class Packing:
    """How a grid's values are stored."""

    compression: int
    half: bool
    components: int
    background: np.ndarray | None = None  # shape (components,)

    def vector(self, stream: Stream) -> np.ndarray:
        """Return one value that stands alone, always 32-bit, shape (components,)."""
        return np.frombuffer(stream.take(4 * self.components), "<f4")

    def read(self, stream: Stream, active: np.ndarray, out: np.ndarray) -> None:
        """Read one node's values.

        A byte says what the inactive voxels hold: 0 the background, 1 its negative, 2 one value, 3 to 5 one
        of two that another mask chooses between; with 6 all voxels are stored.

        Args:
            stream: Where to read.
            active: The node's active voxels, shape (voxel,).
            out: Receives the values, shape (voxel, components); holds the background before.
        """
        code = stream.number("<B")
        if code > 6:
            raise ValueError(f"the file is damaged: a node of kind {code} at byte {stream.position - 1}")
        first = self.vector(stream) if code in (2, 4, 5) else -self.background
        second = self.vector(stream) if code == 5 else self.background
        chosen = stream.mask(len(active)) if code in (3, 4, 5) else None
        if code == 6 or not self.compression & layout.ACTIVE_MASK:
            out[:] = self._values(stream, len(active))
            return
        out[active] = self._values(stream, np.count_nonzero(active))
        if code:
            inactive = ~active
            out[inactive] = first if chosen is None else np.where(chosen[inactive, None], second, first)

    def _values(self, stream: Stream, count: int) -> np.ndarray:
        """Return the next ``count`` values, shape (count, components)."""
        dtype = np.dtype("<f2" if self.half else "<f4")
        size = count * self.components * dtype.itemsize
        if self.half and not count:
            return np.zeros((0, self.components), dtype)  # such a block has no length either
        return np.frombuffer(self._unpacked(stream, size), dtype).reshape(count, self.components)

    def _unpacked(self, stream: Stream, size: int) -> bytes:
        if not self.compression & (layout.ZIP | layout.BLOSC):
            return stream.take(size)
        length = stream.number("<q")
        if length > 0:
            data = stream.take(length)
            return blosc.unpack(data, size) if self.compression & layout.BLOSC else _unzip(data, size)
        if -length != size:
            raise ValueError(f"the file is damaged: a node has {-length} bytes where {size} belong")
        return stream.take(size)


def _unzip(data: bytes, size: int) -> bytes:
    unpacker = zlib.decompressobj()
    try:
        values = unpacker.decompress(data, size + 1)
    except zlib.error as error:
        raise ValueError(f"the file is damaged: a packed node cannot be opened ({error})") from error
    if len(values) != size:
        raise ValueError(f"the file is damaged: a node opens to {len(values)} bytes where {size} belong")
    return values
