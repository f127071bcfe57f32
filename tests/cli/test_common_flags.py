"""What all commands take does the same in all of them."""

import json
import re
from dataclasses import replace
from functools import partial

import pytest
from tiny import BARE, flame, footage, quick, run

from warpfluid import __version__
from warpfluid.cli import app
from warpfluid.commands import demo
from warpfluid.options import OutputOptions

SILENT = ()  # commands whose result is a file alone
OUTS = {"render": "a.png", "compare": "sheet.png"}
COMMANDS = [name for name in app if not name.startswith("-")]


@pytest.fixture(scope="module")
def ready(tmp_path_factory):
    """A folder with footage, a run of three frames, and the arguments with which each command succeeds there."""
    folder = tmp_path_factory.mktemp("ready")
    views = [footage(folder / name, make=partial(flame, width=40, height=40)) for name in ("front", "side")]
    flags = quick("--front", views[0], "--side", views[1], *BARE)
    assert run("reconstruct", *flags, "-o", folder / "fire", "-q") == 0
    fire = str(folder / "fire")
    return folder, {
        "demo": [],
        "inspect": [*flags[:4], "--no-picture"],
        "reconstruct": [*flags, "--frames", "1"],
        "preview": [fire, "--html", str(folder / "fire.html")],
        "simulate": [fire, *BARE, "--frames", "1-2"],
        "presets": [],
        "render": [fire, "--resolution", "16x16", "--frames", "1", "--overwrite"],
        "compare": [fire, fire, "--frames", "1"],
        "export": [fire],
        "flow": [*flags[:4], "--frames", "1-2", "--flow", "tvl1"],
        "doctor": [],
        "completion": ["bash"],
    }


@pytest.fixture
def perform(ready, tmp_path, monkeypatch, capfd):
    """Return a function that runs a command to its end and returns what it has printed."""
    _, arguments = ready
    make = demo.make_settings

    def small(*given, **named):
        whole = make(*given, **named)
        method = replace(whole.reconstruct, iterations=1, angles=12)
        footage = replace(whole.input, frames="1", resolution="16")
        return replace(whole, input=footage, reconstruct=method, output=OutputOptions(report=False))

    def do(command: str, *more: str) -> tuple[str, str]:
        monkeypatch.chdir(tmp_path)
        if command == "demo":
            monkeypatch.setattr(demo, "make_settings", small)
        names = {name for argument in app[command].assemble_argument_collection() for name in argument.names}
        out = ["-o", str(tmp_path / OUTS.get(command, "out"))] if "-o" in names else []
        capfd.readouterr()
        device = [] if "--device" in arguments[command] else ["--device", "cpu"]
        assert run(command, *arguments[command], *out, *device, *more) == 0
        return capfd.readouterr()

    return do


@pytest.mark.parametrize("command", COMMANDS)
def test_json_is_all_that_is_printed(perform, command):
    """One object on stdout; with --quiet nothing on stderr."""
    printed = perform(command, "--json", "-q")
    assert isinstance(json.loads(printed.out), dict)
    assert printed.err == ""


@pytest.mark.parametrize("command", COMMANDS)
def test_verbose(perform, command):
    """Versions come first, then lines with times; stdout stays as it is."""
    printed = perform(command, "--json", "-v")
    assert isinstance(json.loads(printed.out), dict)
    first, *others = printed.err.splitlines()
    assert first.startswith(f"warpfluid {__version__}, warp-lang ")
    assert all(re.match(r" *\d+\.\d\d s  ", line) for line in others)


@pytest.mark.parametrize("command", COMMANDS)
def test_quiet(perform, command):
    """The result is printed, and nothing else."""
    printed = perform(command, "--quiet")
    assert printed.err == ""
    assert bool(printed.out) == (command not in SILENT)


@pytest.mark.parametrize("command", COMMANDS)
def test_help(command, capsys):
    """It names all of them."""
    assert run(command, "--help") == 0
    text = capsys.readouterr().out
    for flag in ("--device", "--json", "--quiet", "-q", "--verbose", "-v", "WARPFLUID_DEVICE"):
        assert flag in text


def test_where_a_frame_failed(ready, tmp_path, capsys, monkeypatch):
    """With -v the place in the program follows the frame; without it one line tells."""

    def fail(*_, **__):
        raise KeyError("luck")

    monkeypatch.setattr("warpfluid.reconstruction.sequence.FrameJob._model", fail)
    flags = ready[1]["reconstruct"]
    assert run("reconstruct", *flags, "-o", tmp_path / "plain") == 1
    assert "Traceback" not in capsys.readouterr().err
    assert run("reconstruct", *flags, "-o", tmp_path / "verbose", "-v") == 1
    error = capsys.readouterr().err
    assert "Traceback" in error
    assert "KeyError: 'luck'" in error
