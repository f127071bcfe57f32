"""The real OpenVDB reads our files voxel by voxel, and we read the files it writes.

Its Python binding belongs to the system's Python (on Debian: ``apt install python3-openvdb``), so it runs in
a process of its own and talks JSON.
"""

import functools
import json
import shutil
import subprocess

import numpy as np
import pytest

from warpfluid.files.vdb import read_vdb, write_vdb

pytestmark = pytest.mark.openvdb

BINDING = """
import json, sys
try:
    import openvdb as vdb
except ImportError:
    import pyopenvdb as vdb
"""

DUMP = """
def active(grid):
    # A tile stands for many voxels at once.
    for item in grid.citerOnValues():
        low, high = item.min, item.max
        for i in range(low[0], high[0] + 1):
            for j in range(low[1], high[1] + 1):
                for k in range(low[2], high[2] + 1):
                    yield [i, j, k, item.value]

def describe(grid):
    return {
        "type": grid.valueTypeName, "class": str(grid.gridClass), "half": grid.saveFloatAsHalf,
        "voxel_size": list(grid.transform.voxelSize()), "count": grid.activeVoxelCount(),
        "vector": str(grid.vectorType), "box": grid.evalActiveVoxelBoundingBox(),
        "first": list(grid.transform.indexToWorld((0, 0, 0))), "voxels": list(active(grid)),
    }

grids, metadata = vdb.readAll(sys.argv[1])
print(json.dumps({"grids": {grid.name: describe(grid) for grid in grids}, "metadata": metadata}))
"""

MAKE = """
facts = {"fps": 24.0, "frame": 7, "shot": "sea", "loop": True}
fog = vdb.FloatGrid()
fog.name, fog.gridClass = "density", vdb.GridClass.FOG_VOLUME
values = fog.getAccessor()
for n in range(60):
    values.setValueOn((7 * n - 200, 3 * n, -5 * n), n + 0.25)
fog.fill((-128, 0, 0), (-113, 7, 15), 2.5)  # whole leaves become tiles once pruned
fog.prune()
values.setValueOff((-100, 3, 3), -7.0)
wind = vdb.Vec3SGrid()
wind.name = "velocity"
winds = wind.getAccessor()
for n in range(20):
    winds.setValueOn((9 * n, -n, n), (n, -n, 0.5))
half = vdb.FloatGrid()
half.name, half.saveFloatAsHalf = "half", True
half.getAccessor().setValueOn((1, 2, 3), 0.1)
for grid in (fog, wind, half):
    grid.transform = vdb.createLinearTransform(voxelSize=0.5)
    grid.transform.translate((10.0, 20.0, 30.0))
vdb.write(sys.argv[1], grids=[fog, wind, half], metadata=facts)
"""


@functools.cache
def interpreter():
    """Return a Python that has the binding, or None."""
    found = {shutil.which(name, path="/usr/bin:/usr/local/bin:/opt/homebrew/bin") for name in ("python3", "python")}
    for python in (found | {shutil.which("python3"), shutil.which("python")}) - {None}:
        if subprocess.run([python, "-c", BINDING], capture_output=True, timeout=60).returncode == 0:
            return python
    return None


def run(script, path):
    """Run a script with the binding; return what it prints and what it complains of."""
    if interpreter() is None:
        pytest.skip("no Python with the OpenVDB binding (Debian: apt install python3-openvdb)")
    command = [interpreter(), "-c", BINDING + script, str(path)]
    result = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert result.returncode == 0, result.stderr
    assert result.stderr == ""
    return result.stdout


def read_by_openvdb(path):
    """Return what OpenVDB finds in a file."""
    return json.loads(run(DUMP, path))


def filled(shape, indices):
    """Return random values at some voxels of an empty array."""
    array = np.zeros(shape, np.float32)
    rng = np.random.default_rng(3)
    for index in indices:
        array[index] = rng.normal(size=array[index].shape)
    return array


CASES = {
    "one voxel": filled((1, 1, 1), [(0, 0, 0)]),
    "odd": filled((9, 7, 11), [(slice(None),) * 3]),
    "across nodes": filled((300, 3, 140), [(slice(120, 136), 1, slice(120, 136)), (299, 2, 139), (0, 0, 0)]),
    "across the root": filled((4100, 2, 2), [(slice(4090, 4099), 0, 1), (3, 1, 1)]),
    "empty": np.zeros((5, 6, 7), np.float32),
}


@pytest.mark.parametrize("half", [False, True])
@pytest.mark.parametrize("up", ["y", "z"])
@pytest.mark.parametrize("case", CASES)
def test_openvdb_reads_every_voxel(tmp_path, case, up, half):
    """OpenVDB finds exactly our active voxels, at the right place, with the names and classes of others."""
    density = CASES[case]
    velocity = np.stack([density, 2 * density, -density], axis=-1)
    path, origin = tmp_path / "a.vdb", (-100.5, 3000.25, 7.0)
    write_vdb(path, {"density": density, "velocity": velocity}, up=up, half=half, voxel_size=0.25, origin=origin)
    grids = read_by_openvdb(path)["grids"]
    stored = (lambda value: float(np.float16(value))) if half else float
    x, y, z = origin
    expected = {}
    for i, j, k in np.argwhere(density).tolist():
        expected[(i, j, k) if up == "y" else (i, -k, j)] = stored(density[i, j, k])
    for grid in grids.values():
        assert grid["count"] == len(expected)
        assert grid["first"] == pytest.approx((x, y, z) if up == "y" else (x, -z, y), abs=1e-9)
        assert grid["voxel_size"] == [0.25] * 3
        assert grid["half"] is half
        if expected:
            assert grid["box"] == [np.min(list(expected), 0).tolist(), np.max(list(expected), 0).tolist()]
    assert {(i, j, k): value for i, j, k, value in grids["density"]["voxels"]} == expected
    for i, j, k, (a, b, c) in grids["velocity"]["voxels"]:
        value = density[(i, j, k) if up == "y" else (i, k, -j)]
        along = [stored(part) for part in (value, 2 * value, -value)]
        assert [a, b, c] == (along if up == "y" else [along[0], -along[2], along[1]])
    assert (grids["density"]["type"], grids["density"]["class"]) == ("float", "fog volume")
    assert (grids["velocity"]["type"], grids["velocity"]["class"]) == ("vec3s", "unknown")
    assert grids["velocity"]["vector"] == "contravariant relative"


def test_openvdb_reads_our_metadata(tmp_path):
    """OpenVDB shows our facts with their types."""
    facts = {"fps": 23.976, "frame": 2**40, "shot": "sea", "loop": False}
    write_vdb(tmp_path / "a.vdb", {"density": np.ones((2, 2, 2))}, metadata=facts)
    assert read_by_openvdb(tmp_path / "a.vdb")["metadata"] == facts | {"creator": "warpfluid"}


def test_our_file_survives_openvdb(tmp_path):
    """A file that another program read and saved still gives back the array that was written, zeros too."""
    density = np.zeros((30, 12, 9), np.float32)
    density[4:9:3, 7, 2:5] = [1, 2, 3]
    write_vdb(tmp_path / "a.vdb", {"density": density}, up="z", origin=(1, 2, 3))
    copy = "grids, facts = vdb.readAll(sys.argv[1]); vdb.write(sys.argv[1], grids=grids, metadata=facts)"
    before = (tmp_path / "a.vdb").read_bytes()
    run(copy, tmp_path / "a.vdb")
    assert (tmp_path / "a.vdb").read_bytes()[21:57] != before[21:57]
    file = read_vdb(tmp_path / "a.vdb")
    assert np.array_equal(file.grids["density"], density)
    assert file.origin == (1, 2, 3)


def test_we_read_files_of_openvdb(tmp_path):
    """Voxels, tiles, inactive values, halves, vectors, place and metadata of a real file are understood."""
    path = tmp_path / "a.vdb"
    run(MAKE, path)
    truth = read_by_openvdb(path)["grids"]
    file = read_vdb(path)
    assert file.metadata == {"fps": 24.0, "frame": 7, "shot": "sea", "loop": True}
    assert file.voxel_size == 0.5
    low = np.min([grid["box"][0] for grid in truth.values()], axis=0)
    high = np.max([grid["box"][1] for grid in truth.values()], axis=0)
    assert file.origin == tuple(np.array([10.0, 20.0, 30.0]) + 0.5 * low)
    for name, grid in truth.items():
        expected = np.zeros((*(high - low + 1), 3 if grid["type"] == "vec3s" else 1), np.float32)
        for i, j, k, value in grid["voxels"]:
            expected[tuple(np.array([i, j, k]) - low)] = value
        if name == "density":
            expected[tuple(np.array([-100, 3, 3]) - low)] = -7
        assert np.array_equal(file.grids[name], expected.reshape(file.grids[name].shape))


def test_we_read_level_sets(tmp_path):
    """A level set has values far inside and outside too: background and tiles, positive and negative."""
    path = tmp_path / "a.vdb"
    sphere = "vdb.write(sys.argv[1], grids=[vdb.createLevelSetSphere(radius=20.0)])"
    run(sphere, path)
    file = read_vdb(path)
    (distance,) = file.grids.values()
    index = np.indices(distance.shape).reshape(3, -1).T.reshape(*distance.shape, 3) + file.origin
    exact = np.clip(np.linalg.norm(index, axis=-1) - 20, -3, 3)
    assert np.abs(distance - exact).max() < 1e-4
