"""What files are said to be."""

import json

import numpy as np
import pytest
from tiny import BARE, pair, quick, run

from warpfluid import __version__
from warpfluid.explaining import explain
from warpfluid.files.exr import write_exr
from warpfluid.files.images import write_png
from warpfluid.files.npz import write_npz_grids
from warpfluid.files.nvdb import write_nvdb
from warpfluid.files.sequences import find_sequence
from warpfluid.files.vdb import write_vdb
from warpfluid.files.video import write_video
from warpfluid.files.vti import write_vti

WRITERS = {".vdb": write_vdb, ".nvdb": write_nvdb, ".vti": write_vti, ".npz": write_npz_grids}


def grids() -> dict[str, np.ndarray]:
    """Return a density of three voxels and a wind."""
    density = np.zeros((5, 6, 7), np.float32)
    density[1, 2, 3:6] = [1, 2, 3.5]
    wind = np.zeros((5, 6, 7, 3), np.float32)
    wind[1, 2, 3] = [3, -4, 12]
    return {"density": density, "velocity": wind}


@pytest.mark.parametrize("ending", WRITERS)
def test_volumes(tmp_path, ending):
    """Grids with their sizes, places, ranges and sums, and the sequence that the file belongs to."""
    for frame in (1, 2, 5):
        path = tmp_path / f"a.{frame:04d}{ending}"
        WRITERS[ending](path, grids(), voxel_size=0.5, origin=(1.0, 2.0, 3.0))
    told = explain(path)
    density, velocity = told["grids"]
    assert (density["name"], density["type"], velocity["type"]) == ("density", "float", "vec3s")
    assert density["range"] == ([1, 3.5] if ending == ".nvdb" else [0, 3.5])
    assert density["sum"] == 6.5
    assert velocity["longest"] == 13
    assert density["voxel_size"] == 0.5
    assert density["size"] == ([1, 1, 3] if ending == ".nvdb" else [5, 6, 7])
    assert density["origin"] == ([1.5, 3, 4.5] if ending == ".nvdb" else [1, 2, 3])
    if ending in (".vdb", ".nvdb"):
        assert (density["active"], density["box"]) == (3, [[1, 2, 3], [1, 2, 5]])
    assert told["sequence"] == {"pattern": f"a.#{ending}", "frames": "1-2,5", "count": 3, "missing": "3-4"}
    json.dumps(told, allow_nan=False)


def test_warnings(tmp_path):
    """NaN, negative density, strange names, axes that nobody tells: each is said, with the way out."""
    bad = grids()
    bad["density"][0, 0, :3] = [np.nan, -np.inf, -1]
    np.savez(tmp_path / "a.npz", **bad)
    warnings = explain(tmp_path / "a.npz")["warnings"]
    assert warnings == [
        "density: 2 values are NaN or infinite: export --repair writes 0 there",
        "density: 1 values are negative: export --repair writes 0 there",
    ]
    write_nvdb(tmp_path / "b.nvdb", {"soot": grids()["density"], "heat": np.zeros((2, 2, 2))})
    assert explain(tmp_path / "b.nvdb")["warnings"] == [
        "soot: a name that Blender and Houdini give no meaning",
        "heat: it is empty",
        "there is no grid density, which programs look for: name it with export --grid NAME",
        "the file tells no up axis: y is assumed, say --source-up z if it lies on its back",
    ]
    write_vdb(tmp_path / "c.vdb", grids(), up="z")
    told = explain(tmp_path / "c.vdb")
    assert told["warnings"] == []
    assert told["grids"][0]["up"] == "z"
    assert told["grids"][0]["size"] == [5, 6, 7]


def test_pictures_and_videos(tmp_path, capsys):
    """Size, depth, range; layers of EXR files one by one."""
    picture = np.zeros((8, 12, 3), np.uint8)
    picture[2, 3] = [255, 128, 0]
    write_png(tmp_path / "a.png", picture)
    layers = {"R": np.full((8, 12), 2.0), "G": np.zeros((8, 12)), "B": np.zeros((8, 12)), "depth.Z": np.ones((8, 12))}
    write_exr(tmp_path / "a.exr", {name: layer.astype(np.float32) for name, layer in layers.items()})
    write_video(tmp_path / "a.mp4", [picture] * 5, 24.0)
    assert run("inspect", *(tmp_path / name for name in ("a.png", "a.exr", "a.mp4")), "--json") == 0
    png, exr, video = json.loads(capsys.readouterr().out)["files"]
    assert (png["kind"], png["size"], png["channels"], png["depth"]) == ("picture", [12, 8], 3, "8 bit")
    assert png["range"] == [0, 1]
    assert exr["size"] == [12, 8]
    assert {channel["name"]: channel["range"][1] for channel in exr["channels"]} == {
        "R": 2,
        "G": 0,
        "B": 0,
        "depth.Z": 1,
    }
    assert (video["size"], video["count"], video["rate"]) == ([12, 8], 5, 24)


def test_a_stage_and_a_run(tmp_path, capsys):
    """The stage names files that are gone; the run its frames, and one that is damaged."""
    assert run("reconstruct", *quick(*pair(tmp_path), *BARE), "-o", tmp_path / "run", "-q") == 0
    assert run("export", tmp_path / "run", "-o", tmp_path / "usd", "--format", "usda", "-q") == 0
    told = explain(tmp_path / "usd" / "volumes.usda")
    assert (told["layer"]["upAxis"], told["layer"]["endTimeCode"], told["files"]) == ("Y", "3", 3)
    assert told["warnings"] == []
    (tmp_path / "usd" / "density.0002.vdb").unlink()
    told = explain(tmp_path / "usd" / "volumes.usda")
    assert told["warnings"] == ["1 of 3 files that it shows are not there, as ./density.0002.vdb"]
    damaged = tmp_path / "run" / "density.0003.vdb"
    damaged.write_bytes(damaged.read_bytes()[:-20])
    told = explain(tmp_path / "run")
    assert (told["kind"], told["frames"], told["count"]) == ("run of reconstruct", "1-3", 3)
    assert told["warnings"] == ["frame 3 is damaged: the same command with --resume makes it anew"]
    capsys.readouterr()
    assert run("inspect", tmp_path / "run", tmp_path / "usd" / "volumes.usda") == 0
    lines = capsys.readouterr().out
    assert "run of reconstruct" in lines
    assert "OpenVDBAsset density" in lines


def test_an_export(tmp_path, capsys):
    """Of what it was made and how, what opens it, and which of its files are gone."""
    assert run("reconstruct", *quick(*pair(tmp_path), *BARE), "-o", tmp_path / "run", "-q") == 0
    out = tmp_path / "out"
    assert (
        run("export", tmp_path / "run", "-o", out, "--format", "blender", "--half", "--drop-below", "0.01", "-q") == 0
    )
    told = explain(out)
    assert (told["kind"], told["made_of"]) == (f"export of warpfluid {__version__}", str(tmp_path / "run"))
    assert (told["frames"], told["count"], told["warnings"]) == ("1-3", 3, [])
    assert told["layer"].items() >= {"format": "blender", "up": "z", "half": True, "drop below": 0.01}.items()
    assert told["layer"]["open_in_blender.py"] == f"opens it: blender --python {out / 'open_in_blender.py'}"
    assert told["bytes"] == sum(file.stat().st_size for file in out.glob("*.vdb"))
    assert told["grids"][0]["type"] == "float (half)"
    (out / "density.0001.vdb").unlink()
    (out / "density.0003.vdb").unlink()
    capsys.readouterr()
    assert run("inspect", out) == 0
    printed = capsys.readouterr().out
    assert "\n  format    blender\n  up        z\n" in printed
    assert "warning   frame 1,3 is not there: the same export with --resume writes it" in printed
    for content in ('{"frames": []}', "[" * 9999, '{"frames": {"a": {"file": "b"}}, "options": {}, "source": ""}'):
        (out / "export.json").write_text(content)
        assert run("inspect", out) == 1
        assert "export.json is damaged: export again with --overwrite" in capsys.readouterr().err


def test_folders(tmp_path, capsys):
    """Of volumes, of pictures, and of neither."""
    for frame in (4, 5):
        write_vdb(tmp_path / f"a.{frame:04d}.vdb", grids())
        (tmp_path / "pictures").mkdir(exist_ok=True)
        write_png(tmp_path / "pictures" / f"a.{frame:04d}.png", np.zeros((8, 12, 3), np.uint8))
    told = explain(tmp_path)
    assert (told["kind"], told["sequence"]["frames"]) == ("folder of OpenVDB", "4-5")
    told = explain(tmp_path / "pictures")
    assert (told["kind"], told["frames"], told["size"]) == ("folder of pictures, the first a picture", "4-5", [12, 8])
    write_vdb(tmp_path / "b.0001.vdb", grids())
    assert run("inspect", tmp_path) == 1
    assert "has several sequences" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.txt", b"x", ".txt is not known; known are"),
        ("a.vdb", b"", "not an OpenVDB file"),
        ("a.vdb", b"x" * 100, "not an OpenVDB file"),
        ("a.nvdb", b"x" * 100, "no NanoVDB file"),
        ("a.vti", b"x", "no VTK image data"),
        ("a.npz", b"x", "no .npz file"),
        ("a.usda", b"x", "no USD stage"),
        ("a.exr", b"x", "no OpenEXR file"),
        ("a.png", b"x", "a.png"),
        ("a.mp4", b"x", "a.mp4"),
    ],
)
def test_what_is_none(tmp_path, capsys, name, content, message):
    """One line names the file and what is wrong; others beside it are explained all the same."""
    (tmp_path / name).write_bytes(content)
    write_vdb(tmp_path / "good.vdb", grids())
    assert run("inspect", tmp_path / name, tmp_path / "good.vdb") == 1
    printed = capsys.readouterr()
    assert message in printed.err
    assert len(printed.err.splitlines()) == 1
    assert "good.vdb: OpenVDB" in printed.out


def test_files_or_footage(tmp_path, capsys):
    """Not both."""
    assert run("inspect", "a.vdb", "--front", "b.mp4") == 2
    assert "is explained as it is; footage follows --view" in capsys.readouterr().err
    assert run("inspect", tmp_path) == 1
    assert "is a folder without a run, volumes or pictures; it has nothing" in capsys.readouterr().err


def test_a_run_that_was_broken_off(tmp_path, capsys):
    """Frames, film and page that lack are told with the command that makes them, and a whole run has no warning."""
    out, views = tmp_path / "run", pair(tmp_path)
    go_on = f"warpfluid reconstruct -o {out} --resume"
    assert run("reconstruct", *quick(*views, *BARE), "-o", out, "-q") == 0
    assert explain(out)["warnings"] == []
    (out / "density.0002.vdb").unlink()
    told = explain(out)
    assert (told["frames"], told["count"]) == ("1,3", 2)
    assert told["warnings"] == [f"2 of 3 frames, not finished, without 2: {go_on}"]
    assert run(*go_on.split()[1:], "--report", "-q") == 0
    (out / "report.html").unlink()
    assert explain(out)["warnings"] == [f"report.html lacks: {go_on}"]
    assert run(*go_on.split()[1:], "--frames", "1", "--no-report", "-q") == 0
    assert explain(out)["warnings"] == []  # a part that is made again asks for no less
    (out / "density.0003.vdb").unlink()
    assert explain(out)["warnings"] == [f"2 of 3 frames, not finished, without 3: {go_on}"]


def test_an_empty_box_is_told_by_its_size(tmp_path):
    """As people write it, and as the command line takes it; frames that lack count there, too."""
    box = ("--size", "12x16", "--emitter", "sphere center=0,2,0 radius=1.5 density=8", "--frames", "1-2")
    assert run("simulate", *box, *BARE, "--device", "cpu", "-q", "-o", tmp_path / "box") == 0
    (tmp_path / "box" / "density.0002.vdb").unlink()
    told = explain(tmp_path / "box")
    assert told["made_of"] == "an empty box of 12 x 16"
    go_on = f"warpfluid simulate -o {tmp_path / 'box'} --resume"
    assert told["warnings"] == [f"1 of 2 frames, not finished, without 2: {go_on}"]


def test_texts_beside_volumes(tmp_path, capsys):
    """Settings, reports and records are told in a line each; damaged ones are refused."""
    out = tmp_path / "run"
    assert run("reconstruct", *quick(*pair(tmp_path), "--no-turntable"), "-o", out, "-q") == 0
    (tmp_path / "mine.toml").write_text("[render]\nglow = 2\n[light]\n")
    (tmp_path / "list.json").write_text("[1, 2]")
    names = [*(out / name for name in ("run.toml", "report.html", "frames.jsonl"))]
    names += [tmp_path / name for name in ("mine.toml", "list.json")]
    again = f"make it again with reconstruct --config {out / 'run.toml'} -o FOLDER"
    assert [explain(path)["kind"] for path in names] == [
        f"settings of a run of reconstruct: {again}",
        "web page, run: open it in a browser",
        "records of 3 frames, a line each: name the folder to hear more",
        "configuration, [render] [light]: give it with --config",
        "JSON, 2 entries",
    ]
    for name in ("a.toml", "a.json"):
        (tmp_path / name).write_text("[[[")
        assert run("inspect", tmp_path / name) == 1
        assert name in capsys.readouterr().err


def test_a_folder_of_clips(tmp_path, monkeypatch, capsys):
    """All clips are named; the picture that inspect left beside them is no footage, and one of others is kept."""
    monkeypatch.chdir(tmp_path)
    picture = np.zeros((16, 12, 3), np.uint8)
    picture[4:8, 4:8] = 200
    for name in ("a.mp4", "b.mp4"):
        write_video(tmp_path / name, [picture] * 3, 24.0)
    assert run("inspect", "--front", "a.mp4") == 0
    told = explain(tmp_path)
    assert (told["count"], told["files"]) == (2, ["a.mp4", "b.mp4"])
    assert f"warpfluid inspect --front {tmp_path / 'a.mp4'} looks at one" in told["kind"]
    before = (tmp_path / "views.png").read_bytes()
    assert run("inspect", "--front", "b.mp4") == 0
    assert (tmp_path / "views.png").exists()
    write_png(tmp_path / "views.png", picture)
    foreign = (tmp_path / "views.png").read_bytes()
    assert foreign != before
    capsys.readouterr()
    assert run("inspect", "--front", "b.mp4") == 0
    way_out = "name another one with --picture"
    assert f"picture not written: views.png is not of inspect; {way_out}" in capsys.readouterr().err
    assert (tmp_path / "views.png").read_bytes() == foreign
    assert explain(tmp_path)["files"] == ["a.mp4", "b.mp4", "and 1 picture"]


def test_the_picture_of_inspect_is_no_footage(tmp_path, monkeypatch):
    """A folder of pictures stays one sequence after inspect looked at it from inside."""
    front = pair(tmp_path)[1]
    monkeypatch.chdir(front)
    for _ in range(2):
        assert run("inspect", "--front", ".", "-q") == 0
    (tmp_path / "side" / "views.png").write_bytes((tmp_path / "front" / "views.png").read_bytes())
    with pytest.raises(FileNotFoundError, match=r"side holds fire\.####\.png \(3\)$"):
        find_sequence(tmp_path / "side" / "foo.####.png")
    told = explain(tmp_path / "front")
    assert (told["kind"], told["frames"]) == ("folder of pictures, the first a picture", "1-3")
