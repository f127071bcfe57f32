"""Everything that is wrong is told at once, whatever kind of mistake it is."""

import pytest
from tiny import flame, footage, pair, run

FRONT = ["--front", "gone.mp4"]


@pytest.fixture
def refused(tmp_path, monkeypatch, capsys):
    """Return a function that runs a command and returns the lines of its refusal."""
    monkeypatch.chdir(tmp_path)

    def refuse(*arguments: str) -> list[str]:
        assert run(*arguments) == 2
        printed = capsys.readouterr()
        assert printed.out == ""
        assert list(tmp_path.iterdir()) == []
        lines = printed.err.splitlines()
        assert all(line.startswith("error: ") for line in lines)
        return [line.removeprefix("error: ") for line in lines]

    return refuse


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (
            ["reconstruct", *FRONT, "--blur", "x", "--iterations", "3.5", "--method", "magic", "--fade=9", "-o", "out"],
            ["--blur: 'x' is not a number", "'3.5' is not a whole number", 'value "magic" for --method', "fade is 9"],
        ),
        (
            [
                "reconstruct",
                "--resolutoin=3",
                "--crop",
                "--blur",
                "-x",
                "--iteratoins",
                "3",
                "--angles",
                "1",
                "--front",
            ],
            [
                "Did you mean --resolution?",
                "--crop requires",
                "--blur requires",
                "option: -x",
                "iterations?",
                "angles is 1",
                "--front requires an argument, FOOTAGE",
            ],
        ),
        (
            ["reconstruct", *FRONT, "--blur", "99", "--device", "cuda:99", "--jobs", "none", "-o", "out"],
            ["blur is 99", "gone.mp4 does not exist", "no device 'cuda:99'", "jobs is 'none'"],
        ),
        (
            ["render", "gone", "--glow", "-4", "--resolution", "0x0", "--key-light", "up", "--zoom", "0"],
            [
                "glow is -4",
                "resolution is '0x0'",
                "key-light is 'up'",
                "zoom is 0",
                "gone does not exist",
                "no place is given",
            ],
        ),
        (
            [
                "simulate",
                "gone",
                "--size",
                "3x3",
                "--swirl",
                "99",
                "--force",
                "drag x",
                "--emitter",
                "cube",
                "-o",
                "out",
            ],
            [
                "size is '3x3'",
                "an empty box",
                "swirl is 99",
                "'x' has no value",
                "shape is 'cube'",
                "gone does not exist",
            ],
        ),
        (
            ["compare", "gone", "--fps", "0", "--truth", "lost"],
            ["fps is 0", "gone does not exist", "lost does not exist"],
        ),
        (
            ["export", "gone", "--half", "--format", "vti", "--fps", "0"],
            ["half is for", "fps is 0", "gone does not exist", "no folder is given"],
        ),
        (
            ["preview", "gone", "--show", "wind", "--window", "9", "--exposure", "nan"],
            ["there is no 'wind'", "window is '9'", "exposure is nan", "gone does not exist"],
        ),
        (["flow", "--front", "gone", "--black-level", "300", "-o", "a"], ["gone does not exist", "black-level is 300"]),
        (["inspect", *FRONT, "--white", "x", "--hull", "square"], ["'x' is not a number", 'value "square" for --hull']),
        (["render", "--gow", "3"], ["requires SOURCE, as in: warpfluid render", "Did you mean --glow?"]),
        (["reconstruct", *FRONT, "--blur", "99"], ["no folder is given", "blur is 99", "gone.mp4 does not exist"]),
        (["export", "a", "-o", "b", "--format", "Houdini"], ['"npz". Houdini reads vdb.']),
        (["completion"], ["completion requires SHELL, as in: warpfluid completion bash"]),
        (["rendr"], ['Did you mean "render"?']),
        (["export", "a", "b"], ["there is no place for 'b': write what belongs together in quotes"]),
    ],
)
def test_all_of_it(refused, arguments, expected):
    """A line for each mistake, and no more."""
    lines = refused(*arguments)
    for words in expected:
        assert sum(words in line for line in lines) == 1, (words, lines)
    assert len(lines) == len(expected)


def test_a_file_the_environment_and_flags(refused, tmp_path_factory, monkeypatch):
    """Three places, one refusal."""
    config = tmp_path_factory.mktemp("elsewhere") / "c.toml"
    config.write_text("[render]\nglow = -1\n")
    monkeypatch.setenv("WARPFLUID_JOBS", "none")
    monkeypatch.setenv("WARPFLUID_THREADS", "-2")
    lines = refused("render", "gone", "--config", str(config), "--zoom", "0", "-o", "a.png")
    for words in (
        "glow is -1",
        "WARPFLUID_JOBS: jobs",
        "WARPFLUID_THREADS is '-2'",
        "zoom is 0",
        "gone does not exist",
    ):
        assert sum(words in line for line in lines) == 1
    assert len(lines) == 5


def test_a_device_that_inspect_would_not_use(refused, tmp_path_factory, monkeypatch):
    """It is refused before a run refuses it, by a flag as by the environment."""
    front = pair(tmp_path_factory.mktemp("elsewhere"))[1]
    monkeypatch.setenv("WARPFLUID_DEVICE", "cuda:99")
    (line,) = refused("inspect", "--front", front)
    assert "there is no device 'cuda:99' (WARPFLUID_DEVICE)" in line


def test_footage_that_is_spelt_alike(refused, tmp_path_factory):
    """It is proposed; else what there is."""
    folder = tmp_path_factory.mktemp("elsewhere")
    for name in ("clip.mp4", "notes.txt"):
        (folder / name).touch()
    (line,) = refused("inspect", "--front", str(folder / "clp.mp4"))
    assert line == f"view 0: {folder / 'clp.mp4'} does not exist: did you mean clip.mp4?"
    (line,) = refused("inspect", "--front", str(folder / "something-else.mov"))
    assert line.endswith(f"does not exist: {folder} has clip.mp4")
    (line,) = refused("inspect", "--front", str(folder / "nowhere" / "a.mp4"))
    assert line.endswith(f"does not exist: there is no folder {folder / 'nowhere'}")


def test_an_angle_that_is_there_twice(refused, tmp_path_factory):
    """What follows from it is not said: neither other pairs, nor sizes and frames of what does not belong together."""
    folder = tmp_path_factory.mktemp("elsewhere")
    front, side = pair(folder)[1], footage(folder / "large", range(7, 9), lambda frame, _: flame(frame, 0, 30, 30))
    same = "angles 0 and 0 are the same: give each view its own angle, in degrees"
    assert refused("reconstruct", "--front", front, "--view", f"0={side}", "-o", "out") == [same]
    lines = refused("reconstruct", *(f"--view={angle}={front}" for angle in (0, 0, 180)), "-o", "out")
    assert lines[0] == same
    assert ["180 degrees apart" in line for line in lines] == [False, True]


def test_a_key_without_quotes(refused):
    """The shell ends the command at the semicolon, so that -o is not seen: the refusal says so."""
    (line,) = refused("simulate", "--preset", "explosion", "--wind", "2")
    assert line == "no folder is given for the run: add -o FOLDER; a ; before it needs quotes, '1:0;48:90'"
