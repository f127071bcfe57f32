"""Frames by many processes: the same bits as by one, and nothing lost when it breaks."""

import pytest
from tiny import BARE, numbers, pair, quick, run, volumes

from warpfluid.run import Run

FRAMES = range(1, 7)


@pytest.fixture
def flags(tmp_path) -> list[str]:
    return quick(*pair(tmp_path, FRAMES), *BARE)


@pytest.mark.parametrize("how", [("--piece", "2", "--overlap", "1"), ("--coherence", "none"), ()])
def test_two_processes_make_the_bits_of_one(tmp_path, flags, how, capsys):
    """Whether frames build on each other, in pieces, or not at all."""
    assert run("reconstruct", *flags, *how, "-o", tmp_path / "one") == 0
    assert run("reconstruct", *flags, *how, "-o", tmp_path / "two", "--jobs", "2") == 0
    told = capsys.readouterr().err
    assert ("2 processes" in told) == bool(how)
    assert ("cut the shot with --piece" in told) == (not how)
    assert volumes(tmp_path / "two") == volumes(tmp_path / "one")
    assert sorted(numbers(tmp_path / "two")) == list(FRAMES)
    records = [Run(tmp_path / name).records() for name in ("one", "two")]
    one, two = ({frame: r | {"seconds": 0} for frame, r in part.items()} for part in records)
    assert one == two


def test_a_piece_that_goes_on(tmp_path, flags):
    """Frames that lack in the middle of a piece or at its begin are made as before, by fewer or more processes."""
    how = ("--piece", "3", "--overlap", "2")
    assert run("reconstruct", *flags, *how, "-o", tmp_path / "run") == 0
    whole = volumes(tmp_path / "run")
    assert [record["before"] for record in Run(tmp_path / "run").records().values()] == [None, 1, 2, 3, 4, 5]
    assert [record["carried"] for record in Run(tmp_path / "run").records().values()] == [False, *[True] * 5]
    for frame in (2, 4, 5):
        Run(tmp_path / "run").volume_path(frame).unlink()
    assert run("reconstruct", "-o", tmp_path / "run", "--resume", "--jobs", "auto") == 0
    assert volumes(tmp_path / "run") == whole


def test_pieces_are_part_of_the_method(tmp_path, flags, capsys):
    """A run is not continued with others."""
    assert run("reconstruct", *flags, "--piece", "3", "-o", tmp_path / "run") == 0
    assert run("reconstruct", "-o", tmp_path / "run", "--resume", "--piece", "2") == 2
    assert "piece (was 3, now 2)" in capsys.readouterr().err


def test_jobs_that_are_none(tmp_path, flags, capsys):
    assert run("reconstruct", *flags, "--jobs", "many", "-o", tmp_path / "run") == 2
    assert "jobs is 'many', expected a number of processes from 1, or auto" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()
