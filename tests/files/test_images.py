"""Pictures of common formats, and PNG."""

import struct
import zlib

import av
import numpy as np
import pytest
import tifffile
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from warpfluid.files.exr import write_exr
from warpfluid.files.images import IMAGE_SUFFIXES, _decode, decode_image, read_image, to_light, write_png


def samples(dtype, channels=3, rows=9, columns=13):
    """Return random integers over the full range of a type."""
    shape = (rows, columns, channels) if channels else (rows, columns)
    return np.random.default_rng(0).integers(0, np.iinfo(dtype).max + 1, shape, dtype=dtype)


def write_deep_png(path, pixels):
    """Write a 16-bit PNG with or without alpha, each row unfiltered: the plainest file there is."""
    rows, columns, channels = pixels.shape
    color_type = {1: 0, 2: 4, 3: 2, 4: 6}[channels]
    body = b"".join(b"\0" + row.astype(">u2").tobytes() for row in pixels)
    chunks = [(b"IHDR", struct.pack(">IIBBBBB", columns, rows, 16, color_type, 0, 0, 0))]
    chunks += [(b"IDAT", zlib.compress(body)), (b"IEND", b"")]
    data = b"\x89PNG\r\n\x1a\n"
    for kind, content in chunks:
        data += struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
    path.write_bytes(data)


@pytest.mark.parametrize("channels", [0, 1, 3])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_png_comes_back_exactly(tmp_path, dtype, channels):
    """Every one of 256 or 65536 values survives, grey or colour."""
    pixels = samples(dtype, channels, rows=300, columns=400)
    write_png(tmp_path / "a.png", pixels)
    light, depth = decode_image(tmp_path / "a.png")
    assert light.dtype == np.float32
    assert light.shape == (300, 400, channels or 1)
    assert depth == ("8 bit" if dtype is np.uint8 else "16 bit")
    assert np.array_equal(np.rint(light.astype(np.float64) * np.iinfo(dtype).max), pixels.reshape(light.shape))


@given(rows=st.integers(1, 9), columns=st.integers(1, 9), rgb=st.booleans())
@settings(max_examples=20, deadline=None)
def test_other_programs_read_our_png(tmp_path_factory, rows, columns, rgb):
    """Pillow and FFmpeg, as independent readers, find the same pixels."""
    folder = tmp_path_factory.mktemp("png")
    pixels = samples(np.uint8, 3 if rgb else 0, rows, columns)
    write_png(folder / "8.png", pixels)
    with Image.open(folder / "8.png") as image:
        assert np.array_equal(np.array(image), pixels)
    deep = samples(np.uint16, 3 if rgb else 0, rows, columns)
    write_png(folder / "16.png", deep)
    with av.open(str(folder / "16.png")) as file:
        frame = next(file.decode(video=0))
    assert np.array_equal(frame.to_ndarray(format="rgb48be" if rgb else "gray16be"), deep)


def test_png_takes_any_memory_layout(tmp_path):
    """Mirrored and turned arrays are written as they look, and byte order does not matter."""
    pixels = samples(np.uint16)[::-1, :, ::-1].transpose(1, 0, 2)
    write_png(tmp_path / "a.png", pixels)
    write_png(tmp_path / "b.png", pixels.astype(">u2"))
    assert np.array_equal(read_image(tmp_path / "a.png"), to_light(pixels))
    assert np.array_equal(read_image(tmp_path / "b.png"), to_light(pixels))


@pytest.mark.parametrize(
    "array",
    [np.zeros((2, 2)), np.zeros((2, 2, 4), np.uint8), np.zeros(3, np.uint8), np.zeros((0, 2), np.uint8)],
)
def test_png_refuses_other_arrays(tmp_path, array):
    """Floats are not scaled by guess, and nothing is left behind."""
    with pytest.raises(ValueError, match=r"a\.png"):
        write_png(tmp_path / "a.png", array)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_deep_png_is_read_exactly(tmp_path, channels):
    """Grey or colour, with alpha or without: every sample counts."""
    pixels = samples(np.uint16, channels)
    write_deep_png(tmp_path / "a.png", pixels)
    exact = pixels / 65535
    expected = exact if channels in (1, 3) else exact[..., :-1] * exact[..., -1:]
    assert np.allclose(read_image(tmp_path / "a.png"), expected, rtol=0, atol=1e-7)


@pytest.mark.parametrize(
    ("mode", "channels"), [("1", 1), ("L", 1), ("LA", 1), ("P", 3), ("RGB", 3), ("RGBA", 3), ("I;16", 1)]
)
def test_every_kind_of_png_is_read(tmp_path, mode, channels):
    """What Pillow can write is read as grey or RGB, alpha multiplied in."""
    if mode == "I;16":
        image = Image.fromarray(samples(np.uint16, 0))
        expected = np.array(image)[..., None] / 65535
    else:
        image = Image.fromarray(samples(np.uint8, 4)).convert(mode)
        straight = np.array(image.convert("RGBA")) / 255
        expected = (straight[..., :3] * straight[..., 3:])[..., :channels]
    image.save(tmp_path / "a.png")
    light = read_image(tmp_path / "a.png")
    assert light.shape == (9, 13, channels)
    assert np.allclose(light, expected, atol=1e-6)


def test_transparent_palette_entries_are_black(tmp_path):
    """A palette may have one transparent colour."""
    image = Image.new("P", (2, 1))
    image.putpalette([200, 100, 50, 0, 0, 255])
    image.putdata([0, 1])
    image.save(tmp_path / "a.png", transparency=1)
    assert np.allclose(read_image(tmp_path / "a.png") * 255, [[[200, 100, 50], [0, 0, 0]]])


@pytest.mark.parametrize("suffix", [".jpg", ".jpeg", ".webp", ".bmp", ".tif"])
def test_lossy_and_plain_formats_are_read(tmp_path, suffix):
    """A smooth picture comes back within the format's losses."""
    ramp = np.linspace(0, 255, 64).astype(np.uint8)
    pixels = np.stack([np.tile(ramp, (48, 1))] * 3, axis=-1)
    Image.fromarray(pixels).save(tmp_path / f"a{suffix}")
    light, depth = decode_image(tmp_path / f"a{suffix}")
    assert depth == "8 bit"
    assert np.allclose(light, pixels / 255, atol=0.03)


def test_a_jpeg_in_print_colours_is_read(tmp_path):
    """CMYK becomes RGB."""
    Image.new("CMYK", (16, 16), (0, 255, 255, 0)).save(tmp_path / "a.jpg")
    assert np.allclose(read_image(tmp_path / "a.jpg")[8, 8], [1, 0, 0], atol=0.02)


def test_a_phone_picture_is_upright(tmp_path):
    """The orientation tag is obeyed."""
    image = Image.new("L", (32, 16))
    image.paste(255, (0, 0, 16, 16))
    exif = image.getexif()
    exif[0x0112] = 6  # to be turned clockwise
    image.save(tmp_path / "a.jpg", exif=exif)
    light = read_image(tmp_path / "a.jpg")
    assert light.shape == (32, 16, 1)
    assert light[:14].min() > 0.9
    assert light[18:].max() < 0.1


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"compression": "zlib"},
        {"compression": "zlib", "predictor": 2},
        {"byteorder": ">"},
        {"tile": (16, 16)},
        {"bigtiff": True},
    ],
)
@pytest.mark.parametrize("channels", [0, 3])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_integer_tiff_is_read_exactly(tmp_path, dtype, channels, options):
    """Whatever the layout, every sample counts."""
    pixels = samples(dtype, channels)
    tifffile.imwrite(tmp_path / "a.tif", pixels, photometric="rgb" if channels else "minisblack", **options)
    light, depth = decode_image(tmp_path / "a.tif")
    assert depth == ("8 bit" if dtype is np.uint8 else "16 bit")
    assert np.array_equal(light, to_light(pixels))


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64])
@pytest.mark.parametrize("channels", [0, 3])
def test_float_tiff_is_kept(tmp_path, dtype, channels):
    """Float light is not scaled and not clipped."""
    pixels = np.random.default_rng(0).lognormal(size=(9, 13, channels or 1)).astype(dtype)
    photometric = "rgb" if channels else "minisblack"
    tifffile.imwrite(tmp_path / "a.tiff", pixels if channels else pixels[..., 0], photometric=photometric)
    light, depth = decode_image(tmp_path / "a.tiff")
    assert depth == "float"
    assert np.array_equal(light, pixels.astype(np.float32))


def test_tiff_planes_are_put_together(tmp_path):
    """Colours may be stored one after the other."""
    pixels = samples(np.uint16)
    planes = np.ascontiguousarray(np.moveaxis(pixels, -1, 0))
    tifffile.imwrite(tmp_path / "a.tif", planes, photometric="rgb", planarconfig="separate")
    assert np.array_equal(read_image(tmp_path / "a.tif"), to_light(pixels))


def test_deep_tiff_alpha_is_multiplied_in(tmp_path):
    """What is transparent is black."""
    pixels = samples(np.uint16, 4)
    tifffile.imwrite(tmp_path / "a.tif", pixels, photometric="rgb", extrasamples=["unassalpha"])
    assert np.array_equal(read_image(tmp_path / "a.tif"), to_light(pixels))
    tifffile.imwrite(tmp_path / "b.tif", pixels, photometric="rgb", extrasamples=["assocalpha"])
    assert np.array_equal(read_image(tmp_path / "b.tif"), to_light(pixels[..., :3]))


@pytest.mark.parametrize("mode", ["L", "RGB", "P", "1"])
def test_lzw_tiff_is_read(tmp_path, mode):
    """The commonest compression needs no further package."""
    image = Image.fromarray(samples(np.uint8)).convert(mode)
    image.save(tmp_path / "a.tif", compression="tiff_lzw")
    assert np.allclose(read_image(tmp_path / "a.tif"), np.array(image.convert("RGB")) / 255)


def test_exr_is_read(tmp_path):
    """EXR is float, and brighter than 1 where it is."""
    pixels = np.full((2, 3, 3), 7.5, np.float32)
    write_exr(tmp_path / "a.EXR", {"RGB": pixels})
    light, depth = decode_image(tmp_path / "a.EXR")
    assert depth == "float"
    assert np.array_equal(light, pixels)


def make(path, suffix):
    """Write a picture of noise in the format."""
    if suffix == "16.png":
        write_png(path, samples(np.uint16, rows=60, columns=50))
    elif suffix == "16.tif":
        tifffile.imwrite(path, samples(np.uint16, rows=60, columns=50), photometric="rgb")
    else:
        Image.fromarray(samples(np.uint8, rows=60, columns=50)).save(path)


@pytest.mark.parametrize("share", [0.0, 0.002, 0.03, 0.5, 0.95])
@pytest.mark.parametrize("suffix", [".png", "16.png", ".jpg", ".webp", ".bmp", ".tif", "16.tif"])
def test_a_cut_off_file_is_one_quiet_error(tmp_path, capfd, suffix, share):
    """However much is missing, a ValueError names the file, and nothing is printed."""
    path = tmp_path / f"a{suffix}"
    make(path, suffix)
    path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
    with pytest.raises(ValueError, match=rf"a{suffix}"):
        read_image(path)
    assert capfd.readouterr() == ("", "")


@given(data=st.data())
@settings(max_examples=150, deadline=None)
def test_damaged_files_end_in_a_value_error_if_at_all(tmp_path_factory, data):
    """Random damage never ends in a foreign exception."""
    suffix = data.draw(st.sampled_from([".png", "16.png", ".jpg", ".webp", ".bmp", ".tif", "16.tif"]))
    path = tmp_path_factory.mktemp("damage") / f"a{suffix}"
    make(path, suffix)
    content = bytearray(path.read_bytes())
    for position in data.draw(st.lists(st.integers(0, 300), min_size=1, max_size=8)):
        content[position] = data.draw(st.integers(0, 255))
    path.write_bytes(content)
    error = None
    try:
        assert read_image(path).shape[2] in (1, 3)
    except ValueError as found:
        error = found
    assert error is None or str(path) in str(error)


@pytest.mark.parametrize(
    ("suffix", "mode", "size", "options"),
    [
        (".webp", "RGB", (5120, 2880), {"lossless": True}),
        (".png", "1", (8192, 8192), {}),
        (".tif", "1", (8192, 8192), {"compression": "group4"}),
    ],
)
def test_large_pictures_of_one_colour_are_read(tmp_path, suffix, mode, size, options):
    """They are a few bytes for megapixels, and no trap."""
    Image.new(mode, size).save(tmp_path / f"a{suffix}", **options)
    data = (tmp_path / f"a{suffix}").read_bytes()
    assert len(data) < 10_000
    assert _decode(data, suffix).shape[:2] == size[::-1]


@pytest.mark.parametrize("bits", [8, 16])
def test_an_absurd_size_is_refused(tmp_path, bits):
    """A header that claims ten gigapixels is refused before memory is taken."""
    header = struct.pack(">IIBBBBB", 100_000, 100_000, bits, 2, 0, 0, 0)
    chunk = b"IHDR" + header
    data = b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + chunk + struct.pack(">I", zlib.crc32(chunk))
    (tmp_path / "a.png").write_bytes(data + struct.pack(">I", 0) + b"IDAT" + struct.pack(">I", zlib.crc32(b"IDAT")))
    with pytest.raises(ValueError, match=r"a\.png .*(100000 x 100000|decompression bomb)"):
        read_image(tmp_path / "a.png")


@pytest.mark.parametrize("suffix", [".webp", ".png"])
def test_animations_are_refused(tmp_path, suffix):
    """A moving picture is not read as its first frame without a word."""
    first, second = (Image.fromarray(samples(np.uint8)[::step]) for step in (1, -1))
    first.save(tmp_path / f"a{suffix}", save_all=True, append_images=[second])
    with pytest.raises(ValueError, match="animation: convert it to a video"):
        read_image(tmp_path / f"a{suffix}")


@pytest.mark.parametrize("name", ["a.hdr", "a.dpx", "a.gif", "a"])
def test_other_kinds_are_refused(tmp_path, name):
    """The error lists what can be read."""
    (tmp_path / name).touch()
    with pytest.raises(ValueError, match=" ".join(IMAGE_SUFFIXES).replace(".", r"\.")):
        read_image(tmp_path / name)


def test_a_missing_file_is_an_os_error(tmp_path):
    """The error names the file."""
    with pytest.raises(FileNotFoundError, match=r"a\.png"):
        read_image(tmp_path / "a.png")


@pytest.mark.parametrize(
    "pixels", [np.zeros((2, 2, 5)), np.zeros(3), np.zeros((2, 2), np.int32), np.zeros((2, 2), bool)]
)
def test_to_light_refuses_what_is_no_picture(pixels):
    """Only the types whose white is known are scaled."""
    with pytest.raises(ValueError, match="pixels"):
        to_light(pixels)
