"""Radiance pictures of both encodings and all orientations, against a writer that knows only the format."""

import numpy as np
import pytest

from warpfluid.files.hdr import read_hdr

HEADER = b"#?RADIANCE\n# made here\nFORMAT=32-bit_rle_rgbe\n"


def encode(light):
    """Bytes of red, green, blue and exponent, as in Ward's paper."""
    largest = light.max(axis=-1, keepdims=True)
    exponent = np.where(largest > 1e-32, np.frexp(np.maximum(largest, 1e-32))[1], -128)
    mantissas = np.where(largest > 1e-32, light * np.ldexp(256.0, -exponent), 0)
    return np.concatenate([mantissas, exponent + 128], axis=-1).astype(np.uint8)


def runs_of(row):
    """A plane of bytes as runs where three are equal, else as they are."""
    out, at = b"", 0
    while at < len(row):
        run = 1
        while at + run < len(row) and run < 127 and row[at + run] == row[at]:
            run += 1
        out += bytes([128 + run, row[at]]) if run > 2 else bytes([1, row[at]])
        at += run if run > 2 else 1
    return out


def write(path, light, way, size=None, header=HEADER):
    pixels = encode(light)
    rows, columns = light.shape[:2]
    size = size or f"-Y {rows} +X {columns}"
    body = b""
    for row in pixels:
        if way == "new":
            body += bytes([2, 2, columns >> 8, columns & 255]) + b"".join(runs_of(row[:, c]) for c in range(4))
        elif way == "old":
            at = 0
            while at < columns:
                body += row[at].tobytes()
                run = 1
                while at + run < columns and (row[at + run] == row[at]).all():
                    run += 1
                more = run - 1
                while more:
                    body += bytes([1, 1, 1, more & 255])
                    more >>= 8
                at += run
        else:
            body += row.tobytes()
    path.write_bytes(header + b"\n" + size.encode() + b"\n" + body)
    return path


@pytest.fixture
def light():
    """Bright and dark, with runs long and short, and black."""
    rng = np.random.default_rng(0)
    light = 2.0 ** rng.uniform(-20, 20, (6, 700, 1)) * rng.uniform(0.1, 1, (6, 700, 3))
    light[1, 10:400] = light[1, 10]
    light[2:4] = 1.0
    light[4, ::2] = 0
    return light


@pytest.mark.parametrize("way", ["new", "old", "plain"])
def test_reads_what_is_written(tmp_path, light, way):
    """To the last of the eight bits."""
    read = read_hdr(write(tmp_path / "a.hdr", light, way))
    assert read.dtype == np.float32
    assert (np.abs(read - light) <= light.max(axis=-1, keepdims=True) / 128).all()
    assert (read[2:4] == 1).all()


def test_agrees_with_another_reader(tmp_path, light):
    """FFmpeg's, to the rounding of a mantissa."""
    av = pytest.importorskip("av")
    path = write(tmp_path / "a.hdr", light, "new")
    with av.open(str(path)) as file:
        frame = next(file.decode(video=0))
    other = np.stack([np.frombuffer(plane, np.float32).reshape(6, -1)[:, :700] for plane in frame.planes], axis=-1)
    read = read_hdr(path)
    assert (np.abs(read - other[..., [2, 0, 1]]) <= read.max(axis=-1, keepdims=True) / 200).all()


@pytest.mark.parametrize(
    ("size", "turn"),
    [
        ("-Y 3 +X 12", lambda a: a),
        ("+Y 3 +X 12", lambda a: a[::-1]),
        ("-Y 3 -X 12", lambda a: a[:, ::-1]),
        ("+X 3 -Y 12", lambda a: a.swapaxes(0, 1)),
        ("-X 3 +Y 12", lambda a: a[::-1, ::-1].swapaxes(0, 1)),
    ],
)
def test_orientation(tmp_path, size, turn):
    """The signs say which way rows and columns run."""
    light = np.random.default_rng(1).integers(1, 255, (3, 12, 3)) / 256
    stored = read_hdr(write(tmp_path / "a.hdr", light, "new"))
    read = read_hdr(write(tmp_path / "b.hdr", light, "new", size=size))
    np.testing.assert_array_equal(read, turn(stored))


def test_exposure_is_undone(tmp_path):
    """All exposures of the header, multiplied."""
    light = np.ones((2, 10, 3))
    header = HEADER + b"EXPOSURE=4\nEXPOSURE= 0.5\n"
    np.testing.assert_array_equal(read_hdr(write(tmp_path / "a.hdr", light, "new", header=header)), 0.5)


BODY = bytes([2, 2, 0, 8]) + bytes([136, 1]) * 4
BAD = {
    "nothing": (b"", "no Radiance"),
    "another": (b"\x89PNG", "no Radiance"),
    "no pixels": (HEADER + b"\n-Y 2 +X 8\n", "damaged"),
    "no size": (HEADER, "cut off"),
    "size of words": (HEADER + b"\n-Y two +X 8\n" + BODY, "size"),
    "same axes": (HEADER + b"\n-Y 1 +Y 8\n" + BODY, "size"),
    "huge": (HEADER + b"\n-Y 999999 +X 999999\n" + BODY, "pixels are allowed"),
    "empty": (HEADER + b"\n-Y 0 +X 8\n" + BODY, "pixels are allowed"),
    "other colours": (b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 8\n" + BODY, "xyze"),
    "exposure": (HEADER + b"EXPOSURE=0\n\n-Y 1 +X 8\n" + BODY, "exposure"),
    "cut off": (HEADER + b"\n-Y 2 +X 8\n" + BODY, "damaged"),
    "other width": (HEADER + b"\n-Y 1 +X 9\n" + BODY, "length"),
    "run too long": (HEADER + b"\n-Y 1 +X 8\n" + bytes([2, 2, 0, 8, 255, 1]) * 4, "damaged"),
    "no run": (HEADER + b"\n-Y 1 +X 8\n" + bytes([2, 2, 0, 8, 0, 1]) * 4, "damaged"),
    "repeats nothing": (HEADER + b"\n-Y 1 +X 3\n" + bytes([1, 1, 1, 3]), "damaged"),
    "repeats too much": (HEADER + b"\n-Y 1 +X 3\n" + bytes([9, 9, 9, 128, 1, 1, 1, 200]), "damaged"),
}


@pytest.mark.parametrize("kind", BAD)
def test_bad_files(tmp_path, kind):
    """One clear error that names the file."""
    data, words = BAD[kind]
    path = tmp_path / "bad.hdr"
    path.write_bytes(data)
    with pytest.raises(ValueError, match=words) as found:
        read_hdr(path)
    assert str(path) in str(found.value)
