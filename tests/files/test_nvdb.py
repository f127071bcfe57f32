"""NanoVDB files: read back by ourselves, by Warp, and by NanoVDB's own tools where they are installed."""

import contextlib
import shutil
import subprocess

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st

from warpfluid.files.nvdb import nvdb_facts, read_nvdb, write_nvdb


def filled(shape, part=0.3, seed=1):
    """Return random values at a part of the voxels."""
    rng = np.random.default_rng(seed)
    return (rng.normal(size=shape) * (rng.random(shape[:3] + (1,) * (len(shape) - 3)) < part)).astype(np.float32)


CASES = {
    "one voxel": np.full((1, 1, 1), 2.5, np.float32),
    "odd": filled((9, 7, 11)),
    "across nodes": filled((140, 3, 260), 0.05),
    "across the root": np.pad(filled((3, 2, 2), 1.0), [(4094, 0), (0, 0), (0, 0)]),
    "vectors": filled((9, 12, 5, 3)),
    "empty": np.zeros((5, 6, 7), np.float32),
}


def placed(file, shape, origin, size):
    """Return the array of a file in the box that was written."""
    (grid,) = file.grids.values()
    first = np.rint((np.subtract(file.origin, origin)) / size).astype(int)
    whole = np.zeros(shape, np.float32)
    if grid.size:
        whole[tuple(slice(a, a + n) for a, n in zip(first, grid.shape[:3], strict=True))] = grid
    return whole


@pytest.mark.parametrize("packed", [True, False])
@pytest.mark.parametrize("up", ["y", "z"])
@pytest.mark.parametrize("case", CASES)
def test_round_trip(tmp_path, case, up, packed):
    """Every voxel comes back at its place, whatever way the file's axes point."""
    grid, origin = CASES[case], (-3.5, 20.25, 7.0)
    write_nvdb(tmp_path / "a.nvdb", {"density": grid}, voxel_size=0.25, origin=origin, up=up, packed=packed)
    file = read_nvdb(tmp_path / "a.nvdb", up=up)
    assert file.voxel_size == 0.25
    np.testing.assert_array_equal(placed(file, grid.shape, origin, 0.25), grid)


def sampled(volume, indices, kind):
    """Return what Warp reads at voxels."""
    points = wp.array(indices.astype(np.float32), dtype=wp.vec3, device="cpu")
    out = wp.zeros(len(indices), dtype=kind, device="cpu")
    kernel = sample_vectors if kind is wp.vec3 else sample_numbers
    wp.launch(kernel, dim=len(indices), inputs=[volume.id, points], outputs=[out], device="cpu")
    return out.numpy()


@wp.kernel
def sample_numbers(volume: wp.uint64, points: wp.array[wp.vec3], out: wp.array[float]):
    """Read the voxel at a point, linearly."""
    i = wp.tid()
    out[i] = wp.volume_sample_f(volume, points[i], wp.Volume.LINEAR)


@wp.kernel
def sample_vectors(volume: wp.uint64, points: wp.array[wp.vec3], out: wp.array[wp.vec3]):
    """The same of vectors."""
    i = wp.tid()
    out[i] = wp.volume_sample_v(volume, points[i], wp.Volume.LINEAR)


@pytest.mark.parametrize("case", ["one voxel", "odd", "across nodes", "across the root", "vectors"])
def test_warp_reads_every_voxel(tmp_path, case):
    """NVIDIA's own code finds each value at its index, and the name, place and size of the grid."""
    grid = CASES[case]
    write_nvdb(tmp_path / "a.nvdb", {"density": grid}, voxel_size=0.5, origin=(1.0, -2.0, 3.0))
    with open(tmp_path / "a.nvdb", "rb") as file:
        volume = wp.Volume.load_from_nvdb(file, device="cpu")
    info = volume.get_grid_info()
    assert info.name == "density"
    assert list(info.translation) == [1, -2, 3]
    np.testing.assert_allclose(volume.get_voxel_size(), 0.5)
    indices = np.argwhere(np.ones(grid.shape[:3], bool))[:: max(1, grid[..., 0].size // 20000)]
    kind = wp.vec3 if grid.ndim == 4 else float
    expected = grid[tuple(indices.T)]
    np.testing.assert_array_equal(sampled(volume, indices, kind), expected)


def test_only_what_is_there_is_stored(tmp_path):
    """A grid has the leaves that hold something, and says how many voxels those are, and where."""
    grid = np.zeros((64, 64, 64), np.float32)
    grid[40:44, 3, 60] = 1
    write_nvdb(tmp_path / "a.nvdb", {"density": grid})
    (facts,) = nvdb_facts(tmp_path / "a.nvdb")
    assert (facts.name, facts.kind, facts.active) == ("density", "float", 4)
    assert facts.box.tolist() == [[40, 3, 60], [43, 3, 60]]
    assert (tmp_path / "a.nvdb").stat().st_size < 8000


@pytest.mark.skipif(not shutil.which("nanovdb_validate"), reason="needs NanoVDB's tools (Debian: libnanovdb-tools)")
@pytest.mark.parametrize("case", ["one voxel", "odd", "across nodes", "across the root", "vectors"])
def test_nanovdb_finds_it_sound(tmp_path, case):
    """Its own tools accept every grid and print its name, class, count and box."""
    grid = CASES[case]
    grids = {"density": grid, "second": 2 * grid}
    write_nvdb(tmp_path / "a.nvdb", grids, voxel_size=0.5, packed=False)
    checked = subprocess.run(["nanovdb_validate", tmp_path / "a.nvdb"], capture_output=True, text=True, timeout=60)
    assert checked.returncode == 0, checked.stdout + checked.stderr
    printed = subprocess.run(["nanovdb_print", "-l", tmp_path / "a.nvdb"], capture_output=True, text=True, timeout=60)
    lit = grid.reshape(*grid.shape[:3], -1).any(-1)
    low, high = np.argwhere(lit).min(0), np.argwhere(lit).max(0)
    box = f"({','.join(map(str, low))}) -> ({','.join(map(str, high))})"
    for name in grids:
        line = next(line for line in printed.stdout.splitlines() if f" {name} " in line)
        assert box in line
        assert f" {lit.sum()} " in line
    found = subprocess.run(
        ["nanovdb_print", "-g", "second", tmp_path / "a.nvdb"], capture_output=True, text=True, timeout=60
    )
    assert "following grid:" in found.stdout


@pytest.mark.skipif(not shutil.which("nanovdb_convert"), reason="needs NanoVDB's tools (Debian: libnanovdb-tools)")
def test_we_read_files_of_nanovdb(tmp_path):
    """What its converter makes of a .vdb, with means and checksums that ours lack."""
    from warpfluid.files.vdb import write_vdb

    grids = {"density": CASES["odd"], "velocity": np.stack([CASES["odd"]] * 3, axis=-1)}
    write_vdb(tmp_path / "a.vdb", grids, voxel_size=0.5, origin=(1, 2, 3))
    subprocess.run(["nanovdb_convert", tmp_path / "a.vdb", tmp_path / "a.nvdb"], check=True, timeout=60)
    file = read_nvdb(tmp_path / "a.nvdb")
    for name, grid in grids.items():
        only = read_nvdb(tmp_path / "a.nvdb", [name])
        np.testing.assert_array_equal(placed(only, grid.shape, (1, 2, 3), 0.5), grid)
    assert file.grids.keys() == grids.keys()


def test_wrong_arguments(tmp_path):
    """They leave no file."""
    with pytest.raises(ValueError, match="grid 'density' holds NaN"):
        write_nvdb(tmp_path / "a.nvdb", {"density": np.full((2, 2, 2), np.nan)})
    with pytest.raises(ValueError, match="is too long"):
        write_nvdb(tmp_path / "a.nvdb", {"d" * 300: np.ones((2, 2, 2))})
    assert not list(tmp_path.iterdir())
    write_nvdb(tmp_path / "a.nvdb", {"density": np.ones((2, 2, 2))})
    with pytest.raises(ValueError, match=r"a\.nvdb: the file has no grid flame"):
        read_nvdb(tmp_path / "a.nvdb", ["flame"])


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_damaged_files_end_in_an_error(tmp_path_factory, data):
    """A file that is cut short is refused; with other bytes it is refused or read, and nothing else."""
    path = tmp_path_factory.mktemp("damage") / "a.nvdb"
    write_nvdb(path, {"density": CASES["odd"]}, packed=data.draw(st.booleans()))
    whole = path.read_bytes()
    path.write_bytes(whole[: data.draw(st.integers(0, len(whole) - 1))])
    with pytest.raises(ValueError, match=r"a\.nvdb: "):
        read_nvdb(path)
    damaged = bytearray(whole)
    for place in data.draw(st.lists(st.integers(0, 900), min_size=1, max_size=3)):
        damaged[min(place, len(damaged) - 1)] = data.draw(st.integers(0, 255))
    path.write_bytes(damaged)
    with contextlib.suppress(ValueError):
        read_nvdb(path)
