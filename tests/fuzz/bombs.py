"""Files of about a kilobyte that promise ten gigabytes, one of every kind; read each, and print what it cost.

python bombs.py FOLDER
"""

import importlib.util
import io
import json
import re
import resource
import struct
import sys
import time
import zipfile
import zlib
from pathlib import Path

import numpy as np

EXAMPLES = Path(__file__).parents[2] / "examples"
LONG = 2**31 - 1


def sound(kind: str, which: int = 0) -> bytes:
    """Return a small sound file."""
    return FILES.KINDS[kind].make()[which][1]


def replaced(data: bytes, old: bytes, new: bytes) -> bytes:
    """Return data with what stands in it once put otherwise."""
    assert data.count(old) >= 1, old
    return data.replace(old, new)


def vdb_bombs():
    """Our own empty volume with another shape, signed; a node a world apart; a tile of 4096^3; many leaves."""
    from warpfluid.files.vdb import layout, write_vdb

    path = Path(sys.argv[1]) / "made.vdb"
    write_vdb(path, {"density": np.zeros((3, 5, 7), np.float32)})
    wide = bytearray(replaced(path.read_bytes(), struct.pack("<3i", 3, 5, 7), struct.pack("<3i", 1400, 1400, 1400)))
    wide[layout.ID] = layout.content_id(wide)
    write_vdb(path, {"density": np.ones((1, 1, 1), np.float32)})
    data = path.read_bytes()
    unsigned = data[:35] + b"4" + data[36:]
    root = data.index(struct.pack("<i4xII", 1, 0, 1))
    tile = struct.pack("<3ifB", 0, 0, 0, 1.0, 1)
    tiles = (unsigned[:root] + struct.pack("<i4xII", 1, 1, 0) + tile).ljust(len(unsigned), b"\0")
    far = replaced(unsigned, struct.pack("<II3i", 0, 1, 0, 0, 0), struct.pack("<II3i", 0, 2**32 - 1, 0, 0, 0))
    return {"shape.vdb": bytes(wide), "tile.vdb": tiles, "nodes.vdb": far}


def nvdb_bombs():
    """A grid that opens to 10 GB; a box of 2000^3."""
    from warpfluid.files.nvdb import layout

    data, at = bytearray(sound("nvdb")), layout.FILE_HEAD.itemsize
    struct.pack_into("<Q", data, at, 10**10)
    box = bytearray(sound("nvdb"))
    struct.pack_into("<6i", box, at + layout.GRID_ENTRY.fields["box"][1], 0, 0, 0, 2000, 2000, 2000)
    return {"memory.nvdb": bytes(data), "box.nvdb": bytes(box)}


def npz_bombs():
    """An array without its numbers, one that claims a member of 10 GB, one packed by LZMA, which packs bombs best."""
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(head, {"descr": "<f4", "fortran_order": False, "shape": (1400,) * 3})
    made = {}
    for name, body, method in (
        ("array.npz", head.getvalue(), zipfile.ZIP_DEFLATED),
        ("lzma.npz", head.getvalue() + bytes(4_000_000), zipfile.ZIP_LZMA),
        ("member.npz", head.getvalue() + bytes(400_000), zipfile.ZIP_DEFLATED),
    ):
        out = io.BytesIO()
        with zipfile.ZipFile(out, "w", method) as archive:
            archive.writestr("density.npy", body)
        made[name] = out.getvalue()
    size = struct.pack("<I", len(head.getvalue()) + 400_000)
    made["member.npz"] = made["member.npz"].replace(size, struct.pack("<I", 2**32 - 2))
    return made


def vti_bombs():
    """An extent of 1400^3 voxels; a number of blocks without end."""
    data = sound("vti")
    blocks = data.index(b'encoding="raw">\n_') + len(b'encoding="raw">\n_')
    return {
        "extent.vti": data.replace(b"0 11 0 9 0 8", b"0 1399 0 1399 0 1399"),
        "blocks.vti": data[:blocks] + struct.pack("<Q", 2**61) + data[blocks + 8 :],
    }


def picture_bombs():
    """Sizes of 8000 x 8000 where no flat picture is that small, else of 9000 x 9000, and of 60000 x 60000."""
    header = b"IHDR" + struct.pack(">IIBBBBB", 9000, 9000, 8, 6, 0, 0, 0)
    png = FILES.PNG + struct.pack(">I", 13) + header + struct.pack(">I", zlib.crc32(header))
    packed = b"IDAT" + zlib.compress(bytes(400_000))
    png += struct.pack(">I", len(packed) - 4) + packed + struct.pack(">I", zlib.crc32(packed))
    jpeg = bytearray(sound("image", 1))
    start = jpeg.index(b"\xff\xc0") + 5
    jpeg[start : start + 4] = struct.pack(">HH", 8000, 8000)
    bmp = bytearray(sound("image", 4))
    bmp[18:26] = struct.pack("<ii", 8000, 8000)
    sides = rb"([\x00\x01]\x01[\x03\x04]\x00\x01\x00\x00\x00)[\x1a\x14]\x00"
    tiff, count = re.subn(sides, lambda found: found[1] + struct.pack("<H", 9000), sound("image", 8), count=2)
    assert count == 2
    exr = sound("exr", 2)
    window = struct.pack("<4i", 0, 0, 25, 19)
    head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 60000000\n\x40\x41\x42\x81"
    return {
        "a.png": png,
        "a.jpg": bytes(jpeg),
        "a.bmp": bytes(bmp),
        "a.tif": tiff,
        "half.exr": replaced(exr, window, struct.pack("<4i", 0, 0, 8999, 8999)),
        "huge.exr": replaced(exr, window, struct.pack("<4i", 0, 0, 2**30, 2**30)),
        "long.hdr": head + b"\1\1\1\xff" * 4,
        "huge.hdr": head.replace(b"-Y 1 +X 60000000", b"-Y 60000 +X 60000"),
    }


def video_bombs():
    """A GIF and an AVI of 60000 x 60000; an MP4 of two thousand million samples."""
    names = [ending for ending, _ in FILES.KINDS["video"].make()]
    gif = bytearray(sound("video", names.index(".gif")))
    gif[6:10] = struct.pack("<HH", 60000, 60000)
    avi = bytearray(sound("video", names.index(".avi")))
    strf = avi.index(b"strf") + 8
    avi[strf + 4 : strf + 12] = struct.pack("<ii", 60000, 60000)
    mp4 = bytearray(sound("video", 0))
    struct.pack_into(">II", mp4, mp4.index(b"stsz") + 8, 1, LONG)
    struct.pack_into(">III", mp4, mp4.index(b"stts") + 8, 1, LONG, 1)
    return {"a.gif": bytes(gif), "a.avi": bytes(avi), "a.mp4": bytes(mp4)}


def other_bombs():
    """Counts of corners and triangles; brackets in brackets."""
    ply = "ply\nformat binary_little_endian 1.0\nelement vertex 2000000000\nproperty float x\nproperty float y\n"
    ply += "property float z\nelement face 1\nproperty list uint int vertex_indices\nend_header\n"
    return {
        "a.ply": ply.encode() + bytes(100),
        "a.stl": b"binary".ljust(80) + struct.pack("<I", 2**32 - 1) + bytes(100),
        "a.obj": b"v 0 0 0\n" * 3 + b"f 1 2 2000000000\n",
        "a.body.json": b"[" * 100_000,
        "a.look.json": b'{"a":' * 20_000,
        "a.toml": b"a = " + b"[" * 100_000,
    }


def kind_of(name: str) -> str:
    """Return what reads a file."""
    ending = name.rpartition(".")[2]
    if ending in FILES.KINDS:
        return ending
    kinds = {"mesh": ("ply", "stl", "obj"), "table": ("json", "toml"), "video": ("gif", "avi", "mp4")}
    return next((kind for kind, endings in kinds.items() if ending in endings), "image")


def peak(reset: bool = False) -> float:
    """Return the most memory since the last reset [byte]."""
    if reset:
        Path("/proc/self/clear_refs").write_text("5")
    lines = Path("/proc/self/status").read_text().splitlines()
    return 1024 * float(next(line.split()[1] for line in lines if line.startswith("VmHWM")))


def read(kind: str, path: Path) -> str:
    """Read a file; return the error."""
    try:
        FILES.KINDS[kind].read(path)
    except (ValueError, OSError) as error:
        return str(error)
    return ""


def main(folder: Path) -> None:
    """Read every bomb; print a line of JSON each."""
    for kind in FILES.KINDS:  # what is loaded once costs nothing more
        ending, data = FILES.KINDS[kind].make()[0]
        (folder / f"sound{ending}").write_bytes(data)
        read(kind, folder / f"sound{ending}")
    resource.setrlimit(resource.RLIMIT_AS, (8 << 30,) * 2)
    makers = (vdb_bombs, nvdb_bombs, npz_bombs, vti_bombs, picture_bombs, video_bombs, other_bombs)
    for name, data in (item for make in makers for item in make().items()):
        path = folder / name
        path.write_bytes(data)
        before, begin = peak(reset=True), time.process_time()
        error = read(kind_of(name), path)
        cost = {"seconds": time.process_time() - begin, "bytes": peak() - before, "size": len(data)}
        print(json.dumps({"name": name, "error": error, **cost}), flush=True)


if __name__ == "__main__":
    spec = importlib.util.spec_from_file_location("fuzz_files", EXAMPLES / "fuzz_files.py")
    FILES = sys.modules["fuzz_files"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(FILES)
    main(Path(sys.argv[1]))
