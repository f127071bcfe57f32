"""Frames by many processes: the same bits as by one, and nothing lost when it breaks."""

from itertools import pairwise

import numpy as np
import pytest
from tiny import BARE, flame, footage, numbers, pair, quick, run, volumes

from warpfluid.projector import Projector
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


def test_pieces_fade_into_each_other(tmp_path):
    """Of a thing that stands still, seen from where no camera stood, little changes where a piece begins."""
    flags = [*BARE, "--iterations", "4", "--angles", "16", "--device", "cpu", "--piece", "5"]
    for name, angle in (("--front", 0), ("--side", 1)):
        flags += [name, footage(tmp_path / str(angle), FRAMES, lambda frame, side: flame(0, side), angle)]
    jumps = {}
    for overlap in ("0", "3"):
        assert run("reconstruct", *flags, "--overlap", overlap, "-o", tmp_path / "run", "--overwrite") == 0
        made = [Run(tmp_path / "run").volume(frame) for frame in FRAMES]
        pictures = Projector([45.0], made[0].shape, device="cpu")
        seen = [pictures.project(volume) for volume in made]
        jumps[overlap] = [np.abs(b - a).sum() / b.sum() for a, b in pairwise(seen)]
    assert max(jumps["3"][1:]) < 0.5 * jumps["0"][4]


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


def rid_of(folder, frames):
    """Delete pictures of both views."""
    for name in ("front", "side"):
        for frame in frames:
            (folder / name / f"fire.{frame:04d}.png").unlink()


def test_pictures_that_went_at_the_begin(tmp_path, flags):
    """Pieces stay where they were, and a frame that cannot be made again as it was is kept."""
    how = ("--piece", "3", "--overlap", "1")
    assert run("reconstruct", *flags, *how, "-o", tmp_path / "run") == 0
    whole = volumes(tmp_path / "run")
    rid_of(tmp_path, [1])
    for _ in range(2):
        assert run("reconstruct", "-o", tmp_path / "run", "--resume", "--frames", "2-6") == 0
        assert volumes(tmp_path / "run") == whole
        assert sorted(Run(tmp_path / "run").records()) == list(FRAMES)
    Run(tmp_path / "run").volume_path(5).unlink()
    assert run("reconstruct", "-o", tmp_path / "run", "--resume", "--frames", "2-6") == 0
    assert volumes(tmp_path / "run") == whole


def test_pictures_of_made_frames_that_went(tmp_path, flags):
    """Frames that come start anew where nothing is left to carry from, and those that are there stay."""
    assert run("reconstruct", *flags, "--frames", "1-4", "-o", tmp_path / "run") == 0
    whole = volumes(tmp_path / "run")
    rid_of(tmp_path, range(1, 5))
    assert run("reconstruct", "-o", tmp_path / "run", "--resume", "--frames", "5-6") == 0
    assert volumes(tmp_path / "run").items() > whole.items()
    assert [record["before"] for record in Run(tmp_path / "run").records().values()][4:] == [None, 5]


def test_a_run_of_an_earlier_version_goes_on(tmp_path, flags):
    """Without a flag it goes on as it was made, not as today's default has it."""
    assert run("reconstruct", *flags, "--highpass", "whole", "--frames", "1-2", "-o", tmp_path / "run") == 0
    told = tmp_path / "run" / "run.toml"
    text = told.read_text().split("\n", 1)[1]  # without the checksum
    assert 'highpass = "whole"\n' in text
    told.write_text(text.replace('highpass = "whole"\n', ""))
    assert run("reconstruct", "-o", tmp_path / "run", "--resume", "--frames", "1-3") == 0
    assert run("reconstruct", *flags, "--highpass", "whole", "--frames", "1-3", "-o", tmp_path / "whole") == 0
    assert volumes(tmp_path / "run") == volumes(tmp_path / "whole")


def test_parts_that_do_not_fade_are_named(tmp_path, flags, capsys):
    """Frames of an earlier part that would fade into the one that comes are told, with the way to make them."""
    how = ("--piece", "3", "--overlap", "2")
    go_on = ("reconstruct", "-o", tmp_path / "run", "--resume")
    assert run("reconstruct", *flags, *how, "--frames", "1-3", "-o", tmp_path / "run") == 0
    assert "to make them, too" not in capsys.readouterr().err
    for _ in range(2):  # told again when nothing lacks
        assert run(*go_on, "--frames", "4-6") == 0
        told = capsys.readouterr().err
        assert "frames 2-3 are kept, but would be made otherwise" in told
        assert f"to make them, too: warpfluid reconstruct -o {tmp_path / 'run'} --resume --frames 2-3\n" in told
    assert run(*go_on, "--frames", "2-3") == 0
    assert "to make them, too" not in capsys.readouterr().err
    assert run("reconstruct", *flags, *how, "-o", tmp_path / "whole") == 0
    assert volumes(tmp_path / "run") == volumes(tmp_path / "whole")
