"""Every command that makes something takes a configuration file, whose other tables it leaves alone."""

import pytest
from tiny import run

FILE = """
views = ["0=front.mp4"]
source = "smoke"

[machine]
device = "cpu"

[input]
frames = "3-5"

[reconstruct]
blur = 2.0

[simulate]
swirl = 3.0

[output]
look = "gray"

[render]
glow = 0.5

[camera]
angle = "1:0;9:30"

[light]
ambient = 0.5

[preview]
exposure = 1.5

[compare]
fps = 12.0

[export]
half = true
"""
CALLS = {
    "reconstruct": (
        "warpfluid.commands.reconstruct.reconstruct",
        ["-o", "out"],
        {"blur": 2.0, "frames": "3-5", "look": "gray"},
    ),
    "inspect": ("warpfluid.commands.footage.inspect", [], {"blur": 2.0, "frames": "3-5"}),
    "flow": ("warpfluid.commands.footage.flow", ["-o", "out"], {"frames": "3-5"}),
    "render": (
        "warpfluid.commands.render.render",
        ["fire", "-o", "a.mp4"],
        {"glow": 0.5, "angle": "1:0;9:30", "ambient": 0.5},
    ),
    "preview": ("warpfluid.preview.show.preview", ["fire"], {"exposure": 1.5}),
    "compare": ("warpfluid.commands.compare.compare", ["a", "b"], {"fps": 12.0}),
    "export": ("warpfluid.commands.export.export", ["fire", "-o", "out"], {"half": True}),
}
FLAGS = {"blur": "3", "glow": "0.25", "exposure": "-1", "fps": "25", "half": None, "frames": "7"}


@pytest.fixture
def called(tmp_path, monkeypatch):
    """Return a function that says what a command hands on: options by name, and what most commands take."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "shot.toml").write_text(FILE)

    def call(command: str, *more: str) -> tuple[dict, object]:
        found = []
        target, arguments, _ = CALLS[command]
        monkeypatch.setattr(target, lambda *given, **named: found.extend([*given, *named.values()]) or 0)
        assert run(command, *arguments, "--config", "shot.toml", *more) == 0
        common = next(part for part in found if hasattr(part, "quiet"))
        parts = [part for part in found if hasattr(part, "__dataclass_fields__") and part is not common]
        parts += [inner for part in parts for inner in vars(part).values() if hasattr(inner, "__dataclass_fields__")]
        return {name: value for part in parts for name, value in vars(part).items()}, common

    return call


@pytest.mark.parametrize("command", CALLS)
def test_its_own_tables_count(called, command):
    """And the device of all."""
    options, common = called(command)
    assert {name: options[name] for name in CALLS[command][2]} == CALLS[command][2]
    assert common.device == "cpu"


@pytest.mark.parametrize("command", CALLS)
def test_flags_count_on_top(called, command, monkeypatch):
    """So does the environment, below flags."""
    monkeypatch.setenv("WARPFLUID_DEVICE", "cuda:5")
    name = next(name for name in CALLS[command][2] if name in FLAGS)
    value = FLAGS[name] or False
    options, common = called(command, f"--{name}" if value else f"--no-{name}", *([value] if value else []))
    assert options[name] == (float(value) if value and name != "frames" else value)
    assert common.device == "cuda:5"
    assert called(command, "--device", "cuda:7")[1].device == "cuda:7"


def test_simulate(tmp_path, monkeypatch, capsys):
    """It takes the source of the file, and more problems than one are told at once."""
    (tmp_path / "shot.toml").write_text(FILE.replace("swirl = 3.0", "swirl = 300").replace("fps = 12.0", "fpss = 1"))
    assert run("simulate", "--config", tmp_path / "shot.toml", "-o", tmp_path / "out") == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 2
    assert "[simulate] swirl is 300, expected 0 to 10" in lines[0]
    assert "[compare] has no option 'fpss'; did you mean fps?" in lines[1]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "shot.toml").write_text(FILE)
    assert run("simulate", "--config", "shot.toml", "-o", "out") == 2
    assert "smoke does not exist" in capsys.readouterr().err
