"""Open blocks packed with Blosc and LZ4, the usual packing of Houdini, Blender and OpenVDB itself.

A block has a header of 16 bytes and is cut into parts, each packed by LZ4: runs of new bytes, and copies of
bytes that came before. *Shuffled* bytes stand by their place in a number: all first bytes, then all second.
"""

import struct

import numpy as np

SHUFFLED, STORED, BITS_SHUFFLED, WHOLE = 1, 2, 4, 16  # flags; a part that is not whole is split by byte place
LZ4 = 1
SPLIT_NUMBERS, SPLIT_BYTES = 128, 16  # parts of fewer numbers, or of larger ones, are never split


def unpack(data: bytes, size: int) -> bytes:
    """Return the ``size`` bytes that were packed.

    Raises:
        ValueError: If the block is damaged, or packed in another way than Blosc's LZ4.
    """
    if len(data) < 16:
        raise ValueError("the file is damaged: a packed node has no header")
    flags, number, opened, part, packed = struct.unpack("<2xBB3I", data[:16])
    if (opened, packed) != (size, len(data)):
        raise ValueError(f"the file is damaged: a node opens to {opened} bytes where {size} belong")
    if flags & STORED or not size:
        return _exactly(data[16:], size)
    if not number or not part:
        raise ValueError("the file is damaged: a packed node has parts of no size")
    if flags >> 5 != LZ4 or flags & BITS_SHUFFLED:
        raise ValueError("the file is packed with Blosc, but not with its LZ4; save it again with zip")
    starts = np.frombuffer(_exactly(data[16 : 16 + 4 * -(-size // part)], 4 * -(-size // part)), "<u4")
    parts = []
    for index, start in enumerate(starts.tolist()):
        length = min(part, size - index * part)
        split = not flags & WHOLE and number <= SPLIT_BYTES and part // number >= SPLIT_NUMBERS and length == part
        opened = _unpack_part(data, start, length, number if split else 1)
        parts.append(_unshuffle(opened, number) if flags & SHUFFLED else opened)
    return b"".join(parts)


def _unpack_part(data: bytes, start: int, length: int, streams: int) -> bytes:
    """Open one part, which is one stream or as many as a number has bytes."""
    opened = []
    for _ in range(streams):
        (packed,) = struct.unpack("<I", _exactly(data[start : start + 4], 4))
        stream = _exactly(data[start + 4 : start + 4 + packed], packed)
        stored = packed == length // streams
        opened.append(stream if stored else _unpack_lz4(stream, length // streams))
        start += 4 + packed
    return b"".join(opened)


def _unpack_lz4(data: bytes, size: int) -> bytes:
    """Open one LZ4 stream: a token, new bytes, then how far back and how much to copy, again and again."""
    out, place = bytearray(), 0
    try:
        while len(out) < size:
            token, place = data[place], place + 1
            count, place = _count(data, place, token >> 4)
            out += _exactly(data[place : place + count], count)
            place += count
            if place >= len(data):
                break
            back, place = data[place] | data[place + 1] << 8, place + 2
            count, place = _count(data, place, token & 15)
            count += 4
            if not 0 < back <= len(out) or len(out) + count > size:
                raise ValueError("the file is damaged: a packed node copies what is not there")
            copied = out[len(out) - back : len(out) - back + count]
            out += (copied * (count // back + 1))[:count]
    except IndexError:
        raise ValueError("the file is damaged: a packed node ends too early") from None
    return _exactly(bytes(out), size)


def _count(data: bytes, place: int, count: int) -> tuple[int, int]:
    """Return a count that goes on in further bytes while they are full, and the place after it."""
    if count == 15:
        more = 255
        while more == 255:
            more, place = data[place], place + 1
            count += more
    return count, place


def _unshuffle(data: bytes, number: int) -> bytes:
    whole = len(data) // number * number
    return np.frombuffer(data[:whole], np.uint8).reshape(number, -1).T.tobytes() + data[whole:]


def _exactly(data: bytes, size: int) -> bytes:
    if len(data) != size:
        raise ValueError(f"the file is damaged: a packed node has {len(data)} bytes where {size} belong")
    return data
