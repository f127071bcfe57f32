"""Pictures of any common image format, as light between 0 and 1; and PNG.

Which library reads a file is decided here, by suffix and depth, because each has formats that it gets wrong
without a word: Pillow cuts 16-bit colour to 8 bits, imageio clips float formats.
"""

import logging
import struct
import zlib
from io import BytesIO
from pathlib import Path
from typing import Literal

import numpy as np

from warpfluid.files.atomic import replacing
from warpfluid.files.exr import read_exr
from warpfluid.files.limits import FLAT_PICTURE, SMALL, check_pixels
from warpfluid.files.quiet import quiet

IMAGE_SUFFIXES = (".bmp", ".exr", ".jpeg", ".jpg", ".png", ".tif", ".tiff", ".webp")
OF_VIEWS = "Views of warpfluid inspect"  # title of its picture, which lies beside footage and is none
HEAD = 256  # bytes of a picture in which its title stands

# Pillow goes by what is in a file, and has formats that it opens with other programs.
PILLOW_FORMATS = ("BMP", "JPEG", "PNG", "TIFF", "WEBP")
FLAT_FORMATS = ("PNG", "WEBP", "TIFF")  # that store one colour in next to nothing

Depth = Literal["8 bit", "16 bit", "float"]

_PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"


def read_image(path: str | Path) -> np.ndarray:
    """Read a picture as light.

    Args:
        path: A file with one of ``IMAGE_SUFFIXES``.

    Returns:
        Light, float32, shape (rows, columns, 1 or 3), top row first. Integer formats are scaled to 0..1,
        float formats kept. Colours are multiplied by alpha, so what is transparent is black; the alpha of EXR
        files is multiplied in already, by convention, and ignored.

    Raises:
        OSError: If the file cannot be opened.
        ValueError: If it is damaged, too large, or of an unknown kind.
    """
    return decode_image(path)[0]


def decode_image(path: str | Path) -> tuple[np.ndarray, Depth]:
    """Read a picture like ``read_image``, and tell how fine its steps are."""
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in IMAGE_SUFFIXES:
        raise ValueError(f"{path} is of an unknown kind: convert it to one of {' '.join(IMAGE_SUFFIXES)}")
    if suffix == ".exr":
        return read_exr(path), "float"
    data = path.read_bytes()
    try:
        samples = _decode(data, suffix)
        light = to_light(samples)
    except Exception as error:  # decoders fail on damaged files in every way there is
        raise ValueError(f"{path} cannot be read: {str(error) or type(error).__name__}") from error
    depths: dict[tuple[str, int], Depth] = {("u", 1): "8 bit", ("u", 2): "16 bit"}
    return light, depths.get((samples.dtype.kind, samples.dtype.itemsize), "float")


def to_light(samples: np.ndarray) -> np.ndarray:
    """Scale pixels to light: integers to 0..1, colours multiplied by alpha.

    Args:
        samples: Pixels, uint8, uint16 or float, shape (rows, columns[, channels]), top row first: grey, grey
            and alpha, RGB or RGBA.

    Returns:
        Light, float32, shape (rows, columns, 1 or 3).

    Raises:
        ValueError: If the pixels are of another type or number of channels.
    """
    samples = samples[..., None] if samples.ndim == 2 else samples
    if samples.ndim != 3 or samples.shape[2] not in (1, 2, 3, 4):
        raise ValueError(f"pixels have the shape {samples.shape}, not that of a grey or RGB picture")
    if samples.dtype.kind != "f" and not _is_8_or_16_bit(samples.dtype):
        raise ValueError(f"pixels are {samples.dtype}: 8 bit, 16 bit and float can be read")
    light = samples.astype(np.float32)
    if samples.dtype.kind != "f":
        light /= np.float32(np.iinfo(samples.dtype).max)
    if samples.shape[2] in (2, 4):
        return light[..., :-1] * light[..., -1:]
    return light


def write_png(path: str | Path, array: np.ndarray, *, title: str | None = None) -> None:
    """Write a picture as PNG, 8 or 16 bits a channel.

    Args:
        path: The file; its folder must exist.
        array: Pixels, uint8 or uint16, shape (rows, columns[, 1 or 3]), top row first.
        title: Noted in the file, in Latin-1.

    Raises:
        OSError: If the file cannot be written.
        ValueError: If the array has another type or shape.
    """
    array = np.asarray(array)
    pixels = array[..., None] if array.ndim == 2 else array
    if not _is_8_or_16_bit(array.dtype) or pixels.ndim != 3 or pixels.shape[2] not in (1, 3):
        raise ValueError(f"{path} needs uint8 or uint16, shape (rows, columns[, 3]), not {array.dtype} {array.shape}")
    if not pixels.size:
        raise ValueError(f"{path} would have no pixels: the shape is {array.shape}")
    with replacing(path) as file:
        file.write(_encode_png(pixels, title))


def is_of_views(path: Path) -> bool:
    """Return whether a file is the picture that ``inspect`` makes of the views, by its title."""
    try:
        with path.open("rb") as file:
            return b"Title\0" + OF_VIEWS.encode() in file.read(HEAD)
    except OSError:
        return False


def _is_8_or_16_bit(dtype: np.dtype) -> bool:
    return dtype.kind == "u" and dtype.itemsize <= 2


def _encode_png(pixels: np.ndarray, title: str | None) -> bytes:
    """Return a PNG file of pixels (rows, columns, channels)."""
    rows, columns, channels = pixels.shape
    big_endian = np.ascontiguousarray(pixels, dtype=pixels.dtype.newbyteorder(">"))
    lines = big_endian.view(np.uint8).reshape(rows, -1)
    filtered = np.empty((rows, lines.shape[1] + 1), np.uint8)
    filtered[:, 0] = 2  # the filter "up": what is left after subtracting the row above is smaller
    filtered[0, 1:] = lines[0]
    np.subtract(lines[1:], lines[:-1], out=filtered[1:, 1:])
    color_type = {1: 0, 3: 2}[channels]
    header = struct.pack(">IIBBBBB", columns, rows, 8 * pixels.dtype.itemsize, color_type, 0, 0, 0)
    text = [(b"tEXt", b"Title\0" + title.encode("latin-1"))] if title else []
    chunks = [(b"IHDR", header), *text, (b"IDAT", zlib.compress(filtered, 6)), (b"IEND", b"")]
    framed = [
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body)) for kind, body in chunks
    ]
    return _PNG_SIGNATURE + b"".join(framed)


def _decode(data: bytes, suffix: str) -> np.ndarray:
    """Return the pixels of an image file as it holds them, grey or RGB, with alpha or without."""
    if not data:
        raise ValueError("the file is empty")
    if suffix in (".tif", ".tiff"):
        return _decode_tiff(data)
    if data.startswith(_PNG_SIGNATURE) and data[24:25] == b"\x10":
        return _decode_deep_png(data)
    return _decode_with_pillow(data)


def _decode_with_pillow(data: bytes) -> np.ndarray:
    from PIL import Image, ImageOps

    with Image.open(BytesIO(data), formats=PILLOW_FORMATS) as image:
        small = FLAT_PICTURE if image.format in FLAT_FORMATS else SMALL
        check_pixels(*image.size, len(image.getbands()), len(data), small)
        if image.format in ("PNG", "WEBP") and getattr(image, "is_animated", False):
            raise ValueError("it is an animation: convert it to a video or to numbered images")
        if image.mode == "F" or image.mode.startswith("I;16"):
            return np.array(image)
        grey = image.mode in ("1", "L", "LA", "La")
        mode = ("L" if grey else "RGB") + ("A" if image.has_transparency_data else "")
        return np.array(ImageOps.exif_transpose(image).convert(mode))  # phones turn pictures by a tag only


def _decode_deep_png(data: bytes) -> np.ndarray:
    """Decode a PNG of 16 bits with FFmpeg's decoder, whose planes hold the very samples of the file."""
    import av

    channels = {0: 1, 2: 3, 4: 2}.get(data[25], 4)
    check_pixels(*struct.unpack(">II", data[16:24]), channels, len(data), FLAT_PICTURE)
    frames = av.CodecContext.create("png", "r").decode(av.Packet(data))
    if not frames:
        raise ValueError("the file is cut off")
    (frame,) = frames
    channels = {"gray16be": 1, "ya16be": 2, "rgb48be": 3, "rgba64be": 4}[frame.format.name]
    lines = np.frombuffer(frame.planes[0], ">u2").reshape(frame.height, -1)  # with padding
    return lines[:, : frame.width * channels].reshape(frame.height, frame.width, channels)


def _decode_tiff(data: bytes) -> np.ndarray:
    """Decode the first page with tifffile, or with Pillow what that knows in full: more compressions."""
    import tifffile

    logging.getLogger("tifffile").setLevel(logging.CRITICAL)  # its complaints become the one error of ours
    with tifffile.TiffFile(BytesIO(data)) as file:
        if not len(file.pages):
            raise ValueError("the file is cut off")
        page = file.pages[0]
        rows = page.imagelength * page.imagedepth
        check_pixels(page.imagewidth, rows, page.samplesperpixel, len(data), FLAT_PICTURE)
        deep_grey = page.samplesperpixel == 1 and page.dtype in (np.uint16, np.float32)
        if page.bitspersample <= 8 or deep_grey:
            logging.getLogger("PIL").setLevel(logging.CRITICAL)
            with quiet(pass_on=False):
                return _decode_with_pillow(data)
        try:
            pixels = page.asarray()
        except (ValueError, KeyError) as error:
            if "imagecodecs" not in str(error):
                raise
            raise ValueError("its compression is unknown: save it with ZIP or as EXR") from error
        pixels = np.moveaxis(pixels, 0, -1) if page.axes == "SYX" else pixels
        straight_alpha = page.extrasamples == (tifffile.EXTRASAMPLE.UNASSALPHA,)
        colors = page.samplesperpixel - (0 if straight_alpha else len(page.extrasamples))
        return pixels[..., :colors] if page.extrasamples else pixels
