"""Volumes survive the trip through a .npz file, and damaged files end in an error."""

import contextlib
import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from warpfluid.files.npz import read_npz, write_npz

CHECK = settings(max_examples=60, deadline=None, derandomize=True)


@CHECK
@given(
    density=arrays(np.float32, array_shapes(min_dims=3, max_dims=3, max_side=9), elements=st.floats(-9, 9, width=32)),
    frame=st.integers(-(2**31), 2**31),
    note=st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=9),
)
def test_round_trip(tmp_path_factory, density, frame, note):
    """The volume and the facts about it come back exactly, with their types."""
    path = tmp_path_factory.mktemp("npz") / "a.npz"
    facts = {"voxel_size": 0.1, "frame": frame, "note": note, "loop": True, "file": "x"}
    write_npz(path, density, **facts)
    volume, found = read_npz(path)
    assert np.array_equal(volume, density)
    assert volume.dtype == np.float32
    assert found == facts
    assert type(found["frame"]) is int


def test_numpy_reads_it(tmp_path):
    """NumPy itself opens the file without pickle, and the same data make the same bytes."""
    volume = np.arange(24, dtype=np.float64).reshape(2, 3, 4)
    for name in ("a.npz", "b.npz"):
        write_npz(tmp_path / name, volume.T, frame=7)
    with np.load(tmp_path / "a.npz", allow_pickle=False) as file:
        assert file["density"].dtype == np.float32
        assert np.array_equal(file["density"], volume.T)
        assert file["frame"] == 7
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_files_of_others(tmp_path, save):
    """A leading axis of one is taken off; arrays beside the volume are left out of the facts."""
    volume = np.random.default_rng(0).random((1, 4, 5, 6))
    save(tmp_path / "a.npz", density=volume, cameras=np.zeros((2, 3)), frame=3)
    found, facts = read_npz(tmp_path / "a.npz")
    assert np.array_equal(found, volume[0].astype(np.float32))
    assert facts == {"frame": 3}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"volume": np.zeros((2, 2, 2))}, "no key 'density', only volume"),
        ({"density": np.zeros((2, 2))}, r"shape \(2, 2\)"),
        ({"density": np.zeros((2, 3, 4, 5))}, "shape"),
        ({"density": np.zeros((2, 2, 2), complex)}, "complex"),
        ({"density": np.full((2, 2, 2), None)}, "no .npz file of plain arrays"),
    ],
)
def test_wrong_content_is_named(tmp_path, content, message):
    """A file without a volume, or with pickled objects, is refused by name."""
    np.savez(tmp_path / "a.npz", **content)
    with pytest.raises(ValueError, match=r"a\.npz: .*" + message):
        read_npz(tmp_path / "a.npz")


def test_wrong_arguments_are_named(tmp_path):
    """A wrong argument ends in an error and leaves no file."""
    with pytest.raises(ValueError, match="density is float64 of shape"):
        write_npz(tmp_path / "a.npz", np.zeros((2, 2)))
    with pytest.raises(ValueError, match="metadata 'cameras'"):
        write_npz(tmp_path / "a.npz", np.zeros((2, 2, 2)), cameras=[1, 2])
    assert not os.listdir(tmp_path)


@CHECK
@given(data=st.data())
def test_damaged_files_end_in_an_error(tmp_path_factory, data):
    """A file that is cut short is refused; with other bytes it is refused or read, and nothing else."""
    path = tmp_path_factory.mktemp("damage") / "a.npz"
    write_npz(path, np.arange(600.0).reshape(5, 10, 12), frame=1)
    whole = path.read_bytes()
    path.write_bytes(whole[: data.draw(st.integers(0, len(whole) - 1))])
    with pytest.raises(ValueError, match=r"a\.npz: this is no \.npz file"):
        read_npz(path)
    damaged = bytearray(whole)
    for place in data.draw(st.lists(st.integers(0, len(whole) - 1), min_size=1, max_size=3)):
        damaged[place] = data.draw(st.integers(0, 255))
    path.write_bytes(damaged)
    with contextlib.suppress(ValueError):
        read_npz(path)
    with pytest.raises(FileNotFoundError):
        read_npz(path.with_name("none.npz"))
