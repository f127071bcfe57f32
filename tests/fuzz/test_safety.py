"""Files cannot run code, names cannot become tags, and nothing is written outside the folder that was named."""

import ast
import os
import pickle
import zipfile
from html.parser import HTMLParser
from pathlib import Path

import av
import numpy as np
import pytest
from tiny import METHOD_FLAGS, flame, run

import warpfluid
from warpfluid.files.footage import open_footage
from warpfluid.files.images import read_image, write_png
from warpfluid.files.npz import read_npz, read_npz_grids
from warpfluid.files.vdb import write_vdb
from warpfluid.volumes import file_facts

PACKAGE = Path(warpfluid.__file__).parent
MODULES = {path.relative_to(PACKAGE).as_posix(): ast.parse(path.read_text("utf-8")) for path in PACKAGE.rglob("*.py")}
CLUSTER = ("cluster/",)  # workers are our own processes, or a cluster that the user trusts: docs/farm.md says so


def calls(tree: ast.AST) -> list[tuple[str, ast.Call]]:
    """Return every call with the name that is called."""
    return [(ast.unparse(node.func), node) for node in ast.walk(tree) if isinstance(node, ast.Call)]


def imports(tree: ast.AST) -> set[str]:
    """Return the modules that are imported anywhere in a module."""
    plain = [alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names]
    return {*plain, *(node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom))}


@pytest.mark.parametrize("module", MODULES)
def test_nothing_runs_what_it_reads(module):
    """No eval, no shell, no pickled files, no server."""
    for name, call in calls(MODULES[module]):
        words = {word.arg: ast.unparse(word.value) for word in call.keywords}
        assert name not in ("eval", "exec", "os.system", "os.popen", "__import__"), name
        assert not name.startswith("subprocess.") or "shell" not in words
        assert name != "np.load" or words["allow_pickle"] == "False"
        assert not name.endswith("read_array") or words["allow_pickle"] == "False"
    if not module.startswith(CLUSTER):
        forbidden = {"pickle", "marshal", "shelve", "dill", "http.server", "socketserver", "yaml"}
        assert not imports(MODULES[module]) & forbidden


class Trap:
    """Writes a file when it is unpickled."""

    def __reduce__(self):
        return Path.touch, (Path("sprung"),)


def test_pickled_arrays_are_refused(tmp_path, monkeypatch):
    """An array of objects is no volume, and is not opened to find out."""
    monkeypatch.chdir(tmp_path)
    np.savez(tmp_path / "a.npz", density=np.array([Trap()], object))
    with zipfile.ZipFile(tmp_path / "b.npz", "w") as archive:
        archive.writestr("density.npy", pickle.dumps(Trap()))
    for name in ("a.npz", "b.npz"):
        for read in (read_npz, read_npz_grids, file_facts):
            with pytest.raises(ValueError, match=name):
                read(tmp_path / name)
    assert not Path("sprung").exists()


def test_pictures_open_no_other_program(tmp_path, monkeypatch):
    """PostScript under the name of a picture is no picture: Pillow would start Ghostscript."""
    (tmp_path / "gs").write_text(f"#!/bin/sh\ntouch {tmp_path}/sprung\n")
    (tmp_path / "gs").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    for name in ("a.png", "a.tif", "a.jpg"):
        (tmp_path / name).write_bytes(b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 20 20\n%%EndComments\nshowpage\n")
        with pytest.raises(ValueError, match=name):
            read_image(tmp_path / name)
    assert not (tmp_path / "sprung").exists()


def clip(path: Path) -> bytes:
    """Write a video of two frames."""
    with av.open(f"file:{path}", "w", format="mp4") as container:
        stream = container.add_stream("libx264", rate=24)
        stream.width, stream.height, stream.pix_fmt = 24, 20, "yuv420p"
        for frame in (0, 1):
            pixels = np.stack([flame(frame)] * 3, axis=-1)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(pixels).reformat(format="yuv420p")))
        container.mux(stream.encode(None))
    return path.read_bytes()


@pytest.mark.parametrize(
    "text",
    [
        "ffconcat version 1.0\nfile secret.mp4\n",
        "#EXTM3U\n#EXT-X-TARGETDURATION:10\n#EXTINF:10,\nsecret.mp4\n#EXT-X-ENDLIST\n",
        "v=0\no=- 0 0 IN IP4 127.0.0.1\ns=x\nc=IN IP4 127.0.0.1\nt=0 0\nm=video 5004 RTP/AVP 96\n",
    ],
)
def test_videos_open_no_other_file(tmp_path, text):
    """A list of files or addresses under the name of a video is no video."""
    clip(tmp_path / "secret.mp4")
    (tmp_path / "a.mp4").write_text(text)
    with pytest.raises(ValueError, match=r"a\.mp4 is no video"):
        open_footage(tmp_path / "a.mp4")


@pytest.mark.parametrize("name", ["12:30.mp4", "concat:a.mp4", "http:a.mp4", "-.mp4", "pipe:.mp4"])
def test_names_are_no_protocols(tmp_path, monkeypatch, name):
    """A video whose name looks like an address is a video."""
    monkeypatch.chdir(tmp_path)
    clip(Path(name))
    assert len(open_footage(name).frames) == 2


class Tags(HTMLParser):
    """Gathers the tags of a page, with their attributes."""

    def __init__(self, text: str):
        super().__init__()
        self.found: list[tuple[str, tuple[str, ...]]] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, tuple(sorted(name for name, _ in attrs))))


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Two runs with reports and pages: of footage with plain names, and with names that are markup."""
    made = {}
    for kind, names in (("plain", ("plain", "front")), ("odd", ("<script>alert(1)<", "script>\"on\nload=x'&amp;"))):
        folder = tmp_path_factory.mktemp("footage").joinpath(*names)
        folder.mkdir(parents=True)
        for frame in (1, 2):
            write_png(folder / f"{frame:04d}.png", flame(frame))
        out = folder.parents[1] / ("out" if kind == "plain" else "<img src=x onerror=alert(1)>")
        flags = ("--front", folder, "--no-turntable", *METHOD_FLAGS)
        assert run("reconstruct", *flags, "-o", out) == 0
        assert run("preview", out, "--html", out / "page.html", "--quiet") == 0
        made[kind] = out
    return made


@pytest.mark.parametrize("page", ["report.html", "page.html"])
def test_names_are_no_markup(runs, page):
    """Both pages have the same tags and attributes, whatever clips and folders are called."""
    plain, odd = (Tags((runs[kind] / page).read_text("utf-8")).found for kind in ("plain", "odd"))
    assert {"html", "body", "style"} <= {tag for tag, _ in plain}
    assert sorted(set(odd)) == sorted(set(plain)) or set(odd) - set(plain) == {("span", ("title",))}
    assert [tag for tag, _ in odd].count("script") == [tag for tag, _ in plain].count("script")


def everything(folder: Path) -> set[Path]:
    """Return all files and folders in a folder."""
    return set(folder.rglob("*"))


@pytest.mark.parametrize("form", ["vdb", "nvdb", "vti", "usda", "blender", "npz"])
@pytest.mark.parametrize("grid", ["../../escaped", "/tmp/escaped", "..\\escaped", "a/b"])
def test_exports_stay_in_their_folder(tmp_path, form, grid):
    """Whatever grids are called, files are written in the folder of -o only, and archives hold no paths."""
    source = tmp_path / "in" / "deep"
    source.mkdir(parents=True)
    density = np.zeros((4, 5, 6), np.float32)
    density[1:3, 1:3, 1:3] = 1
    write_vdb(source / "a.0001.vdb", {"density": density, grid: density})
    before = everything(tmp_path)
    code = run("export", source, "--format", form, "-o", tmp_path / "out", "--quiet")
    assert code == (1 if form == "npz" else 0)
    assert all(tmp_path / "out" in (path, *path.parents) for path in everything(tmp_path) - before)
    for path in (tmp_path / "out").glob("*.npz"):
        with zipfile.ZipFile(path) as archive:
            assert all(Path(name).name == name for name in archive.namelist())


def test_runs_stay_in_their_folder(tmp_path, monkeypatch):
    """Footage that is named by way of other folders leaves nothing there."""
    (tmp_path / "work" / "here").mkdir(parents=True)
    (tmp_path / "clips" / "front.0001").mkdir(parents=True)
    write_png(tmp_path / "clips" / "front.0001" / "a..0001.png", flame())
    monkeypatch.chdir(tmp_path / "work" / "here")
    before = everything(tmp_path)
    flags = ("--no-turntable", *METHOD_FLAGS, "-o", "out")
    assert run("reconstruct", "--view", "0=../../clips/front.0001/a..####.png", *flags) == 0
    new = everything(tmp_path) - before
    assert new
    assert all(Path.cwd() / "out" in (path, *path.parents) for path in new)
