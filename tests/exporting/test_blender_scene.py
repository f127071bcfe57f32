"""The scene for Blender shows the footage again: the same light, at the same place, and nothing around it."""

import importlib.util
import subprocess
from pathlib import Path

import numpy as np
import pytest
from tiny import run

from warpfluid.files.exr import read_exr
from warpfluid.files.vdb import write_vdb

pytestmark = pytest.mark.blender

SPEC = importlib.util.spec_from_file_location("importing", Path(__file__).parents[1] / "files" / "test_vdb_blender.py")
importing = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(importing)

SIZE = 0.05


def cloud(frame: int) -> np.ndarray:
    """Return a smooth blob off the middle, shape (x, y, z), that rises; its brightest ray is 255."""
    x, y, z = np.ogrid[:24, :32, :20]
    far = (x - 8.0) ** 2 + (y - 8.0 - 4 * frame) ** 2 + (z - 13.0) ** 2
    blob = np.where(far < 60, np.exp(-far / 12), 0).astype(np.float32)
    return blob * 255 / blob.sum(axis=2).max()


def render(folder: Path, *flags: str) -> np.ndarray:
    """Run the script in a folder; return the light of its picture, top row first."""
    command = importing.blender_command(str(folder / "open_in_blender.py"))
    command += [] if "--" in command else ["--"]
    command += [*flags, "--render", str(folder / "picture.exr")]
    result = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert result.returncode == 0, result.stdout + result.stderr
    return read_exr(folder / "picture.exr")


@pytest.mark.parametrize("source_up", ["y", "z"])
def test_the_front_is_seen_again(tmp_path, source_up):
    """Without colours, lens and smoke a pixel is the ray's sum over 255, centred where the voxels are."""
    for frame in (1, 2, 3):
        grids = {"density": cloud(frame), "velocity": np.stack([cloud(frame)] * 3, axis=-1)}
        path = tmp_path / f"a.{frame:04d}.vdb"
        write_vdb(path, grids, voxel_size=SIZE, origin=(-0.6, 0.025, -0.5), up=source_up)
    assert run("export", tmp_path / "a.####.vdb", "-o", tmp_path / "out", "--format", "blender", "-q") == 0
    flags = ("--look", "plain", "--front", "--size", "24x32", "--samples", "32", "--frame", "3")
    picture = render(tmp_path / "out", *flags).mean(axis=2)
    expected = cloud(3).sum(axis=2).T[::-1] / 255
    assert picture.sum() == pytest.approx(expected.sum(), rel=0.01)
    np.testing.assert_allclose(picture, expected, atol=0.08)  # Blender filters its pixels
    rows, columns = np.mgrid[:32, :24]
    for along in (rows, columns):
        centres = [(light * along).sum() / light.sum() for light in (picture, expected)]
        assert centres[0] == pytest.approx(centres[1], abs=0.05)
    assert picture[:2].max() < 1e-4  # no box that glows


@pytest.mark.parametrize("look", ["fire", "smoke", "explosion"])
def test_looks(tmp_path, look):
    """Each shows the cloud in the middle and its own sky in the corners."""
    grids = {"density": cloud(2), "flame": cloud(2) / 50, "temperature": cloud(2) / 60}
    write_vdb(tmp_path / "a.vdb", grids, voxel_size=SIZE)
    flags = ["--format", "blender", "--look", look, "-q"]
    assert run("export", tmp_path / "a.vdb", "-o", tmp_path / "out", *flags) == 0
    picture = render(tmp_path / "out", "--size", "36x48", "--samples", "8")
    sky = picture[[0, 0, -1, -1], [0, -1, 0, -1]]
    np.testing.assert_allclose(sky, sky[:1].repeat(4, axis=0), atol=1e-3)
    where = np.abs(picture - sky[0]).max(axis=2)
    assert where.max() > 0.1
    if look != "smoke":
        red, _, blue = picture[np.unravel_index(where.argmax(), where.shape)]
        assert red > 2 * blue
