"""What stands around exported volumes: boxes, speed, and bodies that turn with the world."""

import json
import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tiny import run

from warpfluid.exporting.scene import write_stage
from warpfluid.files.usd import UsdBody
from warpfluid.files.vdb import write_vdb
from warpfluid.options import ExportOptions

BOX = ["--preset", "smoke", "--size", "12x16", "--frames", "1-2", "--fps", "30", "--device", "cpu", "--no-turntable"]


def stage_of(tmp_path, body: UsdBody, up: str) -> str:
    """Return the text of a stage with one frame and one body."""
    facts = {"file": "a.vdb", "voxel_size": 0.5, "origin": [1.0, 2.0, 3.0], "shape": [4, 6, 8]}
    record = {"fps": 24.0, "frames": {"1": facts | {"grids": {"density": "float"}}}}
    write_stage(tmp_path / "a.usda", record, [body], ExportOptions(format="usda", up=up))
    return (tmp_path / "a.usda").read_text()


def numbers(text: str, name: str) -> np.ndarray:
    """Return the tuples after a name, shape (n, values)."""
    found = re.search(rf"{re.escape(name)}[^=\n]* = [\[{{](.*?)[\]}}]", text, re.DOTALL)[1]
    return np.array([[float(n) for n in part.split(",")] for part in re.findall(r"\(([^)]*)\)", found)])


def test_bodies_turn_with_the_world(tmp_path):
    """With z up every corner of a body is at (x, -z, y) of where it was, and the box as well."""
    turn = Rotation.from_euler("xyz", [20, -50, 75], degrees=True)
    vertices = np.random.default_rng(0).normal(size=(5, 3))
    body = UsdBody("body1", vertices, np.array([[0, 1, 2]]), {1: (np.array([1.0, 2.0, 3.0]), turn.as_quat())})
    places = {}
    for up in ("y", "z"):
        text = stage_of(tmp_path, body, up)
        w, *xyz = numbers(text, "quatf xformOp:orient.timeSamples")[0]
        turned = Rotation.from_quat([*xyz, w]).apply(numbers(text, "point3f[] points"))
        places[up] = turned + numbers(text, "double3 xformOp:translate.timeSamples")[0]
        extent = numbers(text, "float3[] extent")
        x, y, z = (0.75, 2.75), (1.75, 4.75), (2.75, 6.75)
        expected = (x, y, z) if up == "y" else (x, (-z[1], -z[0]), y)
        np.testing.assert_allclose(extent.T, expected)
    np.testing.assert_allclose(places["y"], np.add(turn.apply(vertices), [1, 2, 3]), atol=1e-6)
    standing = places["y"] @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    np.testing.assert_allclose(places["z"], standing, atol=1e-6)


def test_a_simulation_with_a_body(tmp_path, capsys):
    """Its speed, its body and the body's way are in the stage; a voxel twice as wide makes all of it twice as large."""
    source, body = tmp_path / "run", "box center=0,6,0 size=2,1,1"
    assert run("simulate", *BOX, "--body", body, "-o", source, "-q") == 0
    listed = json.loads((source / "bodies.json").read_text())["frames"]
    for factor, flags in ((1, []), (2, ["--voxel-size", "0.02"])):
        out = tmp_path / f"out{factor}"
        assert run("export", source, "-o", out, "--format", "usda", *flags, "-q") == 0
        text = (out / "volumes.usda").read_text()
        assert "timeCodesPerSecond = 30" in text
        ways = numbers(text, "double3 xformOp:translate.timeSamples")
        expected = [factor * np.array(frame["bodies"][0]["position"]) for frame in listed]
        np.testing.assert_allclose(ways, expected, atol=1e-6)
        points = numbers(text, "point3f[] points")
        np.testing.assert_allclose(np.ptp(points, axis=0), factor * 0.16 * np.array([0.2, 0.1, 0.1]), rtol=1e-5)
    other = {"names": ["a", "b"], "frames": [{"frame": 1, "bodies": 2 * listed[0]["bodies"]}]}
    (source / "bodies.json").write_text(json.dumps(other))
    assert run("export", source, "-o", tmp_path / "odd", "--format", "usda", "-q") == 2
    assert "bodies.json has 2 bodies, the settings 1" in capsys.readouterr().err


@pytest.mark.parametrize("flame", [True, False])
def test_what_the_record_tells_scenes(tmp_path, flame):
    """Which grids there are, how dense is full, how bright the brightest ray."""
    density = np.zeros((4, 5, 6), np.float32)
    density[1, 2, :3] = [1, 2, 4]
    grids = {"density": density} | ({"flame": density / 8} if flame else {})
    write_vdb(tmp_path / "a.vdb", grids, voxel_size=0.5)
    assert run("export", tmp_path / "a.vdb", "-o", tmp_path / "out", "--format", "blender", "--fps", "25", "-q") == 0
    record = json.loads((tmp_path / "out" / "export.json").read_text())
    assert (record["fps"], record["up"], record["bodies"]) == (25, "z", [])
    frame = record["frames"]["1"]
    assert set(frame["grids"]) == set(grids)
    assert frame["brightest_ray"] == 7
    assert frame["full"]["density"] == pytest.approx(np.quantile([1, 2, 4], 0.99))
    script = (tmp_path / "out" / "open_in_blender.py").read_text()
    compile(script, "open_in_blender.py", "exec")
