"""What a simulation starts from: runs, volumes of other programs, and what is refused."""

import shutil

import numpy as np
import pytest

from warpfluid.files.npz import write_npz
from warpfluid.files.vdb import write_vdb
from warpfluid.options import USUAL_SIZE, InputOptions, OutputOptions, ReconstructOptions
from warpfluid.run import Run
from warpfluid.settings import Settings
from warpfluid.simulation.source import empty_box, fill_box
from warpfluid.volumes import find_volumes, open_volumes

ORIGIN = (0.0, 0.0, 0.0)


def cloud(frame=1, width=8, depth=8, height=12) -> np.ndarray:
    """Return a blob that rises, shape (x, z, y)."""
    x, z, y = np.ogrid[:width, :depth, :height]
    far = (x - (width - 1) / 2) ** 2 + (z - (depth - 1) / 2) ** 2 + (y - 3 - frame) ** 2
    return np.where(far < 9, 10 * np.exp(-far / 5), 0).astype(np.float32)


def write(path, volume):
    """Write a volume (x, z, y) as another program might, in its own unit."""
    path.parent.mkdir(exist_ok=True)
    if path.suffix == ".npz":
        write_npz(path, volume.transpose(0, 2, 1))
    else:
        write_vdb(path, {"density": volume.transpose(0, 2, 1)}, voxel_size=0.1, origin=ORIGIN)
    return path


@pytest.fixture
def run(tmp_path) -> Run:
    """A reconstruction of the views 0 and 60, frames 7 and 8."""
    run, output = Run(tmp_path / "run"), OutputOptions(voxel_size=0.5, up="z", drop_below=0)
    method = {"input": InputOptions(), "reconstruct": ReconstructOptions(), "output": output}
    run.begin(Settings(views=("0=/a", "60=/b"), **method), {"inputs": {}})
    for frame in (7, 8):
        run.write_frame(frame, cloud(frame - 6), output, {})
    return run


def test_a_run(run):
    """Its volumes as they are, its views' angles, and the way its files are stored."""
    source = fill_box(open_volumes(str(run.folder)))
    assert source.frames == (7, 8)
    assert source.volumes.angles_deg == (0.0, 60.0)
    assert (source.volumes.scale, source.volumes.output.voxel_size, source.volumes.output.up) == (1.0, 0.5, "z")
    np.testing.assert_array_equal(source.volume(8), cloud(2))
    assert source.shape == (8, 8, 12)
    lit = cloud(1)[cloud(1) > 0]
    assert source.reference == pytest.approx(np.quantile(lit, 0.99))


def test_a_run_without_frames(run):
    """It has to be reconstructed first."""
    (run.folder / "frames.jsonl").unlink()
    with pytest.raises(ValueError, match="has no finished frame: reconstruct it first"):
        fill_box(open_volumes(str(run.folder)))


@pytest.mark.parametrize("kind", [".vdb", ".npz"])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
def test_volumes_of_another_program(tmp_path, kind, scale):
    """Whatever their unit: the brightest ray of the first is 255, and the others keep to its scale."""
    for frame in (3, 5):
        write(tmp_path / "a" / f"smoke_v2.{frame:04d}{kind}", cloud(frame - 2) * scale * (1 if frame == 3 else 0.5))
    source = fill_box(open_volumes(str(tmp_path / "a")))
    assert source.frames == (3, 5)
    assert source.volumes.angles_deg == (0.0, 90.0)
    assert source.volume(3).sum(axis=1).max() == pytest.approx(255, rel=1e-5)
    whole = cloud(1) * 255 / cloud(1).sum(axis=1).max()
    np.testing.assert_allclose(source.volume(3), whole, rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(source.volume(5).sum(), whole.sum() / 2 * cloud(3).sum() / cloud(1).sum(), rtol=1e-4)


@pytest.mark.parametrize("pattern", ["b.####.npz", "b.%04d.npz", "b.*.npz"])
def test_patterns(tmp_path, pattern):
    """They choose one sequence of a folder that has several."""
    for name in ("a.0001.npz", "b.0001.npz", "b.0002.npz", "b.txt", ".b.0003.npz"):
        write(tmp_path / name, cloud()) if name.endswith("npz") else (tmp_path / name).touch()
    assert list(find_volumes(tmp_path / pattern)) == [1, 2]
    assert [path.name for path in find_volumes(tmp_path / "b.0002.npz").values()] == ["b.0002.npz"]
    with pytest.raises(ValueError, match=r"has several sequences, a\.####\.npz, b\.####\.npz: choose one with a pa"):
        find_volumes(tmp_path)


def test_one_file(tmp_path):
    """Its frame is the last number of its name, or 1."""
    assert list(find_volumes(write(tmp_path / "shot3.0042.vdb", cloud()))) == [42]
    assert list(find_volumes(write(tmp_path / "cloud.vdb", cloud()))) == [1]


def test_two_files_of_one_frame(tmp_path):
    """Nobody knows which counts."""
    for name in ("a.01.npz", "a.1.npz"):
        write(tmp_path / name, cloud())
    with pytest.raises(ValueError, match="several volumes of one frame"):
        find_volumes(tmp_path)


@pytest.mark.parametrize("name", ["none", "none.npz", "none.####.npz", "no/such/folder.####.vdb", "empty"])
def test_nothing_there(tmp_path, name):
    """The message says what is taken."""
    (tmp_path / "empty").mkdir()
    with pytest.raises(
        ValueError, match=r"(has no volumes|does not exist): name a run, or a folder, pattern or file of \.vdb, "
    ):
        fill_box(open_volumes(str(tmp_path / name)))


def test_a_box_that_is_not_square(tmp_path):
    """It is made as deep as it is wide, with the volume in the middle; nothing is lost."""
    path = write(tmp_path / "a.vdb", cloud(width=6, depth=10))
    source = fill_box(open_volumes(str(path)))
    volume = source.volume(1)
    assert volume.shape == source.shape == (10, 10, 12)
    whole = cloud(width=6, depth=10) * np.float32(source.volumes.scale)
    np.testing.assert_array_equal(volume[2:8], whole)
    assert volume[:2].sum() == volume[8:].sum() == 0


def test_a_volume_that_grows(tmp_path):
    """A smaller one stands in the middle of the floor, a larger one is refused by its file."""
    for frame, width in ((1, 10), (2, 8), (3, 12)):
        write(tmp_path / f"a.{frame}.npz", cloud(width=width, depth=width))
    source = fill_box(open_volumes(str(tmp_path)))
    np.testing.assert_array_equal(source.volume(2)[1:9, 1:9], cloud() * np.float32(source.volumes.scale))
    with pytest.raises(ValueError, match=r"a\.3\.npz: the volume is larger than that of frame 1"):
        source.volume(3)


@pytest.mark.parametrize(("factor", "shape"), [(0.5, (4, 4, 6)), (2.0, (16, 16, 24)), (1.5, (12, 12, 18))])
def test_resolution_scale(run, factor, shape):
    """More or fewer voxels of the same picture: rays keep their sums, so it is as bright."""
    source = fill_box(open_volumes(str(run.folder)), factor)
    volume = source.volume(7)
    assert volume.shape == source.shape == shape
    before, after = (v.sum(axis=1).sum() for v in (cloud(1), volume))
    assert after / factor**2 == pytest.approx(before, rel=0.03)


def test_an_empty_box():
    """As deep as wide, without frames."""
    source = empty_box((24, 32))
    assert (source.shape, source.frames, source.volumes.name) == ((24, 24, 32), (), "")
    assert empty_box(USUAL_SIZE).shape == (96, 96, 144)
    assert empty_box((24, 32), 0.5).shape == (12, 12, 16)


@pytest.mark.parametrize(("value", "frame"), [(np.nan, 1), (np.inf, 1), (-1.0, 1), (np.nan, 2)])
def test_bad_densities(tmp_path, value, frame):
    """They are refused by their file: the first one at once, the others when they are read."""
    for number in (1, 2):
        volume = cloud()
        volume[4, 4, 4] = value if number == frame else 1
        write(tmp_path / f"a.{number}.npz", volume)
    with pytest.raises(ValueError, match=rf"a\.{frame}\.npz: the density is negative or not finite"):
        fill_box(open_volumes(str(tmp_path))).volume(2)


@pytest.mark.parametrize("kind", [".vdb", ".npz"])
def test_damaged_files(tmp_path, kind):
    """Cut off, or no volume at all; the message names the file."""
    path = write(tmp_path / f"a{kind}", cloud())
    data = path.read_bytes()
    for damage in (data[: len(data) // 2], b"", b"hello"):
        path.write_bytes(damage)
        with pytest.raises(ValueError, match=f"a{kind}"):
            fill_box(open_volumes(str(path)))


def test_a_file_without_density(tmp_path):
    """One of several other grids, or vectors, are no density."""
    grids = {name: cloud().transpose(0, 2, 1) for name in ("heat", "fuel")}
    write_vdb(tmp_path / "a.vdb", grids, voxel_size=1.0, origin=ORIGIN)
    with pytest.raises(ValueError, match=r"a\.vdb: there is no grid density, it has heat, fuel: choose one"):
        fill_box(open_volumes(str(tmp_path / "a.vdb")))
    vectors = np.ones((4, 4, 4, 3), np.float32)
    write_vdb(tmp_path / "b.vdb", {"density": vectors}, voxel_size=1.0, origin=ORIGIN)
    with pytest.raises(ValueError, match=r"b\.vdb: density has shape \(4, 4, 4, 3\), expected one number a voxel"):
        fill_box(open_volumes(str(tmp_path / "b.vdb")))


def test_whether_a_file_has_changed(run, tmp_path):
    """A run is resumed only with the volumes that it began with, wherever their folder is."""
    before = fill_box(open_volumes(str(run.folder))).volumes.hashes()
    assert before.keys() == {"7", "8"}
    shutil.copytree(run.folder, tmp_path / "moved")
    assert fill_box(open_volumes(str(tmp_path / "moved"))).volumes.hashes() == before
    run.volume_path(8).write_bytes(run.volume_path(7).read_bytes())
    after = fill_box(open_volumes(str(run.folder))).volumes.hashes()
    assert after["7"] == before["7"]
    assert after["8"] != before["8"]
