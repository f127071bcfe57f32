"""Ctrl-C after the last frame: the film and the page that lack are named, and the command that makes them."""

import pytest
from tiny import pair, quick, run

from warpfluid.outcome import exactness

SMALL = ("--size", "12x16", "--emitter", "sphere center=0,2,0 radius=1.5 density=8", "--frames", "1-2")


@pytest.mark.parametrize("stopped", ["turntable.mp4", "report.html"])
@pytest.mark.parametrize("command", ["reconstruct", "simulate"])
def test_ctrl_c_while_the_film_is_written(tmp_path, monkeypatch, capsys, command, stopped):
    """The frames are whole, and the command that is named makes the rest."""

    def stop(*_, **__):
        raise KeyboardInterrupt

    flags = quick(*pair(tmp_path), "-q") if command == "reconstruct" else [*SMALL, "-q", "--device", "cpu"]
    report = "reconstruction" if command == "reconstruct" else "simulation"
    places = {"turntable.mp4": "film.write_film", "report.html": f"of_{report}.report_{report}"}
    made = {"turntable.mp4": "report.html", "report.html": "turntable.mp4"}
    for name, place in places.items():
        monkeypatch.setattr(f"warpfluid.report.{place}", stop if name == stopped else lambda *_, **__: None)
    assert run(command, *flags, "-o", tmp_path / "out") == 130
    lacks = "turntable.mp4 and report.html" if stopped == "turntable.mp4" else made["turntable.mp4"]
    way_on = f"warpfluid {command} -o {tmp_path / 'out'} --resume"
    assert capsys.readouterr().err == f"stopped; the frames are there; to make {lacks}: {way_on}\n"
    monkeypatch.undo()
    assert run(*way_on.split()[1:], "-q") == 0
    assert all((tmp_path / "out" / name).is_file() for name in made)


def test_a_number_that_only_rounding_limits_is_no_number():
    """228 dB mean the same volume; the worst view counts."""
    assert exactness([228.1, 190]) == "exact"
    assert exactness([228.1, 61.26]) == "61.3 dB"
