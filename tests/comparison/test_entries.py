"""What is compared: one size, frames in common, one unit, names of their own."""

import numpy as np
import pytest
from plumes import HEIGHT, WIDTH, entries, plume, write

from warpfluid.comparison.entries import common_frames, make_entries, same_units, short_names
from warpfluid.volumes import boxed, open_volumes, squared


def test_units_of_other_programs(tmp_path):
    """Each sequence gets one factor, so that the light of some frames agrees and its course stays its own."""
    fading = write(tmp_path / "fading", lambda frame: plume(frame) / frame)
    two = entries(write(tmp_path / "faint", plume, scale=1e-4), fading)
    a, b = same_units(two, [1, 2], 1000.0)
    assert a.total([1, 2]) == pytest.approx(1000, rel=1e-5)
    assert b.total([1, 2]) == pytest.approx(1000, rel=1e-5)
    assert b.total([2]) / b.total([1]) == pytest.approx(plume(2).sum() / 2 / plume(1).sum(), rel=1e-4)
    a, b = same_units(two, [1], None)
    assert b.total([1]) == pytest.approx(two[0].total([1]), rel=1e-5)


def test_frames_in_common(tmp_path):
    """What all have, or what is asked for; what is missing is told with what each has."""
    two = entries(write(tmp_path / "a", plume, range(1, 5)), write(tmp_path / "b", plume, range(3, 8)))
    assert common_frames(two, None) == (3, 4)
    assert common_frames(two, [4]) == (4,)
    with pytest.raises(ValueError, match=r"frame 2,5 is not in all of them \(a has 1-4, b has 3-7\)"):
        common_frames(two, [5, 2, 4])
    apart = [two[0], *entries(write(tmp_path / "c", plume, [9]))]
    with pytest.raises(ValueError, match=r"no frame in common \(a has 1-4, c has 9\)"):
        common_frames(apart, None)


def test_sizes(tmp_path):
    """Unlike sizes are told as width, height and depth; a volume that changes its size is named by its file."""
    small = write(tmp_path / "small", lambda frame: plume(frame)[2:-2, 2:-2])
    with pytest.raises(ValueError, match=f"small 28 x {HEIGHT} x 28, whole {WIDTH} x {HEIGHT} x {WIDTH}"):
        entries(small, write(tmp_path / "whole", plume))
    grows = write(tmp_path / "grows", lambda frame: plume(frame)[frame:-frame, frame:-frame])
    (entry,) = entries(grows)
    with pytest.raises(ValueError, match=r"grows.0002.npz: the volume has another size than frame 1"):
        entry.volume(2)


def test_boxes_that_are_not_square(tmp_path):
    """They get room on both sides, and keep all their light."""
    volume = np.random.default_rng(0).random((5, 9, 4))
    square = squared(volume)
    np.testing.assert_array_equal(square[2:7], volume)
    assert square.shape == (9, 9, 4)
    assert square.sum() == pytest.approx(volume.sum())
    assert squared(square) is square
    assert boxed(volume, (9, 9, 3)) is None
    np.testing.assert_array_equal(boxed(volume, (6, 10, 7))[0:5, 0:9, :4], volume)
    (entry,) = make_entries([open_volumes(write(tmp_path / "slim", lambda frame: plume(frame)[4:-4]))])
    assert entry.shape == (WIDTH, WIDTH, HEIGHT)


def test_names(tmp_path):
    """As short as they can be, and each another one."""
    assert short_names([f"{tmp_path}/fire", f"{tmp_path}/smoke"]) == ["fire", "smoke"]
    assert short_names(["/a/one/run", "/a/two/run"]) == ["one/run", "two/run"]
    assert short_names(["/a/run", "/a/run"]) == ["a/run (1)", "a/run (2)"]
