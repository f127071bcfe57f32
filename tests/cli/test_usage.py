"""Everything that is wrong is told at once, whatever kind of mistake it is."""

import pytest
from tiny import run

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
        (["compare", "gone", "--fps", "0", "--truth", "lost"], ["fps is 0", "gone does not exist", "lost does not exist"]),
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
