"""Which pictures are made."""

from pathlib import Path

import pytest

from warpfluid.rendering.output import Target
from warpfluid.rendering.shots import check_target, make_shots
from warpfluid.volumes import VolumeSequence

VOLUMES = VolumeSequence(name="fire", files={frame: Path(f"fire.{frame}.vdb") for frame in (1001, 1002, 1004)})


def told(*arguments):
    return [(shot.number, shot.frame, shot.turned) for shot in make_shots(VOLUMES, *arguments)]


def test_a_picture_a_frame():
    assert told(None, None) == [(1001, 1001, 0), (1002, 1002, 0), (1004, 1004, 0)]
    assert told("1002-1004x2", None) == [(1002, 1002, 0), (1004, 1004, 0)]


def test_a_turn_of_one_frame():
    assert told("1004", 4) == [(1004, 1004, 0), (1005, 1004, 0.25), (1006, 1004, 0.5), (1007, 1004, 0.75)]


def test_a_short_sequence_plays_again_and_a_long_one_turns_on():
    assert [shot[1] for shot in told(None, 5)] == [1001, 1002, 1004, 1001, 1002]
    assert [shot[2] for shot in told(None, 2)] == [0, 0.5, 1.0]


def test_missing_frames_are_named():
    with pytest.raises(ValueError, match=r"frames 1003 are not there; fire has 1001-1002,1004"):
        told("1001-1004", None)


def test_what_is_there_is_not_replaced_unasked(tmp_path):
    target, shots = Target(path=tmp_path / "a.####.png"), make_shots(VOLUMES, None, None)
    check_target(target, shots, resume=False, overwrite=False)
    (tmp_path / "a.1002.png").touch()
    for words in ({"resume": True, "overwrite": False}, {"resume": False, "overwrite": True}):
        check_target(target, shots, **words)
    with pytest.raises(ValueError, match=r"a\.1002\.png is there already: use --overwrite, or another -o, or --resume"):
        check_target(target, shots, resume=False, overwrite=False)
