"""The command preview: what it finds, writes and says; and the scene behind it."""

import json

import numpy as np
import pytest
from tiny import BARE, pair, quick, run

from warpfluid.doctor import windows as doctor
from warpfluid.files.images import read_image
from warpfluid.files.npz import write_npz
from warpfluid.footage.origin import find_footage
from warpfluid.options import PreviewOptions
from warpfluid.preview import show
from warpfluid.preview.scene import open_scene
from warpfluid.rendering.ramps import RAMPS
from warpfluid.rendering.turntable import render_turntable


@pytest.fixture(scope="module")
def footage_run(tmp_path_factory) -> str:
    """A run of two views of two frames."""
    folder = tmp_path_factory.mktemp("footage")
    assert run("reconstruct", *quick(*pair(folder, range(11, 13)), *BARE, "-q", "-o", folder / "run")) == 0
    return str(folder / "run")


@pytest.fixture
def volumes(tmp_path) -> str:
    """Three files of another program."""
    for frame in (7, 8, 9):
        write_npz(tmp_path / f"cloud.{frame}.npz", np.full((6, 9, 4), frame, np.float32))
    return str(tmp_path / "cloud.#.npz")


def test_a_run_is_shown_as_it_was_made(footage_run):
    """Its frames, its look, and its first view; its records tell the time it took."""
    scene = open_scene(footage_run)
    assert (scene.frames, scene.look, scene.angle_deg, scene.title) == ((11, 12), "fire", 0, "run")
    facts = scene.facts()
    assert facts["made by"] == "appearance-transfer"
    assert facts["views"] == "0°, 90°"
    assert facts["time"].endswith(" s a frame")


def test_choices_count(volumes):
    """Frames, colours and camera are those that were asked for."""
    options = PreviewOptions(frames="8-9", look="jet", angle=-30, elevation=20, exposure=1)
    scene = open_scene(volumes, options)
    assert (scene.frames, scene.look, scene.middle) == ((8, 9), "jet", 9)
    assert (scene.angle_deg, scene.elevation_deg, scene.exposure) == (-30, 20, 1)


def test_the_still_picture_is_the_turntable(footage_run):
    """At the first view, or where the camera was put, as large as fits: a box of 24 x 20 fills the height."""
    scene = open_scene(footage_run)
    density = scene.volumes.density(scene.brightest())
    for choices, angle, factor in (({}, 0, 1), ({"angle": 30, "exposure": 1}, 30, 2)):
        still = open_scene(footage_run, PreviewOptions(**choices)).still((300, 160))
        assert still.shape == (160, 300, 3)
        turned = render_turntable(factor * density, [angle], "fire", lines=160)[0]
        assert turned.shape == (160, 192, 3)
        np.testing.assert_array_equal(still[:, 54:246], turned)
        assert not still[:, :54].any()
        assert not still[:, 246:].any()


def test_the_still_picture_has_the_size_that_was_asked_for(footage_run):
    """Wide or narrow, larger than eight pixels a voxel or smaller than one."""
    for width, height in ((1280, 800), (64, 400), (16, 16)):
        still = open_scene(footage_run, PreviewOptions(look="jet")).still((width, height))
        assert still.shape == (height, width, 3)
        np.testing.assert_array_equal(still[0, 0], (0, 0, 128))
        assert still[..., 1].max() > 100


def test_the_brightest_frame_stands_for_all(tmp_path):
    """Not an early one, nor one that has burnt out."""
    for frame, light in enumerate([1, 2, 3, 9, 2, 1, 1, 1], start=1):
        write_npz(tmp_path / f"a.{frame}.npz", np.full((4, 5, 4), light, np.float32))
    assert open_scene(tmp_path).brightest() == 4


def test_footage_is_found(footage_run, solid_run, tmp_path):
    """That of a run, also through a simulation of it; a box that began empty has none."""
    footage = find_footage(open_scene(footage_run).volumes.document)
    assert footage.angles_deg == (0, 90)
    assert footage.shot.frames == (11, 12)
    flags = ("--frames", "11-12", *BARE, "--device", "cpu", "-q", "-o", tmp_path / "flows")
    assert run("simulate", footage_run, *flags) == 0
    assert find_footage(open_scene(tmp_path / "flows").volumes.document).angles_deg == (0, 90)
    assert find_footage(open_scene(solid_run).volumes.document) is None


def test_lost_footage_is_told(tmp_path, capsys):
    """A run without its footage still opens."""
    flags = quick(*pair(tmp_path, range(1, 2)), *BARE, "-q", "-o", tmp_path / "run")
    assert run("reconstruct", *flags) == 0
    (tmp_path / "front").rename(tmp_path / "elsewhere")
    with pytest.raises(ValueError, match="front"):
        find_footage(open_scene(tmp_path / "run").volumes.document)


def test_a_page_is_written(volumes, tmp_path, capsys):
    """Its name goes to stdout, its size to stderr; --json tells both."""
    page = tmp_path / "page.html"
    assert run("preview", volumes, "--html", page) == 0
    printed = capsys.readouterr()
    assert printed.out == f"{page}\n"
    assert "3 frames of 6 x 9 x 4 voxels" in printed.err
    assert run("preview", volumes, "--html", page, "--json", "--frames", "8") == 0
    told = json.loads(capsys.readouterr().out)
    assert told["frames"] == [8]
    assert told["html"] == {"file": str(page), "bytes": page.stat().st_size, "voxels": [6, 9, 4], "coarser": 1.0}


def test_a_small_page_says_what_it_cost(tmp_path, capsys):
    """Coarser volumes are announced with the way out, and the page keeps to its size."""
    rng = np.random.default_rng(3)
    for frame in range(8):
        write_npz(tmp_path / f"noise.{frame}.npz", rng.random((40, 40, 40)).astype(np.float32))
    page = tmp_path / "page.html"
    assert run("preview", tmp_path, "--html", page, "--html-size", 0.3) == 0
    assert page.stat().st_size < 0.3e6
    assert "--html-size" in capsys.readouterr().err


@pytest.mark.parametrize("draws", ["nothing", "memory"])
def test_where_no_window_opens_there_is_a_still_picture(footage_run, tmp_path, monkeypatch, capsys, draws):
    """With what to do about it, and no crash."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(show, "drawing", lambda: draws)
    assert run("preview", footage_run) == 0
    printed = capsys.readouterr()
    assert printed.out == "preview.png\n"
    assert "--html" in printed.err
    assert ("libegl1" in printed.err) == (draws == "nothing")
    picture = np.rint(read_image(tmp_path / "preview.png") * 255)
    np.testing.assert_array_equal(picture, open_scene(footage_run).still((1280, 800)))


def test_without_a_library_the_screenshot_is_the_still_picture(footage_run, tmp_path, monkeypatch, capsys):
    """The file that was asked for is there all the same."""
    monkeypatch.setattr(show, "drawing", lambda: "nothing")
    assert run("preview", footage_run, "--screenshot", tmp_path / "a.png", "--json") == 0
    assert json.loads(capsys.readouterr().out)["picture"] == {"file": str(tmp_path / "a.png"), "drawn": "still"}
    np.testing.assert_array_equal(
        np.rint(read_image(tmp_path / "a.png") * 255), open_scene(footage_run).still((1280, 800))
    )


@pytest.mark.parametrize(
    ("program", "draws"),
    [
        ("import os; os.abort()", "nothing"),
        ("raise SystemExit(1)", "nothing"),
        ("print('vtkEGLRenderWindow')", "memory"),
        ("print('vtkOSOpenGLRenderWindow')", "memory"),
        ("print('vtkXOpenGLRenderWindow')", "screen"),
        ("print('vtkCocoaRenderWindow')", "screen"),
    ],
)
def test_what_can_be_drawn_on(monkeypatch, program, draws):
    """A crash is no library; a class that draws in memory is no screen."""
    monkeypatch.setattr(doctor, "DRAW", program)
    assert doctor.drawing() == draws


def test_a_hanging_library_is_none(monkeypatch):
    """A driver that never answers does not hold up the command for ever."""
    monkeypatch.setattr(doctor, "DRAW", "import time; time.sleep(60)")
    monkeypatch.setattr(doctor, "PATIENCE", 0.5)
    assert doctor.drawing() == "nothing"


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (["--html", "page.htm1"], "expected .html or .htm"),
        (["--screenshot", "a.jpg"], "expected .png"),
        (["--html", "nowhere/page.html"], "nowhere is no folder"),
        (["--frames", "8,12"], "lacks frame 12 (it has 7-9)"),
        (["--show", "volume,wind"], "there is no 'wind'"),
        (["--window", "640"], "expected WIDTHxHEIGHT"),
        (["--html-size", "0"], "html-size is 0, expected 0.2 to 2000"),
        (["--elevation", "95"], "elevation is 95"),
    ],
)
def test_what_is_refused(volumes, tmp_path, monkeypatch, capsys, flags, words):
    """One line that names the flag and the way out, and no file."""
    monkeypatch.chdir(tmp_path)
    before = sorted(tmp_path.iterdir())
    assert run("preview", volumes, *flags) == 2
    printed = capsys.readouterr()
    assert words in printed.err
    assert printed.out == ""
    assert sorted(tmp_path.iterdir()) == before


def test_looks_are_those_that_there_are(volumes, capsys):
    """Every ramp can be chosen, and nothing else."""
    for name in RAMPS:
        assert open_scene(volumes, PreviewOptions(look=name)).look == name
    assert run("preview", volumes, "--look", "mauve") == 2
    told = capsys.readouterr().err
    assert all(name in told for name in ("mauve", "--look", *RAMPS))
