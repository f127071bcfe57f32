"""Sequences that the real OpenVDB wrote, every frame cut to what it holds."""

import contextlib
import importlib.util
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tiny import run as run_command

from warpfluid.files.vdb import vdb_facts, write_vdb
from warpfluid.volumes import open_volumes

SPEC = importlib.util.spec_from_file_location("binding", Path(__file__).parents[1] / "files" / "test_vdb_openvdb.py")
binding = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(binding)

pytestmark = pytest.mark.openvdb

# A cube of 3 voxels that travels across the borders of nodes; the last frame is empty; names and boxes of Houdini.
MAKE = """
folder = sys.argv[1]
for frame in range(1, 5):
    grids = []
    for name, scale in (("density", 1.0), ("temperature", 10.0)):
        grid = vdb.FloatGrid()
        grid.name, grid.gridClass = name, vdb.GridClass.FOG_VOLUME
        grid.transform = vdb.createLinearTransform(voxelSize=0.5)
        grid.transform.translate((1.0, 2.0, 3.0))
        values = grid.getAccessor()
        for n in range(27 if frame < 4 else 0):
            i, j, k = 120 * (frame - 2) + n % 3, 5 + n // 9, -frame + n // 3 % 3
            values.setValueOn((i, j, k), scale * (frame + n))
        grids.append(grid)
    points = vdb.BoolGrid()
    points.name = "mask"
    vdb.write(f"{folder}/smoke.{frame:04d}.vdb", grids=[*grids, points])
"""

BAD = """
grid = vdb.FloatGrid()
grid.name = "density"
values = grid.getAccessor()
for n in range(10):
    values.setValueOn((n, 0, 0), float("nan") if n % 3 == 0 else float(n))
values.setValueOn((20, 0, 0), float("-inf"))
vdb.write(sys.argv[1] + "/a.vdb", grids=[grid])
"""


def test_frames_are_placed(tmp_path):
    """Every voxel of every frame is where OpenVDB says; grids that are not read do not disturb."""
    binding.run(MAKE, tmp_path)
    sequence = open_volumes(tmp_path)
    assert sequence.frames == (1, 2, 3, 4)
    lattice = sequence.lattice
    assert lattice.shape == (243, 3, 5)
    np.testing.assert_allclose(lattice.origin, [1 + 0.5 * -120, 2 + 0.5 * 5, 3 + 0.5 * -3])
    for frame in range(1, 4):
        truth = binding.read_by_openvdb(tmp_path / f"smoke.{frame:04d}.vdb")["grids"]
        file = sequence.read(frame)
        assert list(file.grids) == ["density", "temperature"]
        for name in file.grids:
            expected = np.zeros(lattice.shape, np.float32)
            for i, j, k, value in truth[name]["voxels"]:
                expected[i + 120, j - 5, k + 3] = value
            np.testing.assert_array_equal(file.grids[name], expected)
    assert not sequence.density(4).any()


def test_facts_without_values(tmp_path):
    """Box and count are those of OpenVDB, from its metadata or, where that is cut out, from the tree."""
    binding.run(MAKE, tmp_path)
    path = tmp_path / "smoke.0003.vdb"
    truth = binding.read_by_openvdb(path)["grids"]
    data = path.read_bytes()
    for name in (b"file_bbox_min", b"file_voxel_count"):
        path.write_bytes(data.replace(name, name[:-1] + b"X"))
        density = next(grid for grid in vdb_facts(path) if grid.name == "density")
        assert density.box.tolist() == truth["density"]["box"]
        assert density.active == truth["density"]["count"] == 27
        assert (density.voxel_size, density.shift) == (0.5, (1.0, 2.0, 3.0))
    assert [grid.readable for grid in vdb_facts(path)] == [True, True, False]


def test_nan_is_named_and_repaired(tmp_path, capsys):
    """Simulating stops at once with file and number; exporting writes 0 there and says so."""
    binding.run(BAD, tmp_path)
    with pytest.raises(
        ValueError, match=r"a\.vdb: the density is negative or not finite in 5 of 21 voxels; .*--repair"
    ):
        open_volumes(tmp_path / "a.vdb")
    assert run_command("export", tmp_path / "a.vdb", "-o", tmp_path / "out") == 1
    assert "not finite in 5 of 21 voxels: write 0 there with --repair" in capsys.readouterr().err
    assert run_command("export", tmp_path / "a.vdb", "-o", tmp_path / "out", "--repair") == 0
    assert "5 voxels of density repaired" in capsys.readouterr().err
    voxels = binding.read_by_openvdb(tmp_path / "out" / "density.0001.vdb")["grids"]["density"]["voxels"]
    assert [value for *_, value in voxels] == [1, 2, 4, 5, 7, 8]


def filled(shape, part):
    """Return random density at a part of the voxels, and a wind."""
    rng = np.random.default_rng(5)
    density = np.where(rng.random(shape) < part, rng.uniform(0.5, 2, shape), 0).astype(np.float32)
    return {"density": density, "velocity": np.stack([density, -2 * density, 3 * density], axis=-1)}


CASES = {"odd": filled((17, 9, 23), 0.2), "empty": filled((5, 6, 7), 0.0), "one voxel": filled((1, 1, 1), 1.1)}
COPY = "grids, facts = vdb.readAll(sys.argv[1]); vdb.write(sys.argv[1], grids=grids, metadata=facts)"


@pytest.mark.parametrize("flags", [[], ["--half"], ["--up", "z"], ["--up", "z", "--half"]])
@pytest.mark.parametrize("case", CASES)
def test_there_and_back(tmp_path, case, flags):
    """Exported, read and written by OpenVDB, read again: every voxel and vector is where it was."""
    write_vdb(tmp_path / "a.0001.vdb", CASES[case], voxel_size=0.25, origin=(-2, 0.125, 3))
    out = tmp_path / "out"
    assert run_command("export", tmp_path / "a.0001.vdb", "-o", out, *flags, "-q") == 0
    binding.run(COPY, out / "density.0001.vdb")
    file = open_volumes(out, unchecked=True).read(1)
    np.testing.assert_allclose(file.origin, (-2, 0.125, 3), atol=1e-9)
    assert file.voxel_size == 0.25
    for name, grid in CASES[case].items():
        kept = grid.astype(np.float16) if "--half" in flags else grid
        np.testing.assert_array_equal(file.grids[name], kept)


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_facts_of_damaged_files(tmp_path_factory, data):
    """They are told or refused, and nothing else."""
    path = tmp_path_factory.mktemp("damage") / "a.vdb"
    write_vdb(path, CASES["odd"])
    damaged = bytearray(path.read_bytes())
    for place in data.draw(st.lists(st.integers(0, 1500), min_size=1, max_size=3)):
        damaged[place] = data.draw(st.integers(0, 255))
    path.write_bytes(damaged[: data.draw(st.integers(0, len(damaged)))])
    with contextlib.suppress(ValueError):
        vdb_facts(path)
