"""Radiance pictures (.hdr, .pic): float light with one exponent for three colours, as light probes are often kept.

The format is that of Ward's Radiance: a header of text, then rows of pixels of four bytes, plain or run-length encoded
in the old or the new way. A mantissa m and an exponent e are ``m 2^(e - 136)``, as image libraries read it.
"""

import math
import re
from pathlib import Path

import numpy as np

from warpfluid.files.limits import check_pixels

HEADER_BYTES = 1 << 16  # a header that is longer is none
NEW_WIDTHS = range(8, 1 << 15)  # of rows that may be encoded in the new way


def read_hdr(path: str | Path) -> np.ndarray:
    """Read a Radiance picture.

    Args:
        path: The file.

    Returns:
        Light, float32, shape (rows, columns, 3), top row first; an exposure in the header is undone.

    Raises:
        OSError: If the file cannot be opened.
        ValueError: If it is damaged, too large, or no red, green and blue.
    """
    data = Path(path).read_bytes()
    try:
        exposure, axes, begin = _read_header(data)
        (_, lines), (_, length) = axes
        rows, place = [], begin
        for _ in range(lines):
            row, place = _read_row(data, place, length)
            rows.append(row)
    except ValueError as error:
        raise ValueError(f"{path} cannot be read: {error}") from error
    pixels = np.stack(rows)
    with np.errstate(over="ignore"):
        scale = (np.ldexp(1.0, pixels[..., 3:].astype(np.int32) - 136) / exposure).astype(np.float32)
        light = np.where(pixels[..., 3:] > 0, pixels[..., :3] * scale, np.float32(0))
    return np.ascontiguousarray(_upright(light, axes[0][0], axes[1][0]), np.float32)


def _read_header(data: bytes) -> tuple[float, list[tuple[str, int]], int]:
    """Return the exposure, the two axes with their lengths, and where the pixels begin."""
    if not data.startswith(b"#?"):
        raise ValueError("it is empty or no Radiance picture")
    header, blank, rest = data[:HEADER_BYTES].partition(b"\n\n")
    size, newline, _ = rest.partition(b"\n")
    if not (blank and newline):
        raise ValueError("its header is cut off")
    settings = dict(re.findall(r"^(FORMAT)\s*=\s*(\S+)", header.decode("latin-1"), re.MULTILINE))
    if settings.get("FORMAT", "32-bit_rle_rgbe") != "32-bit_rle_rgbe":
        raise ValueError(f"its format is {settings['FORMAT']}, expected 32-bit_rle_rgbe: convert it")
    exposures = re.findall(r"^EXPOSURE\s*=\s*(\S+)", header.decode("latin-1"), re.MULTILINE)
    exposure = math.prod(float(text) for text in exposures)
    if not 1e-30 < exposure < 1e30:
        raise ValueError(f"its exposure is {exposure}")
    if not re.fullmatch(rb"[-+](Y \d{1,9} [-+]X|X \d{1,9} [-+]Y) \d{1,9}", size):
        raise ValueError(f"its size is {size[:40]!r}, expected a line such as -Y 512 +X 1024")
    words = size.decode().split()
    axes = [(words[0], int(words[1])), (words[2], int(words[3]))]
    check_pixels(axes[0][1], axes[1][1], 3, len(data))
    return exposure, axes, len(header) + len(blank) + len(size) + 1


def _read_row(data: bytes, place: int, length: int) -> tuple[np.ndarray, int]:
    """Return a row of pixels (length, 4) and where the next one begins."""
    start = data[place : place + 4]
    if length in NEW_WIDTHS and start[:2] == b"\2\2" and len(start) == 4 and start[2] < 128:
        if start[2] << 8 | start[3] != length:
            raise ValueError("a row has another length than the header says")
        return _read_runs(data, place + 4, length)
    plain = np.frombuffer(data, np.uint8, min(4 * length, len(data) - place), place)
    if len(plain) == 4 * length and not (plain.reshape(-1, 4)[:, :3] == 1).all(axis=1).any():
        return plain.reshape(-1, 4), place + 4 * length
    return _read_repeats(data, place, length)


def _read_runs(data: bytes, place: int, length: int) -> tuple[np.ndarray, int]:
    """Read a row of the new way: four planes of bytes, each of runs and of stretches as they are."""
    planes, filled = bytearray(), 0
    while filled < 4 * length:
        count = data[place] if place < len(data) else 0
        run = count > 128
        count = count - 128 if run else count
        part = data[place + 1 : place + 2] * count if run else data[place + 1 : place + 1 + count]
        if count == 0 or len(part) < count or filled % length + count > length:
            raise ValueError("its pixels are damaged or cut off")
        planes += part
        filled += count
        place += 2 if run else 1 + count
    return np.frombuffer(bytes(planes), np.uint8).reshape(4, length).T, place


def _read_repeats(data: bytes, place: int, length: int) -> tuple[np.ndarray, int]:
    """Read a row of the old way: pixels, of which 1, 1, 1, n repeats the last one n times."""
    pixels, shift = bytearray(), 0
    while len(pixels) < 4 * length:
        pixel = data[place : place + 4]
        place += 4
        repeat = pixel[:3] == b"\1\1\1" and len(pixel) == 4
        count = pixel[3] << shift if repeat else 1
        if len(pixel) < 4 or (repeat and not pixels) or len(pixels) + 4 * count > 4 * length or shift > 24:
            raise ValueError("its pixels are damaged or cut off")
        pixels += pixels[-4:] * count if repeat else pixel
        shift = shift + 8 if repeat else 0
    return np.frombuffer(bytes(pixels), np.uint8).reshape(length, 4), place


def _upright(light: np.ndarray, lines: str, along: str) -> np.ndarray:
    """Turn rows and columns as the header's signs tell: -Y is downwards, +X to the right."""
    for axis, name in enumerate((lines, along)):
        if name in ("+Y", "-X"):
            light = np.flip(light, axis)
    return light if lines[1] == "Y" else light.swapaxes(0, 1)
