"""Commands from footage to files: breaking off, going on, repeating, exporting."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from tiny import BARE, flame, footage, numbers, pair, quick, run, volumes

from warpfluid.files.exr import write_exr
from warpfluid.files.npz import read_npz
from warpfluid.reconstruction import sequence
from warpfluid.run import Run

FRAMES = range(1001, 1005)
# A shell starts what runs in its background with Ctrl-C ignored, and tests may run there.
HEEDING = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from warpfluid.cli import main
sys.exit(main())
"""


@pytest.fixture
def flags(tmp_path) -> list[str]:
    """A front and a side of four frames, and the flags of a quick run without film and report."""
    return quick(*pair(tmp_path, FRAMES), *BARE)


@pytest.fixture
def unbroken(tmp_path, flags):
    """The folder of a run that went through."""
    assert run("reconstruct", *flags, "-o", tmp_path / "unbroken") == 0
    return tmp_path / "unbroken"


def test_frames_keep_their_numbers(unbroken):
    """Volumes and records have the numbers of the footage, and nothing else lies in the folder."""
    names = [f"density.{frame}.vdb" for frame in FRAMES]
    assert sorted(path.name for path in unbroken.iterdir()) == [*names, "frames.jsonl", "run.toml"]
    assert numbers(unbroken) == list(FRAMES)
    record = Run(unbroken).records()[1002]
    assert len(record["energies"]) == 1
    assert min(record["input_psnr"]) > 20


def test_resume_makes_only_what_lacks(tmp_path, flags, unbroken, capsys):
    """Missing and damaged frames are made again, with the same bits as before, and whole ones are not touched."""
    whole = volumes(unbroken)
    (unbroken / "density.1001.vdb").unlink()
    damaged = whole["density.1003.vdb"]
    (unbroken / "density.1003.vdb").write_bytes(damaged[:300] + bytes([damaged[300] ^ 4]) + damaged[301:])
    with (unbroken / "frames.jsonl").open("a") as file:
        file.write('{"frame": 1004, "fi')
    times = {frame: (unbroken / f"density.{frame}.vdb").stat().st_mtime_ns for frame in (1002, 1004)}
    capsys.readouterr()
    assert run("reconstruct", *flags, "-o", unbroken, "--resume") == 0
    assert "2 of 4 frames are there" in capsys.readouterr().err
    assert volumes(unbroken) == whole
    assert sorted(numbers(unbroken)) == list(FRAMES)
    assert times == {frame: (unbroken / f"density.{frame}.vdb").stat().st_mtime_ns for frame in times}


def test_resume_needs_no_flags_again(tmp_path, flags, unbroken, capsys):
    """What was said when the run began counts; a flag that differs is refused by name."""
    whole = volumes(unbroken)
    (unbroken / "density.1004.vdb").unlink()
    assert run("reconstruct", "-o", unbroken, "--resume") == 0
    assert volumes(unbroken) == whole
    capsys.readouterr()
    assert run("reconstruct", "-o", unbroken, "--resume", "--blur", "2", "--front", tmp_path / "side") == 2
    message = capsys.readouterr().err
    assert "blur (was 0.4, now 2.0)" in message
    assert "views (were " in message
    assert volumes(unbroken) == whole


def test_changed_footage_is_noticed(tmp_path, flags, unbroken, capsys):
    """A picture that was replaced since may not go into the same run."""
    footage(tmp_path / "new", [1002], angle=7)
    os.replace(tmp_path / "new" / "fire.1002.png", tmp_path / "side" / "fire.1002.png")
    assert run("reconstruct", *flags, "-o", unbroken, "--resume") == 2
    assert "the footage at 90 degrees of frame 1002;" in capsys.readouterr().err


def test_footage_that_grows(tmp_path, flags, unbroken):
    """Pictures that come later do not keep a run from going on; it ends as if they had been there from the begin."""
    for angle, name in enumerate(("front", "side")):
        footage(tmp_path / "new", range(1005, 1007), angle=angle)
        for picture in (tmp_path / "new").iterdir():
            picture.rename(tmp_path / name / picture.name)
        (tmp_path / "new").rmdir()
    assert run("reconstruct", "-o", unbroken, "--resume") == 0
    assert run("reconstruct", *flags, "-o", tmp_path / "whole") == 0
    assert len(volumes(unbroken)) == 6
    assert volumes(unbroken) == volumes(tmp_path / "whole")


def test_a_frame_that_failed_and_those_after_it(tmp_path, flags, unbroken, monkeypatch, capsys):
    """When it is made at last, those that could not start from it are made again: the bits of an unbroken run."""
    whole, model = volumes(unbroken), sequence.FrameJob._model

    def fail(job, frame, *rest, **more):
        if frame == 1002:
            raise RuntimeError("out of luck")
        return model(job, frame, *rest, **more)

    with monkeypatch.context() as patch:
        patch.setattr(sequence.FrameJob, "_model", fail)
        assert run("reconstruct", *flags, "-o", tmp_path / "run") == 1
        times = {path: path.stat().st_mtime_ns for path in (tmp_path / "run").glob("*.vdb")}
        assert run("reconstruct", "-o", tmp_path / "run", "--resume") == 1  # it fails again: nothing else has changed
        assert times == {path: path.stat().st_mtime_ns for path in (tmp_path / "run").glob("*.vdb")}
        assert "made again" not in capsys.readouterr().err
    assert numbers(tmp_path / "run") == [1001, 1003, 1004]
    assert volumes(tmp_path / "run")["density.1003.vdb"] != whole["density.1003.vdb"]
    capsys.readouterr()
    assert run("reconstruct", "-o", tmp_path / "run", "--resume") == 0
    assert "frames 1003-1004 are made again" in capsys.readouterr().err
    assert volumes(tmp_path / "run") == whole
    assert numbers(tmp_path / "run") == list(FRAMES)


def test_a_run_in_parts(tmp_path, flags, unbroken):
    """Frames made in two calls are those made in one."""
    for part in ("1001,1002", "1003-1004"):
        assert run("reconstruct", *flags, "-o", tmp_path / "parts", "--resume", "--frames", part) == 0
    assert volumes(tmp_path / "parts") == volumes(unbroken)
    assert run("reconstruct", "-o", tmp_path / "again", "--config", tmp_path / "parts" / "run.toml") == 0
    assert volumes(tmp_path / "again") == volumes(unbroken)


def test_a_part_that_changes_what_lies_behind_it(tmp_path, flags, unbroken, monkeypatch):
    """Frames that were not asked for are noticed when they are."""
    model = sequence.FrameJob._model

    def fail(job, frame, *rest, **more):
        if frame == 1002:
            raise RuntimeError("out of luck")
        return model(job, frame, *rest, **more)

    with monkeypatch.context() as patch:
        patch.setattr(sequence.FrameJob, "_model", fail)
        assert run("reconstruct", *flags, "-o", tmp_path / "run") == 1
    assert numbers(tmp_path / "run") == [1001, 1003, 1004]
    assert run("reconstruct", "-o", tmp_path / "run", "--resume", "--frames", "1001-1003") == 0
    assert sorted(numbers(tmp_path / "run")) == list(FRAMES)
    assert run("reconstruct", "-o", tmp_path / "run", "--resume") == 0
    assert volumes(tmp_path / "run") == volumes(unbroken)


def test_frames_far_apart_start_anew(tmp_path, flags):
    """A frame is carried over one left out, not over two."""
    assert run("reconstruct", *flags, "-o", tmp_path / "run", "--frames", "1001,1004") == 0
    assert [record["carried"] for record in Run(tmp_path / "run").records().values()] == [False, False]
    assert run("reconstruct", *flags, "-o", tmp_path / "twos", "--frames", "1001-1004x2") == 0
    assert [record["carried"] for record in Run(tmp_path / "twos").records().values()] == [False, True]


def test_a_finished_run_repeats_itself(tmp_path, flags, unbroken, monkeypatch, capsys):
    """run.toml as a configuration gives the same bits, from any folder; flags count on top."""
    monkeypatch.chdir(tmp_path)
    relative = quick("--front", "front", "--side", "side", *BARE, "--background", "plate/fire.0001.png")
    footage(tmp_path / "plate", [1], make=lambda frame, angle: flame() * 0 + 2)
    assert run("reconstruct", *relative, "-o", "first") == 0
    monkeypatch.chdir(tmp_path / "front")
    assert run("reconstruct", "--config", tmp_path / "first" / "run.toml", "-o", tmp_path / "second") == 0
    assert volumes(tmp_path / "first") == volumes(tmp_path / "second")
    first, second = ((tmp_path / name / "run.toml").read_bytes() for name in ("first", "second"))
    assert first == second
    third = ["--config", tmp_path / "first" / "run.toml", "-o", tmp_path / "third", "--frames", "1002"]
    assert run("reconstruct", *third, "--paper", "--blur", "1") == 0
    table = Run(tmp_path / "third").settings()["reconstruct"]
    assert (table["blur"], table["preconditioner"], table["cg_steps"], table["angles"]) == (1.0, "none", 2, 180)
    assert list(volumes(tmp_path / "third")) == ["density.1002.vdb"]


def started(tmp_path, flags, frames):
    """Start a long run in a process of its own; return it once two frames are there."""
    command = [sys.executable, "-c", HEEDING, "reconstruct", *flags, "-o", tmp_path / "broken"]
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    give_up = time.monotonic() + 300  # kernels may have to be compiled
    while not (tmp_path / "broken" / f"density.{frames[1]:04d}.vdb").exists() and process.poll() is None:
        assert time.monotonic() < give_up
        time.sleep(0.002)
    return process


@pytest.mark.skipif(os.name != "posix", reason="signals of another kind")
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_a_run_that_is_broken_off(tmp_path, how):
    """Killed or interrupted in the middle, a run goes on where it was and ends with the same bits."""
    frames = range(1, 13)
    flags = [*pair(tmp_path, frames), *BARE, "--iterations", "3", "--angles", "24", "--device", "cpu"]
    process = started(tmp_path, flags, frames)
    process.send_signal(how)
    _, error = process.communicate(timeout=60)
    there = len(volumes(tmp_path / "broken"))
    assert 2 <= there < len(frames)
    if how == signal.SIGINT:
        assert process.returncode == 130
        assert f"to continue: warpfluid reconstruct -o {tmp_path / 'broken'} --resume" in error
        assert "Traceback" not in error
        assert not list((tmp_path / "broken").glob(".*"))
    assert run("reconstruct", *flags, "-o", tmp_path / "broken", "--resume") == 0
    assert run("reconstruct", *flags, "-o", tmp_path / "unbroken") == 0
    assert volumes(tmp_path / "broken") == volumes(tmp_path / "unbroken")
    assert sorted(numbers(tmp_path / "broken")) == list(frames)
    assert not list((tmp_path / "broken").glob(".*"))


def test_a_picture_that_vanishes(tmp_path, monkeypatch, capsys):
    """Gone between the check and its turn, a frame fails by name; the others are whole, film and report too."""
    flags, begin = quick(*pair(tmp_path, FRAMES)), Run.begin

    def vanish(*arguments, **options):
        (tmp_path / "side" / "fire.1002.png").unlink(missing_ok=True)
        return begin(*arguments, **options)

    monkeypatch.setattr(Run, "begin", vanish)
    assert run("reconstruct", *flags, "-o", tmp_path / "run", "--json") == 1
    printed = capsys.readouterr()
    data = json.loads(printed.out)
    assert [record["frame"] for record in data["frames"]] == [1001, 1003, 1004]
    assert list(data["failed"]) == ["frame 1002"]
    assert f"error: frame 1002: {tmp_path / 'side' / 'fire.1002.png'} does not exist" in printed.err
    assert "--resume tries again" in printed.err
    assert {"turntable.mp4", "report.html"} <= {path.name for path in (tmp_path / "run").iterdir()}
    assert "3 of 4" in (tmp_path / "run" / "report.html").read_text()
    assert all(Run(tmp_path / "run").is_whole(frame) for frame in (1001, 1003, 1004))


def test_a_library_that_gives_up(tmp_path, flags, monkeypatch, capsys):
    """Any error within a frame is that frame's; the run goes on."""
    from warpfluid.reconstruction import sequence

    whole, calls = sequence.reconstruct, []

    def fail(*arguments, **options):
        calls.append(0)
        if len(calls) == 2:
            raise RuntimeError("out of luck")
        return whole(*arguments, **options)

    monkeypatch.setattr(sequence, "reconstruct", fail)
    assert run("reconstruct", *flags, "--coherence", "none", "-o", tmp_path / "run") == 1
    assert "error: frame 1002: RuntimeError: out of luck" in capsys.readouterr().err
    assert numbers(tmp_path / "run") == [1001, 1003, 1004]


def test_the_report_names_what_it_shows(tmp_path, monkeypatch):
    """Where the page has fewer frames than the run, it says which; where it has all, nothing."""
    from warpfluid.report import of_reconstruction

    flags = [*quick(*pair(tmp_path, FRAMES)), "--no-turntable"]
    for most, told in ((3, True), (4, False)):
        monkeypatch.setattr(of_reconstruction, "SHOWN_FRAMES", most)
        assert run("reconstruct", *flags, "-o", tmp_path / f"run{most}") == 0
        page = (tmp_path / f"run{most}" / "report.html").read_text()
        assert ("\nShown: 1001, 1003, 1004<" in page) == told
        assert ("Shown:" in page) == told
        assert page.count("<h2>Frame 1") == most


def test_one_frame(tmp_path, capsys):
    """A single picture becomes a volume, with film and report."""
    front = footage(tmp_path / "a", [1])
    assert run("reconstruct", *quick("--front", front), "-o", tmp_path / "run", "--json") == 0
    data = json.loads(capsys.readouterr().out)
    assert [record["frame"] for record in data["frames"]] == [1]
    assert (tmp_path / "run" / "turntable.mp4").stat().st_size > 1000
    assert (tmp_path / "run" / "report.html").stat().st_size > 10000


@pytest.mark.parametrize("method", ["lsm", "appearance-transfer"])
def test_fire_that_begins_late(tmp_path, capsys, method):
    """Black frames are empty volumes; records, film and report manage."""
    front = footage(tmp_path / "a", range(1, 4), make=lambda frame, angle: flame(frame) * np.uint8(frame > 2))
    assert run("reconstruct", *quick("--front", front, "--method", method), "-o", tmp_path / "run", "--json") == 0
    records = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)["frames"]
    assert [record["total"] > 0 for record in records] == [False, False, True]


def test_float_footage_notes_its_white(tmp_path):
    """The brightest pixel of the frames at hand is white, and a later part of the run keeps that."""
    (tmp_path / "a").mkdir()
    for frame in (1, 2):
        write_exr(tmp_path / "a" / f"{frame:04d}.exr", {"Y": flame(frame).astype(np.float32) * frame})
    flags = quick("--front", str(tmp_path / "a"), *BARE, "-o", str(tmp_path / "run"), "--resume")
    assert run("reconstruct", *flags, "--frames", "1") == 0
    assert Run(tmp_path / "run").settings()["input"]["white"] == pytest.approx(flame(1).max())
    assert run("reconstruct", *flags, "--frames", "2") == 0
    totals = [record["total"] for record in Run(tmp_path / "run").records().values()]
    assert totals[1] > 1.5 * totals[0]


def test_choices_left_to_the_footage_are_made_for_the_shot(tmp_path):
    """One bright flame has its tone curve undone in all frames or in none, and run.toml says so."""
    bright = footage(tmp_path / "a", make=lambda frame, angle: np.where(flame(frame) > 20, 240, 0).astype(np.uint8))
    assert run("reconstruct", *quick("--front", bright, *BARE), "-o", tmp_path / "run") == 0
    table = Run(tmp_path / "run").settings()["reconstruct"]
    assert table["shoulder"] > 0
    assert {"start_noise", "noise_grain", "noise_grain_y", "angles"} <= set(table)


def test_export(tmp_path, unbroken, capsys):
    """npz holds density (x, y, z), float32, y up, with the frame's number and the voxel's size."""
    capsys.readouterr()
    assert run("export", unbroken, "-o", tmp_path / "npz", "--format", "npz", "--frames", "1002-1003", "--json") == 0
    data = json.loads(capsys.readouterr().out)
    assert data["files"] == [str(tmp_path / "npz" / f"density.{frame}.npz") for frame in (1002, 1003)]
    made = ["density.1002.npz", "density.1003.npz", "export.json"]
    assert sorted(path.name for path in (tmp_path / "npz").iterdir()) == made
    density, facts = read_npz(data["files"][0])
    assert (density.shape, density.dtype) == ((24, 20, 24), np.float32)
    assert facts == {"voxel_size": 0.01, "frame": 1002}
    np.testing.assert_array_equal(density, Run(unbroken).volume(1002).transpose(0, 2, 1))
    # the picture at angle 0 is the sum over z; row 0 of the picture is the top
    seen = density.sum(axis=2).T[::-1]
    assert np.corrcoef(seen.ravel(), flame(1002).ravel())[0, 1] > 0.95


def test_export_names_what_it_cannot_read(tmp_path, unbroken, capsys):
    """One damaged volume does not keep the others back."""
    path = unbroken / "density.1003.vdb"
    path.write_bytes(path.read_bytes()[:-40])
    capsys.readouterr()
    assert run("export", unbroken, "-o", tmp_path / "npz", "--format", "npz") == 1
    printed = capsys.readouterr()
    assert "error: frame 1003: " in printed.err
    assert len(printed.out.splitlines()) == 3


def test_up_axis_does_not_change_the_export(tmp_path, flags):
    """Volumes stored z-up for Blender are exported y-up like all others."""
    for up in ("y", "z"):
        assert run("reconstruct", *flags, "--frames", "1001", "--up", up, "-o", tmp_path / up) == 0
        assert run("export", tmp_path / up, "-o", tmp_path / f"npz-{up}", "--format", "npz") == 0
    first, second = (read_npz(tmp_path / f"npz-{up}" / "density.1001.npz")[0] for up in ("y", "z"))
    np.testing.assert_array_equal(first, second)
