"""Small sound files of every kind that warpfluid reads, ways to damage them, and what reads them; for ``fuzz.py``."""

import io
import json
import random
import re
import struct
import tempfile
import zipfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import numpy as np

EXTREMES = (0, 1, 2, 0x7F, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF, 2**63 - 1, 2**64 - 1, 10**9, 2**40)
REALS = (0.0, -0.0, 1e-320, 1e38, 1e300, float("inf"), float("-inf"), float("nan"))
WORDS = (b"-1", b"0", b"99999999999", b"1e999", b"nan", b"1" * 400, b"", b"[" * 3000, b"\xff\xfe", b"%s", b"../x")
PNG = b"\x89PNG\r\n\x1a\n"


@dataclass(frozen=True)
class Kind:
    """A kind of file.

    Attributes:
        make: Returns sound files, each an ending and its bytes.
        read: Reads a file in every way that warpfluid does.
        harm: Damages a file; where there are checksums it puts them right again, so that damage goes deep.
    """

    make: Callable[[], list[tuple[str, bytes]]]
    read: Callable[[Path], object]
    harm: Callable[[bytes, random.Random], bytes]


# %%
# Damage: a few blows a file, anywhere or near its head, where a byte weighs most.


def damage(data: bytes, chance: random.Random) -> bytes:
    """Return a file with a few flips, cuts, insertions and extreme numbers."""
    for _ in range(chance.choice((1, 1, 1, 2, 2, 4, 8))):
        blow = chance.choice((_flip, _flip, _number, _number, _real, _word, _cut, _leave_out, _repeat, _swap))
        data = blow(data or b"\0", _place(data or b"\0", chance), chance)
    return data


def _place(data: bytes, chance: random.Random) -> int:
    reach = len(data) if chance.random() < 0.6 else min(len(data), 400)
    return chance.randrange(reach)


def _flip(data: bytes, at: int, chance: random.Random) -> bytes:
    return data[:at] + bytes([data[at] ^ 1 << chance.randrange(8)]) + data[at + 1 :]


def _number(data: bytes, at: int, chance: random.Random) -> bytes:
    size, order = chance.choice((1, 2, 4, 4, 8)), chance.choice(("little", "big"))
    number = (chance.choice(EXTREMES) + chance.choice((-1, 0, 0, 1))) % 256**size
    return data[:at] + number.to_bytes(size, order) + data[at + size :]


def _real(data: bytes, at: int, chance: random.Random) -> bytes:
    form = chance.choice(("<f", "<d", ">d"))
    with np.errstate(over="ignore"):
        value = float(np.float32(chance.choice(REALS))) if form == "<f" else chance.choice(REALS)
    packed = struct.pack(form, value)
    return data[:at] + packed + data[at + len(packed) :]


def _word(data: bytes, at: int, chance: random.Random) -> bytes:
    """Put a word in place of a number in text, where there is one."""
    found = re.compile(rb"\d+").search(data, at) or re.compile(rb"\d*").search(data, at)
    return data[: found.start()] + chance.choice(WORDS) + data[found.end() :]


def _cut(data: bytes, at: int, _: random.Random) -> bytes:
    return data[:at]


def _leave_out(data: bytes, at: int, chance: random.Random) -> bytes:
    return data[:at] + data[at + chance.choice((1, 4, 64, 4096)) :]


def _repeat(data: bytes, at: int, chance: random.Random) -> bytes:
    part = data[at : at + chance.choice((1, 8, 64, 512))]
    return data[:at] + part * chance.choice((2, 3, 20)) + data[at + len(part) :]


def _swap(data: bytes, at: int, chance: random.Random) -> bytes:
    size = chance.choice((1, 4, 8, 64))
    other = _place(data, chance)
    return data[:at] + data[other : other + size] + data[at + size :]


# %%
# Sound files.


def blobs(shape=(12, 10, 9)) -> dict[str, np.ndarray]:
    """Return a density and a velocity of a few voxels, shape (x, y, z)."""
    density = np.zeros(shape, np.float32)
    density[2:9, 3:8, 1:6] = np.random.default_rng(1).random((7, 5, 5), np.float32)
    return {"density": density, "velocity": np.stack([density] * 3, axis=-1)}


def picture(rows=20, columns=26) -> np.ndarray:
    """Return a smooth picture, uint8, shape (rows, columns, 3)."""
    y, x = np.mgrid[:rows, :columns]
    return np.stack([(9 * x) % 256, (11 * y) % 256, (5 * x + 3 * y) % 256], axis=-1).astype(np.uint8)


def written(ending: str, *writers: Callable[[Path], object]) -> list[tuple[str, bytes]]:
    """Return what writers of files write."""
    with tempfile.TemporaryDirectory() as folder:
        path, made = Path(folder) / f"a{ending}", []
        for write in writers:
            write(path)
            made.append((ending, path.read_bytes()))
    return made


def vdb_files():
    """Sparse and half, of one grid and of two, far apart, with and without our checksum."""
    from warpfluid.files.vdb import write_vdb

    wide = np.zeros((300, 4, 4), np.float32)
    wide[[0, -1]] = 1
    made = written(
        ".vdb",
        lambda path: write_vdb(path, blobs(), voxel_size=0.5),
        lambda path: write_vdb(path, blobs(), half=True, up="z", metadata={"frame": 3}),
        lambda path: write_vdb(path, {"density": wide}),
    )
    return made + [(ending, data[:35] + b"4" + data[36:]) for ending, data in made]


def harm_vdb(data: bytes, chance: random.Random) -> bytes:
    """Sign half of the damaged files anew; take the signature from the others."""
    from warpfluid.files.vdb import layout

    data = damage(data, chance)
    if chance.random() < 0.5:
        return data[: layout.ID.start] + layout.content_id(data) + data[layout.ID.stop :]
    return data[:35] + b"4" + data[36:]


def read_volumes(path: Path):
    """Read volumes as the commands do, then alone, with the other axis up."""
    from warpfluid.volumes import file_facts, open_volumes, read_grids

    file_facts(path)
    read_grids(path, up="z")
    sequence = open_volumes(path)
    for frame in sequence.frames:
        sequence.fields(frame, ("density", "velocity"))


def blosc_files():
    """A block that is stored, one packed with LZ4, one shuffled."""
    values = np.arange(512, dtype="<f4").tobytes()
    ones = b"\x4f\x00\x00\x80\x3f\x04\x00" + b"\xff" * 7 + b"\xeb" + b"\x50\x3f\x00\x00\x80\x3f"
    packed = struct.pack("<II", 20, len(ones)) + ones
    mixed = b"\xf0" + b"\xff" * 7 + b"\xf8" + values
    mixed = struct.pack("<II", 20, len(mixed)) + mixed
    bodies = ((2, values), (1 << 5 | 16, packed), (1 << 5 | 17, mixed))
    return [
        (".blosc", struct.pack("<4B3I", 2, 1, flags, 4, 2048, 2048, 16 + len(body)) + body) for flags, body in bodies
    ]


def read_block(path: Path):
    """Open a block of Blosc; its errors do not know the file."""
    from warpfluid.files.vdb.blosc import unpack

    try:
        unpack(path.read_bytes(), 2048)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def nvdb_files():
    """Packed and plain."""
    from warpfluid.files.nvdb import write_nvdb

    return written(
        ".nvdb",
        lambda path: write_nvdb(path, blobs(), packed=True),
        lambda path: write_nvdb(path, blobs(), packed=False),
    )


def npz_files():
    """Ours with one grid, ours with two, NumPy's own."""
    from warpfluid.files.npz import write_npz, write_npz_grids

    return written(
        ".npz",
        lambda path: write_npz(path, blobs()["density"], voxel_size=0.5, frame=3, note="a"),
        lambda path: write_npz_grids(path, blobs(), voxel_size=0.5, origin=(0.0, 1.0, 2.0), half=True),
        lambda path: np.savez(path, **blobs(), voxel_size=2, origin=np.arange(3)),
    )


def harm_npz(data: bytes, chance: random.Random) -> bytes:
    """Damage the archive, or what is in it."""
    if chance.random() < 0.3:
        return damage(data, chance)
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as archive, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as packed:
        for name in archive.namelist():
            content = archive.read(name)
            packed.writestr(name, damage(content, chance) if chance.random() < 0.4 else content)
    return out.getvalue()


def vti_files():
    """Ours, and VTK's in three encodings."""
    import pyvista

    from warpfluid.files.vti import write_vti

    image = pyvista.ImageData(dimensions=(5, 6, 7))
    image.point_data["density"] = np.arange(210, dtype=np.float32) / 210

    def with_vtk(mode: str, packed: bool):
        def write(path: Path):
            from vtkmodules.vtkIOXML import vtkXMLImageDataWriter

            writer = vtkXMLImageDataWriter()
            writer.SetFileName(str(path))
            writer.SetInputData(image)
            getattr(writer, f"SetDataModeTo{mode}")()
            writer.SetCompressorTypeToZLib() if packed else writer.SetCompressorTypeToNone()
            writer.Write()

        return write

    ours = written(".vti", lambda path: write_vti(path, blobs(), voxel_size=0.5))
    return ours + written(
        ".vti",
        *(with_vtk(mode, packed) for mode in ("Appended", "Binary", "Ascii") for packed in (True, False)),
    )


def exr_files():
    """Scan lines of every common compression, tiles, a small data window, two parts."""
    import OpenEXR

    colours = np.ascontiguousarray(picture().astype(np.float16) / 255)

    def write(path: Path, compression, more=None, kind=OpenEXR.scanlineimage):
        OpenEXR.File({"compression": compression, "type": kind} | (more or {}), {"RGB": colours}).write(str(path))

    def tiled(path: Path):
        write(path, OpenEXR.ZIP_COMPRESSION, {"tiles": OpenEXR.TileDescription()}, OpenEXR.tiledimage)

    names = ("NO", "RLE", "ZIP", "ZIPS", "PIZ", "PXR24", "B44", "DWAA", "DWAB")
    compressions = [getattr(OpenEXR, f"{name}_COMPRESSION") for name in names]
    return written(".exr", *(lambda path, c=c: write(path, c) for c in compressions), tiled)


def hdr_files():
    """Plain rows, and rows in the new and the old encoding."""
    head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n"
    row = b"\2\2\0\x0a" + b"\x8a\x40" + b"\x8a\x41" + b"\x0a" + bytes(range(10)) + b"\x8a\x82"
    return [
        (".hdr", head + b"-Y 2 +X 4\n" + bytes(range(32))),
        (".hdr", head + b"-Y 3 +X 10\n" + row * 3),
        (".hdr", head + b"+X 2 -Y 10\n" + (b"\x40\x41\x42\x81" + b"\1\1\1\x09") * 2),
    ]


def image_files():
    """Every kind of picture that Pillow and tifffile write, 16 bits and floats too."""
    import tifffile
    from PIL import Image

    from warpfluid.files.images import write_png

    made = []
    for ending, options in ((".png", {}), (".jpg", {}), (".jpg", {"progressive": True}), (".webp", {}), (".bmp", {})):
        made += written(ending, lambda path, options=options: Image.fromarray(picture()).save(path, **options))
    made += written(".webp", lambda path: Image.fromarray(picture()).save(path, lossless=True))
    made += written(".png", lambda path: write_png(path, picture().astype(np.uint16) * 257))
    made += written(".png", lambda path: Image.fromarray(picture()).quantize(16).save(path, transparency=1))
    for pixels in (picture(), picture().astype(np.uint16), picture().astype(np.float32), picture()[..., 0]):
        for packing in (None, "zlib"):
            made += written(
                ".tif",
                lambda path, pixels=pixels, packing=packing: tifffile.imwrite(
                    path, pixels, compression=packing, photometric="rgb" if pixels.ndim == 3 else None
                ),
            )
    for packing in ("tiff_lzw", "jpeg", "packbits"):
        made += written(
            ".tif", lambda path, packing=packing: Image.fromarray(picture()).save(path, compression=packing)
        )
    return made


def harm_picture(data: bytes, chance: random.Random) -> bytes:
    """Put the checksums of the chunks of most PNGs right after damage."""
    data = damage(data, chance)
    if not data.startswith(PNG) or chance.random() < 0.2:
        return data
    out, at = bytearray(PNG), len(PNG)
    while at + 12 <= len(data):
        size = int.from_bytes(data[at : at + 4], "big")
        if at + 12 + size > len(data):
            break
        body = data[at + 4 : at + 8 + size]
        out += data[at : at + 4] + body + struct.pack(">I", zlib.crc32(body))
        at += 12 + size
    return bytes(out) + data[at:]


def read_footage(path: Path):
    """Open footage and read its first and last picture."""
    from warpfluid.files.footage import open_footage

    footage = open_footage(path)
    for frame in {footage.frames[0], footage.frames[-1]}:
        footage.read(frame)


def video_files():
    """Codecs and containers that phones, cameras and editors write."""
    import av

    kinds = (
        (".mp4", "libx264", "yuv420p"),
        (".mov", "prores_ks", "yuv422p10le"),
        (".mov", "png", "rgba"),
        (".avi", "mjpeg", "yuvj420p"),
        (".webm", "libvpx-vp9", "yuv420p"),
        (".mkv", "ffv1", "yuv420p"),
        (".gif", "gif", "rgb8"),
        (".mpg", "mpeg2video", "yuv420p"),
        (".ts", "libx264", "yuv420p"),
    )

    def write(path: Path, codec: str, pixels: str):
        with av.open(str(path), "w") as container:
            stream = container.add_stream(codec, rate=24)
            stream.width, stream.height, stream.pix_fmt = 32, 24, pixels
            for number in range(4):
                frame = av.VideoFrame.from_ndarray(np.roll(picture(24, 32), number, axis=1), format="rgb24")
                container.mux(stream.encode(frame.reformat(format=pixels)))
            container.mux(stream.encode(None))

    made = []
    for ending, codec, pixels in kinds:
        made += written(ending, lambda path, codec=codec, pixels=pixels: write(path, codec, pixels))
    return made


def mesh_files():
    """A cube in all three kinds, as text and as bytes."""
    import pyvista

    cube = pyvista.Cube().triangulate()
    text = "\n".join([*(f"v {x} {y} {z}" for x, y, z in cube.points), "f 1 2 3", "f 1//1 3//3 4//4", "f 5 6 7 8"])
    made = [(".obj", text.encode())]
    for ending in (".stl", ".ply"):
        for binary in (True, False):
            made += written(ending, lambda path, binary=binary: cube.save(path, binary=binary))
    return made


def read_shape(path: Path):
    """Read a mesh."""
    from warpfluid.files.mesh import read_mesh

    read_mesh(path)


def table_files():
    """Settings, records and scenes as text."""
    settings = b"""views = ["0=front.####.png", "90=side.mp4"]
[input]
frames = "1-9x2"
[reconstruct]
iterations = 8
angles = 180
blur = 1.5
[output]
voxel_size = 0.1
half = true
[made-with]
angles = [0, 90]
"""
    scene = b"""size = [96, 144]
[simulate]
fps = 24.0
swirl = "density 0:0;1:4"
[[emitter]]
shape = "sphere"
center = "1:0,1,0;24:1,1,0"
density = 4.0
[[force]]
kind = "wind"
strength = "1:0.5;24:2"
"""
    camera = [{"frame": 1, "angle": 0, "elevation": 5}, {"frame": 24, "angle": 90.5, "distance": 3}]
    body = {"position": [0, 1, 2], "quaternion": [0, 0, 0, 1], "velocity": [0, 0, 0], "spin": [0, 0, 0]}
    bodies = {"names": ["box"], "frames": [{"frame": 1, "bodies": [body]}, {"frame": 2, "bodies": [body]}]}
    look = (files("warpfluid") / "looks" / "fire.json").read_bytes()
    lines = b"".join(json.dumps({"frame": frame, "seconds": 1.5}).encode() + b"\n" for frame in range(1, 5))
    made = [(".toml", settings), (".toml", scene), (".jsonl", lines), (".look.json", look)]
    return made + [
        (f".{name}.json", json.dumps(table).encode()) for name, table in (("camera", camera), ("body", bodies))
    ]


def read_table(path: Path):
    """Read settings, records, bodies, a camera's way or a look."""
    from warpfluid.files.bodies import read_bodies
    from warpfluid.files.lines import read_lines
    from warpfluid.rendering.camera_path import read_camera_path
    from warpfluid.rendering.look_files import read_look
    from warpfluid.settings import read_settings

    readers = {".camera": read_camera_path, ".body": read_bodies, ".look": lambda path: read_look(str(path))}
    readers |= {".toml": read_settings, ".jsonl": read_lines}
    readers[path.suffix if path.suffix in readers else path.suffixes[-2]](path)


def read_probe(path: Path):
    """Read a light probe."""
    from warpfluid.files.hdr import read_hdr

    read_hdr(path)


KINDS = {
    "vdb": Kind(vdb_files, read_volumes, harm_vdb),
    "blosc": Kind(blosc_files, read_block, damage),
    "nvdb": Kind(nvdb_files, read_volumes, damage),
    "npz": Kind(npz_files, read_volumes, harm_npz),
    "vti": Kind(vti_files, read_volumes, damage),
    "exr": Kind(exr_files, read_footage, damage),
    "hdr": Kind(hdr_files, read_probe, damage),
    "image": Kind(image_files, read_footage, harm_picture),
    "video": Kind(video_files, read_footage, damage),
    "mesh": Kind(mesh_files, read_shape, damage),
    "table": Kind(table_files, read_table, damage),
}
