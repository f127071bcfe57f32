"""The command simulate: what it writes, that it goes on bit for bit, and what it refuses."""

import json
import shlex
import tomllib
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from tiny import BARE, numbers, pair, quick, run, volumes

from warpfluid.cli import app
from warpfluid.files.bodies import read_bodies
from warpfluid.files.npz import read_npz, write_npz
from warpfluid.files.vdb import read_vdb, write_vdb
from warpfluid.options import SIMULATE_PAPER, SimulateOptions
from warpfluid.run import Run
from warpfluid.volumes import open_volumes

PLAIN = ("--no-turntable", "--no-report", "--device", "cpu", "-q")
BOX = ("--size", "12x16", "--emitter", "sphere center=0,2,0 radius=1.5 density=8 temperature=1", *PLAIN)
RISING = (*BOX, "--temperature-buoyancy", "5", "--turbulence-strength", "0.5", "--swirl", "1:0;9:3")


@pytest.fixture(scope="module")
def fire(tmp_path_factory) -> str:
    """A reconstruction of three frames, 24 x 20 x 24 voxels."""
    folder = tmp_path_factory.mktemp("fire")
    assert run("reconstruct", *quick(*pair(folder), *BARE, "-q"), "-o", folder / "run") == 0
    return str(folder / "run")


@pytest.fixture(scope="module")
def straight(tmp_path_factory) -> dict[str, bytes]:
    """The volumes of the frames 1 to 6 of a box with an emitter, made without a stop."""
    folder = tmp_path_factory.mktemp("straight") / "run"
    assert run("simulate", *RISING, "--frames", "1-6", "-o", folder) == 0
    return volumes(folder)


@pytest.fixture
def refused(tmp_path, capsys):
    """Return a function that runs simulate on bad input and returns its message."""

    def refuse(*arguments) -> str:
        before = sorted(tmp_path.rglob("*"))
        assert run("simulate", *arguments, *PLAIN, "-o", tmp_path / "out") == 2
        printed = capsys.readouterr()
        assert printed.out == ""
        assert all(line.startswith("error: ") for line in printed.err.splitlines())
        assert sorted(tmp_path.rglob("*")) == before  # nothing is left behind
        return printed.err

    return refuse


def cloud(frame=1) -> np.ndarray:
    """Return a blob that rises, shape (x, y, z), as other programs have it."""
    x, y, z = np.ogrid[:12, :16, :12]
    far = (x - 5.5) ** 2 + (z - 5.5) ** 2 + (y - 3 - frame) ** 2
    return np.where(far < 9, np.exp(-far / 5), 0).astype(np.float32)


def density(folder, frame) -> np.ndarray:
    """Return the density of a frame, shape (x, y, z)."""
    return read_vdb(folder / f"density.{frame:04d}.vdb", ["density"]).grids["density"]


def test_a_reconstruction(tmp_path, fire, capsys):
    """It is followed: grids beside the density, records with the likeness of its views, a film."""
    assert run("simulate", fire, "--turntable", "--device", "cpu", "-o", tmp_path / "out", "--json") == 0
    data = json.loads(capsys.readouterr().out)
    assert [record["frame"] for record in data["frames"]] == numbers(tmp_path / "out") == [1, 2, 3]
    assert data["failed"] == {}
    for record in data["frames"]:
        assert min(record["input_psnr"]) > 25
        assert record["total_over_source"] == pytest.approx(1, abs=0.05)
        grids = read_vdb(tmp_path / "out" / record["file"]).grids
        assert grids.keys() == {"density", "temperature", "velocity"}
        assert grids["density"].shape == (24, 20, 24)
        assert grids["velocity"].shape == (24, 20, 24, 3)
    assert (tmp_path / "out" / "turntable.mp4").stat().st_size > 1000
    assert (tmp_path / "out" / "run.toml").is_file()


def test_volumes_of_another_program(tmp_path):
    """Their frames, their size and their unit come back."""
    for frame in (11, 12):
        write_npz(tmp_path / f"a.{frame:04d}.npz", 0.01 * cloud(frame - 10))
    assert run("simulate", tmp_path / "a.####.npz", *PLAIN, "-o", tmp_path / "out") == 0
    assert numbers(tmp_path / "out") == [11, 12]
    np.testing.assert_allclose(density(tmp_path / "out", 11), 0.01 * cloud(1), rtol=1e-4, atol=1e-6)
    assert density(tmp_path / "out", 12).sum() == pytest.approx(0.01 * cloud(2).sum(), rel=0.05)
    # A run remembers what makes it as bright as footage, so that pictures and simulations of it are not black.
    assert open_volumes(tmp_path / "out").density(11).sum(axis=1).max() == pytest.approx(255, rel=1e-3)
    assert run("simulate", tmp_path / "out", *PLAIN, "-o", tmp_path / "again") == 0
    assert open_volumes(tmp_path / "again").density(11).sum(axis=1).max() == pytest.approx(255, rel=1e-3)


def test_a_grid_of_another_name(tmp_path, capsys):
    """The only one there is taken for the density, and the user is told."""
    write_vdb(tmp_path / "a.0001.vdb", {"heat": cloud(1).transpose(0, 2, 1)}, voxel_size=1.0)
    assert run("simulate", tmp_path / "a.0001.vdb", "--frames", "1", "--no-turntable", "-o", tmp_path / "out") == 0
    assert "note    a.0001.vdb has no grid density: its grid heat is taken for it" in capsys.readouterr().err


def test_an_empty_box(tmp_path, straight):
    """Density comes from the emitter alone, more in every frame, and hot smoke rises."""
    assert list(straight) == [f"density.{frame:04d}.vdb" for frame in range(1, 7)]
    for name, data in straight.items():
        (tmp_path / name).write_bytes(data)
    totals = [density(tmp_path, frame).sum() for frame in range(1, 7)]
    assert totals[0] == 0
    assert (np.diff(totals) > 0).all()
    heights = [(density(tmp_path, f) * np.arange(16)[:, None]).sum() / totals[f - 1] for f in (2, 6)]
    assert heights[1] > heights[0]
    velocity = read_vdb(tmp_path / "density.0006.vdb", ["velocity"]).grids["velocity"]
    assert velocity[..., 1].max() > np.abs(velocity[..., [0, 2]]).max() / 2  # y is up


def test_resume_after_a_stop(tmp_path, straight, monkeypatch, capsys):
    """Ctrl-C tells how to go on, and gives the bits of a straight run, whether all is said again or nothing."""
    from warpfluid.simulation.animate import Animator

    advance = Animator.advance

    def stop(self, frame, later, **more):
        if later == 4:
            raise KeyboardInterrupt
        return advance(self, frame, later, **more)

    for again in (PLAIN, (*RISING, "--frames", "1-6")):
        out = tmp_path / f"run{len(again)}"
        with monkeypatch.context() as patch:
            patch.setattr(Animator, "advance", stop)
            assert run("simulate", *RISING, "--frames", "1-6", "-o", out) == 130
        assert (
            f"stopped after 3 of 6 frames; to continue: warpfluid simulate -o {out} --resume" in capsys.readouterr().err
        )
        there = {path.name: path.stat().st_mtime_ns for path in out.glob("*.vdb")}
        assert run("simulate", *again, "-o", out, "--resume") == 0
        assert volumes(out) == straight
        assert {name: (out / name).stat().st_mtime_ns for name in there} == there
        assert numbers(out) == [1, 2, 3, 4, 5, 6]


@pytest.mark.parametrize("further", ["1-6", "4-6"])
def test_a_run_is_made_longer(tmp_path, straight, further):
    """By all its frames or by the further ones: the first keep their bits, the others are those of a straight run."""
    assert run("simulate", *RISING, "--frames", "1-3", "-o", tmp_path / "out") == 0
    first = volumes(tmp_path / "out")
    assert run("simulate", *PLAIN, "-o", tmp_path / "out", "--resume", "--frames", further) == 0
    assert {name: straight[name] for name in first} == first
    assert volumes(tmp_path / "out") == straight
    assert tomllib.loads((tmp_path / "out" / "run.toml").read_text())["simulate"]["frames"] == "1-6"


@pytest.mark.parametrize("damage", ["missing", "cut off", "a flipped bit", "no frame", "another size", "a volume"])
def test_a_damaged_run_starts_anew(tmp_path, straight, damage):
    """Without a whole checkpoint, or with a volume that is gone, all frames are made again, with the same bits."""
    out = tmp_path / "out"
    assert run("simulate", *RISING, "--frames", "1-3", "-o", out) == 0
    file = out / "checkpoint.npz"
    if damage == "missing":
        file.unlink()
    elif damage == "cut off":
        file.write_bytes(file.read_bytes()[:-200])
    elif damage == "a flipped bit":
        data = file.read_bytes()
        file.write_bytes(data[:5000] + bytes([data[5000] ^ 1]) + data[5001:])
    elif damage == "no frame":
        np.savez(file, density=np.zeros(3))
    elif damage == "another size":
        with np.load(file) as arrays:
            np.savez(tmp_path / "other.npz", **{**arrays, "density": np.zeros((12, 12, 8), np.float32)})
        (tmp_path / "other.npz").replace(file)
    else:
        (out / "density.0002.vdb").unlink()
    assert run("simulate", *PLAIN, "-o", out, "--resume", "--frames", "1-6") == 0
    assert volumes(out) == straight


def test_overwriting_forgets_everything(tmp_path):
    """Checkpoint and bodies of the earlier run go, too."""
    out = tmp_path / "out"
    assert run("simulate", *BOX, "--frames", "1-2", "--body", "box", "-o", out) == 0
    (out / "bodies.json").write_text("old")
    assert run("simulate", *BOX, "--frames", "1", "-o", out, "--overwrite") == 0
    assert {path.name for path in out.iterdir()} == {"density.0001.vdb", "checkpoint.npz", "frames.jsonl", "run.toml"}


def test_a_run_is_continued_only_as_it_was_begun(tmp_path, capsys):
    """The message names what differs, and nothing is touched."""
    assert run("simulate", *BOX, "--frames", "1-2", "-o", tmp_path / "out") == 0
    before = volumes(tmp_path / "out")
    for extra, words in (
        (["--swirl", "2"], "swirl (was 0.0, now 2.0)"),
        (["--obstacle", "sphere"], "[[obstacle]]"),
        (["--size", "16x16"], "the source (was [12, 16])"),
    ):
        assert run("simulate", *extra, *PLAIN, "-o", tmp_path / "out", "--resume") == 2
        error = capsys.readouterr().err
        assert words in error
        assert "--overwrite, or another folder with -o" in error
        assert volumes(tmp_path / "out") == before


def test_a_configuration_repeats_a_run(tmp_path, straight):
    """run.toml holds everything: the same bits; its emitter is not put in twice."""
    assert run("simulate", *RISING, "--frames", "1-6", "-o", tmp_path / "a") == 0
    config = tmp_path / "a" / "run.toml"
    assert run("simulate", "--config", config, *PLAIN, "-o", tmp_path / "b") == 0
    assert run("simulate", "--config", config, *RISING, "-o", tmp_path / "c") == 0
    assert volumes(tmp_path / "a") == volumes(tmp_path / "b") == volumes(tmp_path / "c") == straight
    assert len(tomllib.loads((tmp_path / "c" / "run.toml").read_text())["emitter"]) == 1


def test_the_source_is_never_written_over(tmp_path, fire, capsys):
    """Not even with --overwrite."""
    before = volumes(Path(fire))
    for flags in (["--overwrite"], ["--resume"]):
        assert run("simulate", fire, *PLAIN, *flags, "-o", fire) == 2
        assert "is the source itself: choose another folder with -o" in capsys.readouterr().err
    assert volumes(Path(fire)) == before


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        ([], "there is nothing to simulate: name a run or volumes, a --preset, or an --emitter"),
        (["--size", "12x16"], "there is nothing to simulate"),
        (
            ["--preset", "steam"],
            'Invalid value "steam" for --preset. Choose from: "explosion", "fire", "smoke", "splash".',
        ),
        (["--preset", "fire", "--size", "big"], "size is 'big', expected WIDTHxHEIGHT of at least 8, such as 96x144"),
        (["--preset", "fire", "--size", "4x4"], "size is '4x4', expected WIDTHxHEIGHT of at least 8"),
        (["--preset", "fire", "--swirl", "9:1;1:2"], "swirl is '9:1;1:2', expected a number, or keys such as"),
        (["--preset", "fire", "--swirl", "11"], "swirl is 11, expected 0 to 10"),
        (["--preset", "fire", "--frames", "5-1"], "run backwards"),
        (["--emitter", "ball"], "--emitter: shape is 'ball', expected one of sphere, box, cylinder, mesh"),
        (["--preset", "fire", "--obstacle", "mesh"], "--obstacle: a shape is mesh, but no file is named: add mesh=FI"),
        (["--preset", "fire", "--body", "mesh mesh=gone.obj"], "gone.obj does not exist"),
        (["--preset", "fire", "--force", "vortex strength=fast"], "--force: strength is 'fast', expected a number"),
        (["gone"], "gone does not exist: name a run, or a folder, pattern or file of .vdb"),
        (["--config", "gone.toml"], "gone.toml does not exist"),
        (["a", "--force", "drag", "strength=2"], "no place for 'strength=2': write what belongs together in quotes"),
        (["--preset", "fire", "--swirl", "1", "--blend", "x"], "blend is 'x', expected a number, or keys such as"),
        (["--preset", "fire", "--cfl", "x"], "cfl"),
        (
            ["--preset", "fire", "--pressure", "direct", "--body", "box"],
            "pressure is direct, which takes neither obstac",
        ),
        (["--preset", "splash", "--pressure", "direct"], "obstacles nor liquid: use auto or multigrid"),
        (["--preset", "fire", "--preroll", "1.5"], "'1.5' is not a whole number"),
    ],
)
def test_what_is_refused(refused, flags, words):
    """Told with the way out, before any work."""
    assert words in refused(*flags)


def test_everything_wrong_is_told_at_once(refused):
    """A line each."""
    message = refused("--preset", "fire", "--swirl", "11", "--wind", "1", "--emitter", "ball")
    for words in ("swirl is 11", "wind is '1'", "--emitter: shape is 'ball'"):
        assert words in message


def test_what_does_not_go_with_a_source(refused, fire):
    """Its size is given, its frames are what they are, and a sequence has one speed."""
    assert "size is for an empty box, and there is a source: use --resolution-scale" in refused(fire, "--size", "12x16")
    message = refused(fire, "--frames", "5-9")
    assert "frames begin with 5, which the source has not (it has 1 to 3)" in message
    assert "time-scale is not 1, but a sequence is followed frame by frame" in refused(fire, "--time-scale", "0.5")


def test_a_fluid_that_explodes(tmp_path, capsys):
    """It stops with the frame, the cause and the setting; the frames before are whole, and there is a way on."""
    out, wild = tmp_path / "out", ["--force", "uniform strength=1000", "--substeps", "1"]
    assert run("simulate", *BOX, *wild, "--frames", "1-12", "-o", out) == 1
    printed = capsys.readouterr()
    made = numbers(out)
    assert f"{len(made)} of 12 frames" in printed.out
    assert f"error: simulation: frame {len(made) + 1}: the fluid moves " in printed.err
    assert "voxels a frame; lower the strength of the forces, or raise --substeps" in printed.err
    assert 1 < len(made) < 12
    assert made == list(range(1, len(made) + 1))
    assert all(np.isfinite(density(out, frame)).all() for frame in made)


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (
            ["--emitter", "sphere velocity=0,1000,0 drive=99"],
            "lower the velocity of the emitters, or raise --max-substep",
        ),
        (["--combustion", "--emitter", "sphere fuel=99 temperature=5", "--expansion", "999"], "lower --expansion, or"),
    ],
)
def test_the_cause_is_named(tmp_path, capsys, flags, words):
    """The setting that drives the fluid most."""
    assert run("simulate", *BOX, *flags, "--frames", "1-8", "-o", tmp_path / "out") == 1
    assert words in capsys.readouterr().err


def test_a_damaged_volume_on_the_way(tmp_path, capsys):
    """The frames before it are whole; the message names the file."""
    for frame in (1, 2, 3):
        write_npz(tmp_path / f"a.{frame}.npz", cloud(frame))
    (tmp_path / "a.3.npz").write_bytes(b"no archive")
    assert run("simulate", tmp_path / "a.#.npz", *PLAIN, "-o", tmp_path / "out") == 1
    assert f"error: simulation: {tmp_path / 'a.3.npz'}: " in capsys.readouterr().err
    assert numbers(tmp_path / "out") in ([1], [1, 2])
    assert len(volumes(tmp_path / "out")) == len(numbers(tmp_path / "out"))


def test_half_the_speed_for_twice_the_frames(tmp_path):
    """Ends nearly the same way."""
    write_npz(tmp_path / "a.1.npz", cloud())
    free = [tmp_path / "a.1.npz", *PLAIN, "--temperature-buoyancy", "120", "--substeps", "2"]
    assert run("simulate", *free, "--frames", "1-5", "-o", tmp_path / "fast") == 0
    assert run("simulate", *free, "--frames", "1-9", "--time-scale", "0.5", "-o", tmp_path / "slow") == 0
    fast, slow, start = density(tmp_path / "fast", 5), density(tmp_path / "slow", 9), density(tmp_path / "fast", 1)
    moved = np.abs(fast - start).sum()
    assert moved > 0.1 * start.sum()
    assert np.abs(fast - slow).sum() < 0.25 * moved


def test_zero_strengths_change_no_bit(tmp_path):
    """What adds nothing is left out altogether."""
    zero = [
        "--turbulence-octaves",
        "5",
        "--turbulence-seed",
        "9",
        "--wind-drag",
        "9",
        "--ignition",
        "5",
        "--swirl",
        "0",
    ]
    nothing = ["--force", "vortex strength=0", "--turbulence-frequency", "3", "--swirl", "1:0;9:0"]
    for name, flags in (("a", []), ("b", zero), ("c", nothing)):
        assert run("simulate", *BOX, "--frames", "1-4", *flags, "-o", tmp_path / name) == 0
    assert volumes(tmp_path / "a") == volumes(tmp_path / "b") == volumes(tmp_path / "c")


def test_the_papers_choices(tmp_path, fire):
    """--paper sets them, flags count on top, and it runs."""
    assert run("simulate", fire, *PLAIN, "--paper", "--flow", "ilk", "-o", tmp_path / "out") == 0
    told = tomllib.loads((tmp_path / "out" / "run.toml").read_text())["simulate"]
    assert {name: told[name] for name in SIMULATE_PAPER} == SIMULATE_PAPER | {"flow": "ilk"}
    assert numbers(tmp_path / "out") == [1, 2, 3]


def test_beyond_the_source(tmp_path, fire):
    """The fluid is left to itself; only followed frames have a likeness."""
    assert run("simulate", fire, *PLAIN, "--frames", "1-5", "-o", tmp_path / "out") == 0
    records = [json.loads(line) for line in (tmp_path / "out" / "frames.jsonl").read_text().splitlines()]
    assert ["input_psnr" in record for record in records] == [True, True, True, False, False]


def test_bodies(tmp_path):
    """Where they are is written for every frame; a box without fluid under it falls."""
    falling = ["--body", "box center=2,7,0 weight=2 velocity=1,0,0"]
    assert run("simulate", *BOX, *falling, "--frames", "1-4", "-o", tmp_path / "out") == 0
    names, frames = read_bodies(tmp_path / "out" / "bodies.json")
    assert names == ["body1"]
    assert list(frames) == [1, 2, 3, 4]
    at = np.array([bodies[0]["position"] for bodies in frames.values()]) / (16 * 0.01 / 10)  # back to tenths of the box
    np.testing.assert_allclose(at[0], [2, 7, 0], atol=1e-6)
    assert (np.diff(at[:, 1]) < 0).all()
    assert at[-1, 0] == pytest.approx(2 + 3 / 24, abs=0.03)
    straight = (tmp_path / "out" / "bodies.json").read_bytes()
    assert run("simulate", *BOX, *falling, "--frames", "1-2", "-o", tmp_path / "part") == 0
    assert run("simulate", *PLAIN, "--frames", "1-4", "--resume", "-o", tmp_path / "part") == 0
    assert (tmp_path / "part" / "bodies.json").read_bytes() == straight
    assert volumes(tmp_path / "part") == volumes(tmp_path / "out")


def test_export_of_a_simulation(tmp_path):
    """As that of any other run."""
    assert run("simulate", *BOX, "--frames", "1-2", "-o", tmp_path / "out") == 0
    assert run("export", tmp_path / "out", "-o", tmp_path / "arrays", "--format", "npz", "-q") == 0
    second = sorted((tmp_path / "arrays").glob("*.npz"))[1]
    np.testing.assert_array_equal(read_npz(second)[0], density(tmp_path / "out", 2))


def test_a_simulation_of_a_simulation(tmp_path):
    """Its result is a source like any other, with the same angles."""
    assert run("simulate", *BOX, "--frames", "1-3", "-o", tmp_path / "out") == 0
    assert run("simulate", tmp_path / "out", *PLAIN, "--frames", "2-3", "-o", tmp_path / "again") == 0
    np.testing.assert_allclose(density(tmp_path / "again", 2), density(tmp_path / "out", 2), rtol=1e-5, atol=1e-3)


def test_presets(capsys):
    """For people and for programs; what is printed for people can be typed, and sets the same."""
    assert run("presets") == 0
    lines = capsys.readouterr().out.splitlines()
    assert run("presets", "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert lines[::3] == [*found] == ["explosion", "fire", "smoke", "splash"]
    for (name, tables), flags in zip(found.items(), lines[2::3], strict=True):
        bound = app.parse_args(["simulate", *shlex.split(flags)], exit_on_error=False, print_error=False)[1]
        given = {key: value for key, value in asdict(bound.arguments["method"]).items() if value is not None}
        assert SimulateOptions(**given) == SimulateOptions(**tables["simulate"]), name
        assert tables["emitter"]


@pytest.mark.parametrize("preset", ["explosion", "fire", "smoke", "splash"])
def test_a_preset_with_a_source_and_without(tmp_path, fire, preset):
    """Without a source its emitters count; with one it is an edit."""
    assert run("simulate", "--preset", preset, "--size", "12x16", "--frames", "1-3", *PLAIN, "-o", tmp_path / "a") == 0
    assert run("simulate", fire, "--preset", preset, *PLAIN, "-o", tmp_path / "b") == 0
    emitters = ["emitter" in tomllib.loads((tmp_path / name / "run.toml").read_text()) for name in "ab"]
    assert emitters == [True, False]
    assert density(tmp_path / "a", 3).sum() > 0
    assert density(tmp_path / "b", 3).sum() > 0


def test_a_preset_begins_with_the_first_frame(tmp_path):
    """A blast at frame 1001 is that of frame 1: its keys move with it, also when it goes on."""
    small = ("--preset", "explosion", "--size", "12x16", "--no-turntable", "--no-report", "--device", "cpu", "-q")
    for name, frames in (("one", "1-2"), ("late", "1001-1002")):
        assert run("simulate", *small, "--frames", frames, "-o", tmp_path / name) == 0
    assert run("simulate", *small, "--frames", "1001-1003", "-o", tmp_path / "late", "--resume") == 0
    late = Run(tmp_path / "late")
    assert sorted(late.records()) == [1001, 1002, 1003]
    assert late.volume(1001).max() > 0
    np.testing.assert_array_equal(late.volume(1002), Run(tmp_path / "one").volume(2))
    assert run("simulate", *small, "--frames", "1004", "-o", tmp_path / "late", "--resume") == 0
    assert sorted(late.records()) == [1001, 1002, 1003, 1004]


def test_a_preset_begins_with_the_frames_of_the_flag(tmp_path):
    """A file's frames do not count where a flag says others."""
    (tmp_path / "c.toml").write_text('[simulate]\nframes = "1-3"\n')
    flags = ("--config", tmp_path / "c.toml", "--preset", "explosion", "--size", "12x16", "--device", "cpu", *BARE)
    assert run("simulate", *flags, "--frames", "101-102", "-o", tmp_path / "late") == 0
    assert Run(tmp_path / "late").volume(101).max() > 0


def test_how_long_it_takes(tmp_path, capsys):
    """Each line but the first, which costs nothing, and the last says how much longer."""
    flags = ["--preset", "smoke", "--preroll", "0", "--size", "16x24", "--frames", "1-4", "--device", "cpu", *BARE]
    assert run("simulate", *flags, "-o", tmp_path / "out") == 0
    lines = [line for line in capsys.readouterr().err.splitlines() if line.startswith("frame ")]
    assert [line.endswith(" left") for line in lines] == [False, True, True, False]
