"""Frames that other programs have cut are put where they belong."""

import struct

import numpy as np
import pytest

from warpfluid.files.npz import write_npz_grids
from warpfluid.files.nvdb import write_nvdb
from warpfluid.files.vdb import layout, write_vdb
from warpfluid.files.vti import write_vti
from warpfluid.volumes import Lattice, open_volumes

WRITERS = {".nvdb": write_nvdb, ".vti": write_vti, ".npz": write_npz_grids}


def blob(shape=(4, 5, 6), seed=0):
    """Return random density without zeros, so that nothing of it is cut off."""
    return np.random.default_rng(seed).uniform(0.5, 1.5, shape).astype(np.float32)


@pytest.mark.parametrize("ending", WRITERS)
def test_frames_of_other_boxes_meet_on_one_lattice(tmp_path, ending):
    """Each frame is another box; the union holds all, each voxel at its place in the world."""
    places = {1: (2, 0, -3), 2: (-1, 4, 0), 7: (0, 0, 0)}
    parts = {frame: blob((4 + frame, 5, 6), frame) for frame in places}
    for frame, place in places.items():
        origin = tuple(0.5 * n + 100.25 for n in place)
        more = np.stack([parts[frame]] * 3, axis=-1)
        grids = {"density": parts[frame], "velocity": more}
        WRITERS[ending](tmp_path / f"smoke.{frame:04d}{ending}", grids, voxel_size=0.5, origin=origin)
    sequence = open_volumes(tmp_path)
    low = np.min(list(places.values()), axis=0)
    high = np.max([np.add(place, parts[frame].shape) for frame, place in places.items()], axis=0)
    assert sequence.lattice.shape == tuple(high - low)
    np.testing.assert_allclose(sequence.lattice.origin, 100.25 + 0.5 * low, atol=1e-9)
    for frame, place in places.items():
        expected = np.zeros(high - low, np.float32)
        first = np.subtract(place, low)
        expected[tuple(slice(a, a + n) for a, n in zip(first, parts[frame].shape, strict=True))] = parts[frame]
        found = sequence.read(frame)
        np.testing.assert_array_equal(found.grids["density"], expected)
        np.testing.assert_array_equal(found.grids["velocity"], np.stack([expected] * 3, axis=-1))
        scaled = expected.transpose(0, 2, 1) * np.float32(sequence.scale)
        np.testing.assert_array_equal(sequence.density(frame), scaled)


def test_the_brightest_ray_of_the_first_is_white(tmp_path):
    """Whatever the unit and the box; velocity comes out in voxels a second with axes (x, z, y)."""
    speed = np.broadcast_to(np.float32([1, 2, 3]), (4, 5, 6, 3))
    write_nvdb(tmp_path / "a.1.nvdb", {"density": 1e-3 * blob(), "velocity": speed}, voxel_size=0.1)
    sequence = open_volumes(tmp_path)
    assert sequence.density(1).sum(axis=1).max() == pytest.approx(255, rel=1e-5)
    found = sequence.fields(1, ["velocity", "density"])
    np.testing.assert_allclose(found["velocity"][0, 0, 0], [10, 30, 20], rtol=1e-5)
    assert found["density"].shape == (4, 6, 5)


def test_other_voxel_sizes_are_refused(tmp_path):
    """The file and both sizes are named."""
    write_nvdb(tmp_path / "a.1.nvdb", {"density": blob()}, voxel_size=0.1)
    write_nvdb(tmp_path / "a.2.nvdb", {"density": blob()}, voxel_size=0.2)
    with pytest.raises(ValueError, match=r"a\.2\.nvdb: its voxels are 0\.2 and not 0\.1, as in a\.1\.nvdb; resample"):
        open_volumes(tmp_path)


def test_voxels_between_others_are_refused(tmp_path):
    """A third of a voxel aside is no place on the lattice; what 32 bits get wrong is."""
    write_nvdb(tmp_path / "a.1.nvdb", {"density": blob()}, voxel_size=0.1)
    write_nvdb(tmp_path / "a.2.nvdb", {"density": blob()}, voxel_size=0.1, origin=(0.7003, 0, 0))
    assert open_volumes(tmp_path).lattice.shape == (11, 5, 6)
    write_nvdb(tmp_path / "a.2.nvdb", {"density": blob()}, voxel_size=0.1, origin=(0.033, 0, 0))
    with pytest.raises(ValueError, match=r"a\.2\.nvdb: its voxels lie between those of a\.1\.nvdb"):
        open_volumes(tmp_path)


def test_frames_spread_over_the_world_are_refused(tmp_path):
    """Before memory is asked for."""
    write_nvdb(tmp_path / "a.1.nvdb", {"density": blob()})
    write_nvdb(tmp_path / "a.2.nvdb", {"density": blob()}, origin=(0.0, 3e5, 4e5))
    with pytest.raises(ValueError, match="are spread over 4 x 300005 x 400006 voxels"):
        open_volumes(tmp_path)


def test_what_is_small_in_a_wide_space_is_read(tmp_path):
    """A ball of others that flies by; four grids of it."""
    balls = {"density": blob((24, 24, 24)), "a": blob((24, 24, 24)), "b": blob((24, 24, 24)), "c": blob((24, 24, 24))}
    write_nvdb(tmp_path / "a.1.nvdb", balls)
    write_nvdb(tmp_path / "a.2.nvdb", balls, origin=(700, 700, 700))
    assert open_volumes(tmp_path, unchecked=True).lattice.shape == (724, 724, 724)


def test_the_box_of_ours_is_left_to_memory(tmp_path, monkeypatch):
    """Whatever the number of grids and however little they hold."""
    path = tmp_path / "a.vdb"
    write_vdb(path, {"density": np.zeros((3, 5, 7)), "velocity": np.zeros((3, 5, 7, 3))})
    wide = bytearray(path.read_bytes().replace(struct.pack("<3i", 3, 5, 7), struct.pack("<3i", 900, 900, 900)))
    wide[layout.ID] = layout.content_id(wide)
    path.write_bytes(wide)
    monkeypatch.setattr("warpfluid.volumes.sequence.check_room", lambda shape: None)
    assert open_volumes(path, unchecked=True).lattice.shape == (900, 900, 900)


def test_empty_frames_take_no_place(tmp_path):
    """A frame of nothing is a volume of zeros; a sequence of nothing has one voxel."""
    write_nvdb(tmp_path / "a.1.nvdb", {"density": blob()}, origin=(3, 4, 5))
    write_nvdb(tmp_path / "a.2.nvdb", {"density": np.zeros((9, 9, 9))}, origin=(-100, 0, 0))
    sequence = open_volumes(tmp_path)
    assert sequence.lattice == Lattice(1.0, (3.0, 4.0, 5.0), (4, 5, 6))
    assert not sequence.density(2).any()
    (tmp_path / "a.1.nvdb").unlink()
    assert open_volumes(tmp_path).density(2).shape == (1, 1, 1)


@pytest.mark.parametrize("ending", [".nvdb", ".vti"])
def test_z_up_of_others(tmp_path, ending):
    """What lies on its back in the file stands, vectors with it, and at the same place in the world."""
    density, origin = blob(), (1.0, 2.0, 3.0)
    velocity = np.random.default_rng(3).normal(size=(*density.shape, 3)).astype(np.float32)
    grids = {"density": density, "velocity": velocity}
    WRITERS[ending](tmp_path / f"a{ending}", grids, voxel_size=0.25, origin=origin, up="z")
    sequence = open_volumes(tmp_path / f"a{ending}", up="z")
    file = sequence.read(1)
    np.testing.assert_array_equal(file.grids["density"], density)
    np.testing.assert_array_equal(file.grids["velocity"], velocity)
    np.testing.assert_allclose(file.origin, origin, atol=1e-9)
    lying = open_volumes(tmp_path / f"a{ending}").read(1)
    assert lying.grids["density"].shape == (4, 6, 5)
    np.testing.assert_array_equal(lying.grids["density"], density.transpose(0, 2, 1)[:, ::-1])


def test_names_of_others(tmp_path):
    """One grid of numbers is the density, and that is said; of several one is chosen."""
    write_vdb(tmp_path / "a.vdb", {"smoke": blob(), "v": np.ones((4, 5, 6, 3))})
    sequence = open_volumes(tmp_path / "a.vdb", unchecked=True)
    assert sequence.messages == ("a.vdb has no grid density: its grid smoke is taken for it",)
    assert list(sequence.read(1).grids) == ["density", "v"]
    write_vdb(tmp_path / "b.vdb", {"smoke": blob(), "heat": 2 * blob()})
    with pytest.raises(ValueError, match=r"b\.vdb: there is no grid density, it has smoke, heat: choose one with"):
        open_volumes(tmp_path / "b.vdb")
    sequence = open_volumes(tmp_path / "b.vdb", grid="heat", unchecked=True)
    np.testing.assert_array_equal(sequence.read(1, ["density"]).grids["density"], 2 * blob())
    with pytest.raises(ValueError, match="no grid flame, it has smoke, heat"):
        open_volumes(tmp_path / "b.vdb", grid="flame")


@pytest.mark.parametrize("value", [np.nan, np.inf, -1.0])
def test_values_that_are_no_density(tmp_path, value):
    """The file, how many, and the way out are said."""
    density = blob()
    density[1, 2, 3:5] = value
    write_vti(tmp_path / "a.vti", {"density": density})
    with pytest.raises(
        ValueError, match=r"a\.vti: the density is negative or not finite in 2 of 120 voxels; warpfluid exp"
    ):
        open_volumes(tmp_path / "a.vti")
