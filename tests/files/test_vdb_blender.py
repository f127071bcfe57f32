"""Blender imports our files: grids, frames of a sequence, size and place.

Runs where ``bpy`` can be imported, or where the environment variable ``WARPFLUID_BLENDER`` names a Blender.
"""

import importlib.util
import json
import os
import subprocess
import sys

import numpy as np
import pytest

from warpfluid.files.vdb import write_vdb

pytestmark = pytest.mark.blender

SCRIPT = """
import json, sys
import bpy

first, count = sys.argv[-2], int(sys.argv[-1])
folder, name = first.rsplit("/", 1)
stem, number, _ = name.rsplit(".", 2)
files = [{"name": f"{stem}.{int(number) + i:04d}.vdb"} for i in range(count)]
bpy.ops.object.volume_import(
    filepath=first, directory=folder, files=files, use_sequence_detection=True, align="WORLD"
)
volume = bpy.context.object.data
found = {"sequence": volume.is_sequence, "frames": volume.frame_duration, "start": volume.frame_start,
         "offset": volume.frame_offset, "grids": []}
for frame in range(count):
    bpy.context.scene.frame_set(volume.frame_start + frame)
    volume.grids.load()
    grids = {}
    for grid in volume.grids:
        grid.load()
        grids[grid.name] = {"type": grid.data_type, "matrix": [list(row) for row in grid.matrix_object]}
    found["grids"].append({"error": volume.grids.error_message, "file": volume.grids.frame_filepath, **grids})
print("FOUND " + json.dumps(found))
"""


def blender_command(script):
    """Return the command that runs a script in Blender, or skip."""
    program = os.environ.get("WARPFLUID_BLENDER")
    if program:
        return [
            program,
            "--background",
            "--factory-startup",
            "--python-exit-code",
            "1",
            "--python",
            script,
            "--",
        ]
    if importlib.util.find_spec("bpy"):
        return [sys.executable, script]
    pytest.skip("no bpy here, and WARPFLUID_BLENDER names no Blender")


@pytest.mark.parametrize("half", [False, True])
def test_blender_imports_a_sequence(tmp_path, half):
    """Three frames become one volume object with a float and a vector grid at the right place."""
    script = tmp_path / "look.py"
    script.write_text(SCRIPT)
    command = blender_command(str(script))
    density = np.zeros((9, 20, 7), np.float32)
    density[2:7, 3:18, 1:6] = 1
    for frame in (1001, 1002, 1003):
        grids = {"density": density * frame, "velocity": np.stack([density] * 3, axis=-1)}
        path = tmp_path / f"fire.{frame}.vdb"
        write_vdb(path, grids, up="z", half=half, voxel_size=0.25, origin=(1.0, 2.0, 3.0))
    command += [str(tmp_path / "fire.1001.vdb"), "3"]
    result = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, result.stdout + result.stderr
    line = next(line for line in result.stdout.splitlines() if line.startswith("FOUND "))
    found = json.loads(line.removeprefix("FOUND "))
    assert found["sequence"] is True
    assert found["frames"] == 3
    assert found["offset"] == 1000
    for grids in found["grids"]:
        assert grids["error"] == ""
        assert grids["density"]["type"] == "FLOAT"
        assert grids["velocity"]["type"] == "VECTOR_FLOAT"
        matrix = np.array(grids["density"]["matrix"])
        assert np.allclose(matrix[:3, :3], 0.25 * np.eye(3))
        assert np.allclose(matrix[:3, 3], [1.0, -3.0, 2.0])
    assert {os.path.basename(grids["file"]) for grids in found["grids"]} == {
        f"fire.{n}.vdb" for n in (1001, 1002, 1003)
    }
