"""The demo: packaged footage to volumes, film and page, in an empty folder, without any GL library."""

import sys
from dataclasses import replace
from importlib.resources import files

import pytest
from tiny import run

from warpfluid.commands import demo
from warpfluid.files.sequences import find_sequence


@pytest.fixture
def small(monkeypatch):
    """Make the demo one of three small frames and one iteration."""
    make = demo.make_settings

    def shrunk(*arguments, **options):
        whole = make(*arguments, **options)
        return replace(
            whole,
            input=replace(whole.input, frames="1-3", resolution="32"),
            reconstruct=replace(whole.reconstruct, iterations=1, angles=12),
        )

    monkeypatch.setattr(demo, "make_settings", shrunk)


def test_samples_are_whole():
    """Eight frames from the front and from the side travel with the package."""
    samples = files("warpfluid") / "samples"
    for name in ("front", "side"):
        assert list(find_sequence(f"{samples / name}.####.png")) == list(range(1, 9))


def test_demo_twice(tmp_path, monkeypatch, capsys, small):
    """It works in an empty folder and again over itself, and says what to open and what to type next."""
    monkeypatch.chdir(tmp_path)
    for name in ("pyvista", "vtk", "vtkmodules"):
        monkeypatch.setitem(sys.modules, name, None)  # an import of any fails
    for _ in range(2):
        assert run("demo") == 0
        out = capsys.readouterr().out
        for words in ("report.html", "turntable.mp4", "density.0001.vdb", "next    warpfluid inspect --front"):
            assert words in out
    names = {path.name for path in (tmp_path / "warpfluid-demo").iterdir()}
    volumes = {f"density.000{frame}.vdb" for frame in (1, 2, 3)}
    assert names == {*volumes, "run.toml", "frames.jsonl", "turntable.mp4", "report.html"}


def test_demo_spares_other_runs(tmp_path, capsys, small):
    """Only a demo is written over, never a run of the user's footage."""
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "run.toml").write_text('views = ["0=/mine/front.mp4"]')
    assert run("demo", "-o", tmp_path / "run") == 2
    assert "holds a run already" in capsys.readouterr().err


def test_demo_can_be_repeated_from_its_settings(tmp_path, capsys, small):
    """run.toml of the demo is a configuration like any other."""
    assert run("demo", "-o", tmp_path / "demo", "--json") == 0
    again = tmp_path / "again"
    flags = ["--config", tmp_path / "demo" / "run.toml", "--no-report", "--no-turntable"]
    assert run("reconstruct", *flags, "-o", again) == 0
    for path in again.glob("*.vdb"):
        assert path.read_bytes() == (tmp_path / "demo" / path.name).read_bytes()


def test_demo_spares_footage_of_the_same_name(tmp_path, capsys, small):
    """A run of the user's own front.####.png and side.####.png is not the demo."""
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "run.toml").write_text('views = ["0=/mine/front.####.png", "90=/mine/side.####.png"]')
    assert run("demo", "-o", folder) == 2
    assert "holds a run already" in capsys.readouterr().err
