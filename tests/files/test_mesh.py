"""Meshes from files: every format, what exporters do to them, and what is refused."""

import struct
import subprocess
import sys

import numpy as np
import pytest

from warpfluid.files.mesh import read_mesh
from warpfluid.simulation.triangles import box_surface, check_closed, weigh

VERTICES, TRIANGLES = box_surface((2.0, 3.0, 4.0))


def write_obj(path):
    lines = [f"v {x} {y} {z}" for x, y, z in VERTICES] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in TRIANGLES]
    path.write_text("\n".join(["# a comment", "o box", *lines]) + "\n")


def write_ply(path):
    head = f"ply\nformat ascii 1.0\nelement vertex {len(VERTICES)}\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz")
    head += f"element face {len(TRIANGLES)}\nproperty list uchar int vertex_indices\nend_header\n"
    rows = [" ".join(map(str, row)) for row in VERTICES] + [" ".join(map(str, (3, *row))) for row in TRIANGLES]
    path.write_text(head + "\n".join(rows) + "\n")


def write_stl(path):
    triangles = [struct.pack("<12fH", 0, 0, 0, *VERTICES[row].ravel(), 0) for row in TRIANGLES]
    path.write_bytes(b"".ljust(80) + struct.pack("<I", len(triangles)) + b"".join(triangles))


WRITERS = {".obj": write_obj, ".ply": write_ply, ".stl": write_stl}


@pytest.mark.parametrize("ending", [*WRITERS, ".STL"])
def test_reads_a_closed_box(ending, tmp_path):
    """Repeated corners are joined, so that it is closed, and it holds its volume."""
    path = tmp_path / f"box{ending}"
    WRITERS[ending.lower()](path)
    vertices, triangles = read_mesh(path)
    assert (vertices.dtype, triangles.dtype) == (np.float32, np.int32)
    assert (vertices.shape, triangles.shape) == ((8, 3), (12, 3))
    check_closed(vertices, triangles)
    assert weigh(vertices, triangles).volume == pytest.approx(24)


def test_cuts_quads_and_joins_seams(tmp_path):
    """As a modeller exports a box, with texture coordinates that split its corners."""
    sides = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    lines = [f"v {x} {y} {z}" for x, y, z in VERTICES] + ["vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"]
    lines += ["f " + " ".join(f"{v}/{i + 1}" for i, v in enumerate(side)) for side in sides]
    (tmp_path / "box.obj").write_text("\n".join(lines) + "\n")
    vertices, triangles = read_mesh(tmp_path / "box.obj")
    check_closed(vertices, triangles)
    assert weigh(vertices, triangles).volume == pytest.approx(24)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("empty.obj", "", "is empty"),
        ("words.obj", "hello\n", "no mesh"),
        ("points.obj", "v 0 0 0\nv 1 0 0\n", "no triangles"),
        ("nan.obj", "v 0 0 0\nv nan 0 0\nv 1 1 0\nf 1 2 3\n", "finite"),
        ("beyond.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 9\n", "no mesh"),
        ("sliver.obj", "v 0 0 0\nv 1 0 0\nv 0 0 0\nf 1 2 3\n", "no triangles"),
        ("words.ply", "garbage\n", "no mesh"),
        ("words.stl", "solid x\nfacet broken\n", "no mesh"),
        ("car.fbx", "x", "ends in '.fbx'"),
    ],
)
def test_refuses_what_is_no_mesh(name, content, words, tmp_path, capfd):
    """In one sentence that names the file; the library prints nothing."""
    (tmp_path / name).write_text(content)
    with pytest.raises(ValueError, match=words) as caught:
        read_mesh(tmp_path / name)
    assert name in str(caught.value)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("share", [0.3, 0.7, 0.99])
def test_refuses_what_is_cut_off(share, tmp_path):
    """Or it would have holes that nobody made."""
    write_stl(tmp_path / "box.stl")
    whole = (tmp_path / "box.stl").read_bytes()
    (tmp_path / "box.stl").write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(ValueError, match=r"box\.stl"):
        read_mesh(tmp_path / "box.stl")


@pytest.mark.parametrize("after", [b"\0", b"\r\n", b"made by somebody" * 20])
def test_reads_stl_with_bytes_behind_it(after, tmp_path):
    """Some programs leave them; every triangle is there."""
    write_stl(tmp_path / "box.stl")
    with (tmp_path / "box.stl").open("ab") as file:
        file.write(after)
    assert weigh(*read_mesh(tmp_path / "box.stl")).volume == pytest.approx(24)


L_SHAPE = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)]
COMB = [(0, 0), (5, 0), (5, 3), (4, 3), (4, 1), (3, 1), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)]


def area(vertices, triangles):
    """Return the sum of all triangles' areas."""
    a, b, c = vertices[triangles].astype(np.float64).transpose(1, 0, 2)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


@pytest.mark.parametrize(("outline", "size", "around"), [(L_SHAPE, 4, 10), (COMB, 11, 24)])
@pytest.mark.parametrize("turn", range(12))
def test_faces_that_turn_back_stay_within(outline, size, around, turn, tmp_path):
    """A prism over an outline that is not convex, from every corner on, in every direction; areas add up."""
    count, first = len(outline), turn % len(outline)
    flat = np.array([*outline[first:], *outline[:first]], float)
    prism = np.concatenate([np.insert(flat, 2, height, axis=1) for height in (0, 1)])
    prism = np.roll(prism, turn, axis=1) * (1 if turn % 2 else -1)
    faces = [range(count - 1, -1, -1), range(count, 2 * count)]
    faces += [(k, (k + 1) % count, (k + 1) % count + count, k + count) for k in range(count)]
    lines = [f"v {x} {y} {z}" for x, y, z in prism] + ["vt 0 0"]
    lines += [
        "f " + " ".join(f"{corner - 2 * count if turn % 3 else corner + 1}/1" for corner in face) for face in faces
    ]
    (tmp_path / "prism.obj").write_text("\n".join(lines) + "\n")
    vertices, triangles = read_mesh(tmp_path / "prism.obj")
    check_closed(vertices, triangles)
    assert abs(weigh(vertices, triangles).volume) == pytest.approx(size)
    assert area(vertices, triangles) == pytest.approx(2 * size + around)
    assert len(triangles) == 2 * (count - 2) + 2 * count


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian"])
@pytest.mark.parametrize("word", ["vertex_indices", "vertex_index"])
def test_faces_of_ply_stay_within(kind, word, tmp_path):
    """As of .obj files, as text and in bytes; alone, and beside triangles in text."""
    head = f"ply\nformat {kind} 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n"
    places = np.insert(np.roll(L_SHAPE, 2, axis=0).astype("<f4"), 2, 0, axis=1)
    more = [(0, 1, 2)] if kind == "ascii" else []
    head += f"element face {2 + len(more)}\nproperty list uchar int {word}\nend_header\n"
    faces = [range(6), range(5, -1, -1), *more]
    if kind == "ascii":
        body = "\n".join(" ".join(map(str, row)) for row in [*places, *((len(face), *face) for face in faces)]).encode()
    else:
        body = places.tobytes() + b"".join(struct.pack("<B6i", 6, *face) for face in faces)
    (tmp_path / "l.ply").write_bytes(head.encode() + body)
    a, b, c = places[:3]
    extra = np.linalg.norm(np.cross(b - a, c - a)) / 2 if more else 0
    assert area(*read_mesh(tmp_path / "l.ply")) == pytest.approx(8 + extra)


def test_missing_file_is_an_os_error(tmp_path):
    """It has the file's name."""
    with pytest.raises(FileNotFoundError, match="car"):
        read_mesh(tmp_path / "car.obj")


def test_needs_no_graphics_library(tmp_path):
    """Nothing of OpenGL is loaded, so that it works on a farm's bare machines."""
    write_obj(tmp_path / "box.obj")
    program = f"""
import sys
from warpfluid.files.mesh import read_mesh
read_mesh({str(tmp_path / "box.obj")!r})
print(any("OpenGL" in name for name in sys.modules))
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.split() == ["False"]


@pytest.mark.parametrize("first", [1, -10])
def test_many_corners_objects_and_materials(tmp_path, first):
    """A prism over a pentagon, in two objects, its corners counted from the front or from the back."""
    turns = np.arange(5) * 2 * np.pi / 5
    lines = ["mtllib ../../not-there.mtl", "o one", "usemtl a"]
    lines += [f"v {np.cos(turn)} {y} {-np.sin(turn)}" for y in (0, 1) for turn in turns]
    sides = [(k, (k + 1) % 5, (k + 1) % 5 + 5, k + 5) for k in range(5)]
    for number, face in enumerate([range(4, -1, -1), range(5, 10), *sides]):
        lines += ["o two", "usemtl b"] if number == 1 else []
        lines.append("f " + " ".join(str(corner + first) for corner in face))
    (tmp_path / "prism.obj").write_text("\n".join(lines) + "\n")
    vertices, triangles = read_mesh(tmp_path / "prism.obj")
    check_closed(vertices, triangles)
    assert (len(vertices), len(triangles)) == (10, 16)
    assert weigh(vertices, triangles).volume == pytest.approx(2.5 * np.sin(2 * np.pi / 5))


def test_text_that_is_cut_off(tmp_path):
    """An STL as text ends in a word; without it triangles are missing."""
    text = (
        "solid box\n" + "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    )
    (tmp_path / "a.stl").write_text(text + "endsolid box\n")
    assert len(read_mesh(tmp_path / "a.stl")[1]) == 1
    (tmp_path / "a.stl").write_text(text)
    with pytest.raises(ValueError, match=r"a\.stl is no mesh, or damaged"):
        read_mesh(tmp_path / "a.stl")
