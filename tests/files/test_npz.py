"""Volumes survive the trip through a .npz file, and damaged files end in an error."""

import contextlib
import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from warpfluid.files.npz import npz_facts, read_npz, read_npz_grids, write_npz, write_npz_grids

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


def test_grids_and_places(tmp_path):
    """Several grids, vectors among them, come back with where they lie; heads alone tell the same."""
    density = np.arange(24, dtype=np.float32).reshape(2, 3, 4)
    grids = {"density": density, "velocity": np.stack([density] * 3, axis=-1)}
    write_npz_grids(tmp_path / "a.npz", grids, voxel_size=0.5, origin=(1, -2, 3.25), frame=7)
    file = read_npz_grids(tmp_path / "a.npz")
    assert (file.voxel_size, file.origin, file.metadata["frame"]) == (0.5, (1, -2, 3.25), 7)
    for name, grid in grids.items():
        np.testing.assert_array_equal(file.grids[name], grid)
    facts = {grid.name: grid for grid in npz_facts(tmp_path / "a.npz")}
    assert {name: grid.kind for name, grid in facts.items()} == {"density": "float", "velocity": "vec3s"}
    for grid in facts.values():
        assert (grid.shift, grid.voxel_size, grid.about["placed"]) == ((1, -2, 3.25), 0.5, True)
        assert grid.box.tolist() == [[0, 0, 0], [1, 2, 3]]
    np.testing.assert_array_equal(read_npz(tmp_path / "a.npz")[0], density)


def test_grids_of_others(tmp_path):
    """Without a place they lie nowhere; what is no grid is passed over; unlike sizes are refused."""
    np.savez(tmp_path / "a.npz", smoke=np.ones((1, 4, 5, 6), np.float64), cameras=np.zeros((2, 3)), frame=3)
    file = read_npz_grids(tmp_path / "a.npz")
    assert {name: grid.shape for name, grid in file.grids.items()} == {"smoke": (4, 5, 6)}
    (facts,) = npz_facts(tmp_path / "a.npz")
    assert (facts.name, facts.about, facts.whole.tolist()) == ("smoke", {"placed": False}, [[0, 0, 0], [3, 4, 5]])
    np.savez(tmp_path / "b.npz", density=np.ones((4, 5, 6)), heat=np.ones((2, 5, 6)))
    with pytest.raises(ValueError, match=r"b\.npz: no volumes of one size, only density \(4, 5, 6\), heat"):
        read_npz_grids(tmp_path / "b.npz")
    for bad in ({"origin": [1, 2]}, {"voxel_size": -1.0}, {"voxel_size": np.nan}):
        np.savez(tmp_path / "c.npz", density=np.ones((2, 2, 2)), **bad)
        with pytest.raises(ValueError, match=r"c\.npz: (origin|voxel_size) is"):
            read_npz_grids(tmp_path / "c.npz")
    with pytest.raises(ValueError, match="must have one shape"):
        write_npz_grids(tmp_path / "d.npz", {"frame": np.ones((2, 2, 2))}, voxel_size=1, origin=(0, 0, 0))
