"""USD stages: lines that are looked for, and the whole of it read by USD itself where it is installed."""

import importlib.util
import json
import os
import subprocess
import sys

import numpy as np
import pytest

from warpfluid.files.usd import UsdBody, write_usda

READ = """
import json, sys
from pxr import Usd, UsdGeom, UsdVol
stage = Usd.Stage.Open(sys.argv[1])
volume = UsdVol.Volume(stage.GetPrimAtPath("/warpfluid/volume"))
fields = {}
for name, path in volume.GetFieldPaths().items():
    field = UsdVol.OpenVDBAsset(stage.GetPrimAtPath(path))
    files = field.GetFilePathAttr()
    fields[name] = {
        "field": field.GetFieldNameAttr().Get(), "type": field.GetFieldDataTypeAttr().Get(),
        "files": {t: files.Get(t).resolvedPath for t in files.GetTimeSamples()},
    }
print(json.dumps({
    "up": str(UsdGeom.GetStageUpAxis(stage)), "meters": UsdGeom.GetStageMetersPerUnit(stage),
    "times": [stage.GetStartTimeCode(), stage.GetEndTimeCode(), stage.GetTimeCodesPerSecond()],
    "default": str(stage.GetDefaultPrim().GetPath()), "fields": fields,
    "extent": [list(corner) for corner in volume.GetExtentAttr().Get()],
    "bodies": [
        {"name": prim.GetName(),
         "moves": {t: [list(row) for row in UsdGeom.Xformable(prim).GetLocalTransformation(t)] for t in (1, 2)},
         "points": [list(p) for p in UsdGeom.Mesh(prim.GetChildren()[0]).GetPointsAttr().Get()]}
        for prim in stage.GetPrimAtPath("/warpfluid").GetChildren() if prim.GetTypeName() == "Xform"
    ],
}))
"""


def reader() -> str:
    """Return a Python that has USD, or skip; WARPFLUID_USD_PYTHON may name one."""
    if importlib.util.find_spec("pxr"):
        return sys.executable
    if "WARPFLUID_USD_PYTHON" in os.environ:
        return os.environ["WARPFLUID_USD_PYTHON"]
    pytest.skip("no usd-core here, and WARPFLUID_USD_PYTHON names no Python with it")


def turn(angle: float) -> np.ndarray:
    """Return the quaternion (x, y, z, w) of a turn about y."""
    return np.array([0, np.sin(angle / 2), 0, np.cos(angle / 2)])


def write(path, **changes):
    """Write a stage of two frames with a body."""
    vertices, triangles = np.eye(3) - 1 / 3, np.array([[0, 1, 2]])
    poses = {1: (np.array([1.0, 2.0, 3.0]), turn(0.0)), 2: (np.array([4.0, 5.0, 6.0]), turn(0.7))}
    body = UsdBody("a body", vertices, triangles, poses)
    files = {1: "density.0001.vdb", 2: "density.0002.vdb"}
    for name in files.values():
        (path.parent / name).touch()
    grids = {"density": "float", "vel": "vec3s"}
    extent = np.array([[-1, 0, -1], [1, 3, 1]])
    write_usda(path, files, grids, **({"extent": extent, "bodies": [body]} | changes))
    return body


def test_lines(tmp_path):
    """Axis, times and files, relative to the stage."""
    write(tmp_path / "a.usda", up="z", fps=23.976)
    text = (tmp_path / "a.usda").read_text()
    for line in ('upAxis = "Z"', "timeCodesPerSecond = 23.976", "2: @./density.0002.vdb@,", 'def Xform "a_body"'):
        assert line in text
    with pytest.raises(ValueError, match="there are no files to show"):
        write_usda(tmp_path / "b.usda", {}, {}, extent=np.zeros((2, 3)))


@pytest.mark.parametrize("half", [False, True])
def test_usd_reads_it(tmp_path, half):
    """Fields lead to the files of each time, bodies move as they were told."""
    body = write(tmp_path / "a.usda", half=half)
    command = [reader(), "-c", READ, str(tmp_path / "a.usda")]
    result = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert result.returncode == 0, result.stderr
    found = json.loads(result.stdout)
    assert (found["up"], found["meters"], found["times"]) == ("Y", 1, [1, 2, 24])
    assert found["default"] == "/warpfluid"
    assert found["extent"] == [[-1, 0, -1], [1, 3, 1]]
    number = "half" if half else "float"
    assert {name: field["type"] for name, field in found["fields"].items()} == {"density": number, "vel": f"{number}3"}
    for name, field in found["fields"].items():
        assert field["field"] == name
        assert field["files"] == {f"{n}.0": str(tmp_path / f"density.000{n}.vdb") for n in (1, 2)}
    (moved,) = found["bodies"]
    np.testing.assert_allclose(moved["points"], body.vertices, atol=1e-6)
    for frame, (position, angle) in {"1": ([1, 2, 3], 0.0), "2": ([4, 5, 6], 0.7)}.items():
        matrix = np.array(moved["moves"][frame])  # rows, as USD has it
        c, s = np.cos(angle), np.sin(angle)
        np.testing.assert_allclose(matrix[:3, :3].T, [[c, 0, s], [0, 1, 0], [-s, 0, c]], atol=1e-6)
        np.testing.assert_allclose(matrix[3, :3], position, atol=1e-6)


def test_odd_names_stay_names(tmp_path):
    """Quotes, newlines and signs end no string; names that USD would take for one stay two."""
    odd = 'a"]\n}\ndef Xform "x" {\x07 é @'
    one, two, three = (
        UsdBody(name, np.eye(3), np.array([[0, 1, 2]]), {1: (np.zeros(3), turn(0.0)), 2: (np.zeros(3), turn(0.0))})
        for name in ("volume", "a b", "a_b")
    )
    write_usda(
        tmp_path / "a.usda",
        {1: "d@1.vdb"},
        {odd: "float", "v-1": "vec3s", "v_1": "vec3s"},
        extent=np.zeros((2, 3)),
        bodies=[one, two, three],
    )
    done = subprocess.run(
        [reader(), "-c", READ, str(tmp_path / "a.usda")], capture_output=True, text=True, check=True, timeout=100
    )
    told = json.loads(done.stdout)
    assert sorted(field["field"] for field in told["fields"].values()) == sorted([odd, "v-1", "v_1"])
    assert [body["name"] for body in told["bodies"]] == ["volume_2", "a_b", "a_b_2"]


def test_files_that_no_stage_can_name(tmp_path):
    """They are refused by name."""
    with pytest.raises(ValueError, match=r"cannot name the file 'a\\nb.vdb'"):
        write_usda(tmp_path / "a.usda", {1: "a\nb.vdb"}, {"density": "float"}, extent=np.zeros((2, 3)))
