"""The command line: what it refuses, in which words, and what it prints where."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
from tiny import BARE, flame, footage, pair, quick, run

from warpfluid.files.exr import write_exr
from warpfluid.files.images import write_png
from warpfluid.files.video import write_video


@pytest.fixture
def refused(tmp_path, capsys):
    """Return a function that runs reconstruct on bad input and returns its message."""

    def refuse(*arguments, out=tmp_path / "out") -> str:
        before = sorted(tmp_path.rglob("*"))
        assert run("reconstruct", *quick(*arguments), "-o", out) == 2
        printed = capsys.readouterr()
        assert printed.out == ""
        assert all(line.startswith("error: ") for line in printed.err.splitlines())
        assert "Errno" not in printed.err
        assert "Traceback" not in printed.err
        assert sorted(tmp_path.rglob("*")) == before  # nothing is left behind
        return printed.err

    return refuse


def cut(path, share=0.6):
    """Cut a file off."""
    data = path.read_bytes()
    path.write_bytes(data[: int(len(data) * share)])


def exr_footage(folder, change):
    """Write three EXR pictures, the second one changed; return the folder's name."""
    folder.mkdir()
    for frame in (1, 2, 3):
        light = flame(frame).astype(np.float32) / 255
        if frame == 2:
            light = change(light)
        write_exr(folder / f"{frame:04d}.exr", {"Y": light})
    return str(folder)


def test_missing_footage(tmp_path, refused):
    """Files, folders and patterns that are not there are named, all in one go."""
    message = refused(
        "--front", tmp_path / "gone.mp4", "--side", tmp_path / "none" / "a.####.png", "--view", f"45={tmp_path}"
    )
    assert f"view 0: {tmp_path / 'gone.mp4'} does not exist: check its name" in message
    assert "view 90: " in message
    assert f"there is no folder {tmp_path / 'none'}" in message
    assert "view 45: no image found" in message


def test_missing_frames(tmp_path, refused):
    """A hole in a sequence is named, and frames that are asked for but not there."""
    front = footage(tmp_path / "a", [1001, 1002, 1004, 1005])
    assert "lacks frame 1003: mend the sequence or leave them out with --frames" in refused("--front", front)
    assert "lacks frame 1006-1009 (it has 1001-1002,1004-1005)" in refused("--front", front, "--frames", "1005-1009")
    assert "run backwards" in refused("--front", front, "--frames", "5-1")


def test_unequal_lengths(tmp_path, refused):
    """The user chooses the frames of views of unequal length; the message holds the flag to copy."""
    front, side = footage(tmp_path / "a", range(1, 7)), footage(tmp_path / "b", range(3, 6))
    message = refused("--front", front, "--side", side)
    assert f"0={front} has 1-6, 90={side} has 3-5" in message
    assert "--frames 3-5" in message
    flags = quick("--front", front, "--side", side, "--frames", "3", *BARE)
    assert run("reconstruct", *flags, "-o", tmp_path / "x") == 0


def test_unequal_sizes(tmp_path, refused):
    """Between views, and within a view."""
    front = footage(tmp_path / "a")
    wide = footage(tmp_path / "b", make=lambda frame, angle: flame(frame, width=32))
    message = refused("--front", front, "--side", wide)
    assert "24 x 20" in message
    assert "32 x 20" in message
    assert "--resolution or --crop" in message
    write_png(tmp_path / "a" / "fire.0002.png", flame(2, width=32))
    message = refused("--front", front)
    assert "fire.0002.png is 32 x 20 pixels, but the first picture is 24 x 20" in message


def test_cut_off_files(tmp_path, refused):
    """A picture or a film that was not written whole is named, wherever it stands in the shot."""
    front = footage(tmp_path / "a")
    cut(tmp_path / "a" / "fire.0003.png")
    assert f"{tmp_path / 'a' / 'fire.0003.png'} cannot be read" in refused("--front", front)
    exr = exr_footage(tmp_path / "b", lambda light: light)
    cut(tmp_path / "b" / "0003.exr")
    assert "0003.exr cannot be read" in refused("--front", exr)
    film = tmp_path / "c.mp4"
    write_video(film, [np.repeat(flame(frame)[..., None], 3, axis=2) for frame in range(8)], 24)
    cut(film, 0.3)
    assert "c.mp4 is no video, or is cut off" in refused("--front", film)
    write_video(film, [np.repeat(flame(frame)[..., None], 3, axis=2) for frame in range(8)], 24)
    cut(film)
    assert "c.mp4 holds no video, only sound or the like; or it is cut off" in refused("--front", film)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_pixels_that_are_no_numbers(tmp_path, refused, value):
    """One bad pixel in the middle of a shot is found before the run begins."""

    def spoil(light):
        light[4, 5] = value
        return light

    message = refused("--front", exr_footage(tmp_path / "a", spoil))
    assert "0002.exr holds 1 values that are infinite or not numbers: replace them" in message


def test_nothing_to_see(tmp_path, refused):
    """Footage all black or all white says what to look at."""
    black = footage(tmp_path / "a", make=lambda frame, angle: flame() * 0)
    assert "black in every frame looked at: check the footage, --black-level" in refused("--front", black)
    white = footage(tmp_path / "b", make=lambda frame, angle: flame() * 0 + 255)
    assert "white all over: take the background off with --background" in refused("--front", white)
    thin = footage(tmp_path / "c", make=lambda frame, angle: flame(width=1) + 9)
    assert "has 1 x 20 pixels: at least 8 x 8 are needed" in refused("--front", thin)


def test_angles(tmp_path, refused):
    """Every view has an angle of its own, also modulo 180."""
    flags = pair(tmp_path)
    assert "angles 0 and 0 are the same" in refused("--view", f"0={flags[1]}", "--front", flags[3])
    assert "angles 180 and 0 are 180 degrees apart" in refused("--view", f"180={flags[3]}", *flags[:2])
    assert "angles -90 and 90 are 180 degrees apart" in refused("--view", f"-90={flags[1]}", *flags[2:])
    assert "'left=a.mp4' is not ANGLE=PATH" in refused("--view", "left=a.mp4")
    assert "there is no view: give one or more with --view ANGLE=PATH" in refused()


def test_output_that_cannot_be_written(tmp_path, refused):
    """A file in the way is named, and a place where nothing can be made."""
    flags = pair(tmp_path)
    taken = tmp_path / "taken"
    taken.write_text("mine")
    for out in (taken, taken / "below", taken / "far" / "below"):
        assert f"{taken} is a file: choose another one with -o" in refused(*flags, out=out)
    assert taken.read_text() == "mine"
    if sys.platform == "linux":
        message = refused(*flags, out="/proc/warpfluid")
        assert "/proc" in message
        assert "choose another folder with -o" in message
    assert run("reconstruct", *flags) == 2


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write anywhere")
def test_write_protected_folder(tmp_path, refused):
    """It is found before the run, not at its end."""
    flags = pair(tmp_path)
    (tmp_path / "shut").mkdir(mode=0o500)
    assert "shut is write-protected" in refused(*flags, out=tmp_path / "shut" / "run")


def test_volumes_of_others_are_safe(tmp_path, refused):
    """A folder that holds volumes but is no run is not written over."""
    flags = pair(tmp_path)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "density.0001.vdb").write_bytes(b"mine")
    assert "holds volumes of another origin" in refused(*flags)
    assert "holds volumes of another origin" in refused(*flags, "--resume")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[reconstruct]\niteratoins = 3", "[reconstruct] has no option 'iteratoins'; did you mean iterations?"),
        ("[reconstruct]\nhull-radius = 3", "did you mean hull_radius?"),
        ("[reconstruckt]\nblur = 3", "unknown 'reconstruckt'; did you mean reconstruct?"),
        ("[reconstruct]\niterations = '3'", "[reconstruct] iterations is '3', expected a whole number"),
        ("[reconstruct]\niterations = 3.5", "[reconstruct] iterations is 3.5, expected a whole number"),
        ("[reconstruct]\nblur = true", "[reconstruct] blur is True, expected a number"),
        ("[reconstruct]\nblur = nan", "[reconstruct] blur is nan, expected a number"),
        ("[reconstruct]\nmethod = 'magic'", "expected one of appearance-transfer, lsm, stochastic"),
        ("[output]\nhalf = 1", "[output] half is 1, expected true or false"),
        ("[input]\nframes = 3", "[input] frames is 3, expected text"),
        ("reconstruct = 3", "reconstruct is 3, expected a table [reconstruct]"),
        ("views = '0=a'", "views are '0=a', expected a list"),
        ("[reconstruct", "is not TOML"),
    ],
)
def test_configuration_files(tmp_path, refused, text, words):
    """Unknown names and wrong values are told with the file, the section and what was meant."""
    (tmp_path / "c.toml").write_text(text)
    message = refused("--config", tmp_path / "c.toml")
    assert words in message
    assert str(tmp_path / "c.toml") in message
    assert len(message.splitlines()) == 1


def test_no_configuration(tmp_path, refused):
    """A file that is not there is named."""
    assert "c.toml does not exist" in refused("--config", tmp_path / "c.toml")


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (["--iterations", "3.5"], "'3.5' is not a whole number"),
        (["--angles", "many"], "'many' is not a whole number"),
        (["--iterations", "-1"], "iterations is -1, expected 0 to 1000"),
        (["--blur", "x"], "--blur: 'x' is not a number"),
        (["--resolution", "0"], "--resolution '0' is not WIDTH or WIDTHxHEIGHT of 8 pixels or more"),
        (["--resolution", "256x4"], "of 8 pixels or more, such as 256 or 256x144"),
        (["--blur", "inf"], "blur is inf, expected a number"),
        (["--method", "magic"], 'Choose from: "appearance-transfer", "lsm"'),
        (["--iteration", "3"], "Did you mean --iterations?"),
        (["--iterations"], "--iterations requires an argument, N"),
        (["fire.mp4"], "there is no place for 'fire.mp4': footage follows --view ANGLE=, --front or --side"),
        (["--device", "cuda:99"], "there is no device 'cuda:99': this machine has cpu"),
        (["--device", "gpu"], "use --device auto"),
        (["--resume", "--overwrite"], "choose one of them"),
        (["--crop", "9"], "--crop '9' is not WIDTHxHEIGHT+LEFT+TOP"),
        (["--resolution", "48"], "pictures are only ever reduced"),
        (["--background", "plate.png"], "plate.png does not exist"),
    ],
)
def test_flags(tmp_path, capsys, flags, words):
    """A wrong flag is told by its name with the way out, and no folder is made."""
    assert run("reconstruct", *quick(*pair(tmp_path), *flags), "-o", tmp_path / "out") == 2
    printed = capsys.readouterr()
    assert words in printed.err
    assert all(line.startswith("error: ") for line in printed.err.splitlines())
    assert printed.out == ""
    assert not (tmp_path / "out").exists()


def test_too_much_for_the_memory(tmp_path, refused, monkeypatch):
    """A box that the machine cannot hold is refused with a size that it can."""
    monkeypatch.setattr("warpfluid.memory.machine_memory", lambda: 2.02e7)
    message = refused(*pair(tmp_path))
    assert "cpu has 0.02 GB" in message
    assert "--resolution" in message


def test_everything_is_told_at_once(tmp_path, refused):
    """Folder, device and footage are wrong: one error, a line for each."""
    (tmp_path / "out").write_text("")
    message = refused("--front", tmp_path / "gone.mp4", "--device", "cuda:99")
    for words in ("is a file", "no device", "gone.mp4 does not exist"):
        assert words in message


def test_many_damaged_frames_are_counted(tmp_path, refused):
    """A thousand bad frames do not fill the screen."""
    front = footage(tmp_path / "a", range(1, 31))
    for frame in range(2, 30):
        cut(tmp_path / "a" / f"fire.{frame:04d}.png")
    lines = refused("--front", front, "--frames", "1-29").splitlines()
    assert len(lines) <= 20
    assert lines[-1].endswith("more like these")


def test_export_of_no_run(tmp_path, capsys):
    """Neither a missing folder nor one without volumes is taken, and a lacking frame is named."""
    for folder, lacking in ((tmp_path / "gone", "does not exist"), (tmp_path, "has no volumes")):
        assert run("export", folder, "-o", tmp_path / "out") == 2
        assert f"{folder} {lacking}: name a run, or a folder" in capsys.readouterr().err
    assert run("reconstruct", *quick(*pair(tmp_path), *BARE), "-o", tmp_path / "run", "--frames", "2") == 0
    capsys.readouterr()
    assert run("export", tmp_path / "run", "-o", tmp_path / "out", "--frames", "2-4") == 2
    assert "lacks frame 3-4 (it has 2): choose with --frames" in capsys.readouterr().err
    assert run("export", tmp_path / "run", "-o", tmp_path / "run" / "run.toml") == 2
    assert "run.toml is a file: name a folder with -o" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_an_error_of_a_library_is_no_traceback(tmp_path, capsys, monkeypatch):
    """What nobody foresaw is called a fault of ours; with -v the whole of it is shown."""

    def fail(*_, **__):
        raise RuntimeError("deep inside")

    monkeypatch.setattr("warpfluid.commands.footage.open_shot", fail)
    assert run("inspect", "--front", "a.mp4") == 1
    error = capsys.readouterr().err
    assert "RuntimeError: deep inside" in error
    assert "Traceback" not in error
    assert run("inspect", "--front", "a.mp4", "-v") == 1
    assert "Traceback" in capsys.readouterr().err


def test_an_interrupted_command(monkeypatch, capsys):
    """Ctrl-C ends with 130 and no traceback."""

    def stop(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("warpfluid.commands.footage.open_shot", stop)
    assert run("inspect", "--front", "a.mp4") == 130
    assert capsys.readouterr().err == "stopped\n"


def test_inspect(tmp_path, capsys):
    """Text for people, JSON for programs, and a picture; damaged footage is refused here, too."""
    flags = pair(tmp_path)
    assert run("inspect", *flags, "--picture", tmp_path / "views.png") == 0
    text = capsys.readouterr().out
    assert "24 x 20 x 24 voxels" in text
    assert "frames  3 (1-3)" in text
    assert "3 frames, about " in text
    assert "GB of memory" in text
    assert (tmp_path / "views.png").stat().st_size > 1000
    assert run("inspect", *flags, "--no-picture", "--json") == 0
    data = json.loads(capsys.readouterr().out)
    assert data["volume_size"] == [24, 20, 24]
    assert data["options"]["angles"] == 180
    cut(tmp_path / "side" / "fire.0002.png")
    assert run("inspect", *flags) == 2
    assert "fire.0002.png" in capsys.readouterr().err


def test_flow(tmp_path, capsys):
    """A line a pair and view, or JSON; two files each; a configuration's views count."""
    flags, out = pair(tmp_path), tmp_path / "motion"
    assert run("flow", *flags, "-o", out) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split("  ")[:2] for line in lines] == [
        [f"frame {frame} to {frame + 1}", f"view {angle}"] for frame in (1, 2) for angle in (0, 90)
    ]
    stems = [f"flow.{angle}.000{frame}" for angle in (0, 90) for frame in (1, 2)]
    assert {path.name for path in out.iterdir()} == {f"{stem}.{kind}" for stem in stems for kind in ("exr", "png")}
    config = tmp_path / "mine.toml"
    views = [f"{angle}={tmp_path / name}" for angle, name in ((0, "front"), (90, "side"))]
    config.write_text(f"views = {json.dumps(views)}\n[input]\nframes = '2-3'\n")
    assert run("flow", "--config", config, "--json", "--flow", "tvl1", "-o", tmp_path / "again") == 0
    data = json.loads(capsys.readouterr().out)
    assert [(found["frame"], found["angle_deg"]) for found in data["pairs"]] == [(2, 0), (2, 90)]
    assert all(found["median"] <= found["fast"] for found in data["pairs"])


def test_flow_refuses(tmp_path, capsys):
    """One frame, a file in the way, an unknown method; nothing is left behind."""
    flags = pair(tmp_path)
    (tmp_path / "file").write_text("mine")
    for extra, words in (
        (["-o", tmp_path / "file"], "is a file: name a folder"),
        (["-o", tmp_path / "one", "--frames", "2"], "there is only one"),
        (["-o", tmp_path / "two", "--flow", "psychic"], "nltv-ncc"),
    ):
        assert run("flow", *flags, *extra) == 2
        assert words in capsys.readouterr().err
    assert not any((tmp_path / name).exists() for name in ("one", "two"))


@pytest.mark.parametrize("extra", [[], ["-q"]])
def test_json_is_all_that_stdout_carries(tmp_path, extra):
    """In a process of its own, so that what libraries print below Python counts, too."""
    command = [sys.executable, "-m", "warpfluid", "reconstruct", *quick(*pair(tmp_path), "--json", *extra)]
    done = subprocess.run([*command, "-o", tmp_path / "run"], capture_output=True, text=True, check=True)
    data = json.loads(done.stdout)
    assert [record["frame"] for record in data["frames"]] == [1, 2, 3]
    assert data["failed"] == {}
    assert (done.stderr == "") is bool(extra)
    assert "\x1b" not in done.stderr  # no bar and no colours where no terminal is


def test_one_line_results(tmp_path, capsys):
    """Without --json the result is one line, with -q nothing else is said."""
    assert run("reconstruct", *quick(*pair(tmp_path), *BARE, "-q"), "-o", tmp_path / "run") == 0
    printed = capsys.readouterr()
    assert printed.out == f"{tmp_path / 'run'}: 3 of 3 frames\n"
    assert printed.err == ""


def test_help_is_light():
    """Help loads neither Warp nor any other heavy library."""
    heavy = ("warp", "scipy", "skimage", "av", "OpenEXR", "pyvista", "numpy.random")
    code = (
        "import sys; from warpfluid import cli\n"
        "for command in ([], *([name] for name in cli.app if not name.startswith('-'))):\n"
        "    assert cli.main([*command, '--help']) == 0\n"
        f"print([name for name in {heavy} if name in sys.modules], file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr == "[]\n"
    for words in ("--view", "--iterations", "--frames", "--resume", "warpfluid doctor", "default: 8", "--emitter"):
        assert words in done.stdout


def test_a_reader_that_stops(tmp_path):
    """`warpfluid inspect | head -1` is no error."""
    flags = " ".join(pair(tmp_path))
    command = f"{sys.executable} -m warpfluid inspect {flags} --no-picture --json | head -1"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=True)
    assert done.stdout == "{\n"
    assert done.stderr == ""
