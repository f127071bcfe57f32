"""What an export writes, and how it is continued, replaced and refused."""

import json
from pathlib import Path

import numpy as np
import pytest
from tiny import run

from warpfluid.files.grids import GridFile
from warpfluid.files.npz import read_npz_grids
from warpfluid.files.nvdb import read_nvdb
from warpfluid.files.vdb import read_vdb, write_vdb
from warpfluid.files.vti import read_vti
from warpfluid.volumes import open_volumes

READERS = {"vdb": read_vdb, "nvdb": read_nvdb, "vti": read_vti, "npz": read_npz_grids}
SHAPE, SIZE, ORIGIN = (9, 12, 7), 0.25, (-1.0, 0.125, -0.75)


def frame_of(number: int) -> dict[str, np.ndarray]:
    """Return the grids of a frame: a blob that rises, and its velocity; nothing is lit at the rim."""
    density = np.zeros(SHAPE, np.float32)
    density[2:6, 1 + number : 4 + number, 3:5] = np.random.default_rng(number).uniform(1, 2, (4, 3, 2))
    return {"density": density, "velocity": np.stack([density, 2 * density, -density], axis=-1), "heat": 3 * density}


@pytest.fixture
def source(tmp_path) -> Path:
    """Three frames as another program writes them."""
    folder = tmp_path / "source"
    folder.mkdir()
    for number in (1, 2, 3):
        write_vdb(folder / f"plume.{number:04d}.vdb", frame_of(number), voxel_size=SIZE, origin=ORIGIN)
    return folder


def seen(file: GridFile) -> dict[str, dict]:
    """Return the values that are not 0 of each grid, by their place in the world."""
    found = {}
    for name, grid in file.grids.items():
        lit = np.argwhere(grid.any(-1) if grid.ndim == 4 else grid)
        places = np.round(np.asarray(file.origin) + file.voxel_size * lit, 6)
        found[name] = {tuple(p): grid[tuple(i)].tolist() for p, i in zip(places.tolist(), lit, strict=True)}
    return found


def original(number: int, factor: float = 1.0) -> dict[str, dict]:
    """Return the same of the source, with voxels of another size."""
    grids = {n: g * np.float32(factor) if n == "velocity" else g for n, g in frame_of(number).items()}
    origin = tuple(factor * place for place in ORIGIN)
    return seen(GridFile(grids=grids, voxel_size=factor * SIZE, origin=origin, metadata={}))


@pytest.mark.parametrize("crop", [[], ["--crop"]])
@pytest.mark.parametrize("form", READERS)
def test_every_format_keeps_values_and_places(tmp_path, source, form, crop):
    """Cropped or whole, each voxel has its value at its place in the world."""
    assert run("export", source, "-o", tmp_path / "out", "--format", form, *crop, "-q") == 0
    for number in (1, 2, 3):
        file = READERS[form](tmp_path / "out" / f"density.{number:04d}.{form}")
        assert seen(file) == original(number)
        if crop and form in ("vti", "npz"):
            assert file.grids["density"].shape == (4, 5, 2)  # what is lit in any frame


@pytest.mark.parametrize("form", ["vdb", "nvdb", "vti"])
def test_z_up(tmp_path, source, form):
    """(x, y, z) becomes (x, -z, y), places and vectors alike; read as z up it is the source again."""
    assert run("export", source, "-o", tmp_path / "out", "--format", form, "--up", "z", "-q") == 0
    if form != "vti":
        raw = READERS[form](tmp_path / "out" / f"density.0002.{form}", up="z")
        assert seen(raw) == original(2)
    assert seen(open_volumes(tmp_path / "out", unchecked=True).read(2)) == original(2)  # export.json tells the axis
    (tmp_path / "out" / "export.json").unlink()
    assert seen(open_volumes(tmp_path / "out", up="z", unchecked=True).read(2)) == original(2)


def test_the_look_goes_along(tmp_path):
    """Exported smoke is shown as smoke, not as fire."""
    flags = ("--size", "12x16", "--emitter", "sphere radius=1", "--look", "smoke", "--frames", "1-2", "--no-turntable")
    assert run("simulate", *flags, "--no-report", "--device", "cpu", "-q", "-o", tmp_path / "run") == 0
    assert run("export", tmp_path / "run", "-o", tmp_path / "out", "-q") == 0
    assert open_volumes(tmp_path / "out", unchecked=True).output.look == "smoke"


def test_half(tmp_path, source):
    """Three digits are kept, in .vdb and .npz alike."""
    for form in ("vdb", "npz"):
        assert run("export", source, "-o", tmp_path / form, "--format", form, "--half", "--frames", "2", "-q") == 0
        found = READERS[form](tmp_path / form / f"density.0002.{form}").grids["density"]
        np.testing.assert_array_equal(found, frame_of(2)["density"].astype(np.float16))
    assert run("export", source, "-o", tmp_path / "no", "--format", "vti", "--half") == 2


def test_names_units_and_a_threshold(tmp_path, source, capsys):
    """Chosen grids, Houdini's name, larger voxels, another unit; what is dropped is told."""
    flags = ["--grids", "density,velocity", "--velocity-name", "vel", "--voxel-size", "0.5", "--density-scale", "10"]
    assert run("export", source, "-o", tmp_path / "out", *flags, "--drop-below", "0.8", "--json") == 0
    told = json.loads(capsys.readouterr().out)
    file = read_vdb(tmp_path / "out" / "density.0001.vdb")
    assert list(file.grids) == ["density", "vel"]
    assert file.voxel_size == 0.5
    np.testing.assert_allclose(file.origin, np.multiply(2, ORIGIN))
    density = frame_of(1)["density"]
    kept = np.where(density > 0.8 * density.max(), density, 0)
    np.testing.assert_allclose(file.grids["density"], 10 * kept, rtol=1e-6)
    np.testing.assert_array_equal(file.grids["vel"], 2 * frame_of(1)["velocity"])
    assert told["frames"]["1"]["mass_dropped"] == pytest.approx(1 - kept.sum() / density.sum(), rel=1e-5)


@pytest.mark.parametrize("damage", [lambda data: data[:-1], lambda data: data[:300] + b"!" + data[301:], lambda _: b""])
def test_damaged_files_are_written_again(tmp_path, source, damage):
    """Cut or changed anywhere; and a damaged record is named."""
    out = tmp_path / "out"
    assert run("export", source, "-o", out, "-q") == 0
    path = out / "density.0002.vdb"
    whole = path.read_bytes()
    path.write_bytes(damage(whole))
    assert run("export", source, "-o", out, "--resume", "-q") == 0
    assert path.read_bytes() == whole


@pytest.mark.parametrize(("old", "new"), [("density.0002", "../stray"), ("shape", "shepe"), ("0.25", "0.26")])
def test_a_damaged_record_is_named(tmp_path, source, capsys, old, new):
    """Nothing is deleted that it names, and nothing is taken from it."""
    (tmp_path / "stray.vdb").touch()
    out = tmp_path / "out"
    assert run("export", source, "-o", out, "-q") == 0
    text = (out / "export.json").read_text()
    assert old in text
    (out / "export.json").write_text(text.replace(old, new))
    for flag in ("--resume", "--overwrite"):
        assert run("export", source, "-o", out, flag, "-q") == 2
        assert "export.json is damaged" in capsys.readouterr().err
    assert (tmp_path / "stray.vdb").exists()


def test_going_on(tmp_path, source, capsys):
    """Frames that are there are kept, unless their source has changed; other choices are refused."""
    out = tmp_path / "out"
    assert run("export", source, "-o", out, "--frames", "1-2", "-q") == 0
    first, second = ((out / f"density.000{n}.vdb") for n in (1, 2))
    times = first.stat().st_mtime_ns, second.stat().st_mtime_ns
    write_vdb(source / "plume.0002.vdb", frame_of(5), voxel_size=SIZE, origin=ORIGIN)
    capsys.readouterr()
    assert run("export", source, "-o", out) == 2
    assert "holds volumes already: go on with --resume, or replace them with --overwrite" in capsys.readouterr().err
    assert run("export", source, "-o", out, "--resume") == 0
    assert "resume  1 of 3 frames are there" in capsys.readouterr().err
    assert first.stat().st_mtime_ns == times[0]
    assert second.stat().st_mtime_ns != times[1]
    assert sorted(json.loads((out / "export.json").read_text())["frames"]) == ["1", "2", "3"]
    assert run("export", source, "-o", out, "--resume", "--half") == 2
    assert "was exported otherwise: half (was False, now True)" in capsys.readouterr().err
    assert run("export", source, "-o", out, "--overwrite", "--half", "--frames", "3", "-q") == 0
    assert sorted(path.name for path in out.iterdir()) == ["density.0003.vdb", "export.json"]


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (["--frames", "3-5"], "lacks frame 4-5 (it has 1-3): choose with --frames"),
        (["--format", "npz", "--up", "z"], "up is z, but .npz volumes are y up always"),
        (["--format", "nvdb", "--half"], "half is for vdb, usda, blender and npz"),
        (["--plain"], "plain is for nvdb"),
        (["--resume", "--overwrite"], "choose one of them"),
        (["--grid", "smoke"], "there is no grid smoke, it has density, heat, velocity"),
        (["--drop-below", "2"], "drop-below is 2, expected 0 to 1"),
    ],
)
def test_what_is_refused(tmp_path, source, capsys, flags, message):
    """Before anything is written."""
    assert run("export", source, "-o", tmp_path / "out", *flags) == 2
    error = capsys.readouterr().err
    assert message in error or message.replace("density, heat, velocity", "density, velocity, heat") in error
    assert not (tmp_path / "out").exists()


def test_the_source_is_never_overwritten(tmp_path, source, capsys):
    """Neither foreign volumes nor a run."""
    before = {path.name: path.read_bytes() for path in source.iterdir()}
    assert run("export", source, "-o", source, "--overwrite") == 2
    assert run("export", source / "plume.####.vdb", "-o", source, "--overwrite") == 2
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "run.toml").touch()
    assert run("export", source, "-o", tmp_path / "run", "--overwrite") == 2
    assert "choose another folder with -o" in capsys.readouterr().err
    assert before == {path.name: path.read_bytes() for path in source.iterdir()}


@pytest.mark.parametrize("form", READERS)
def test_nothing_and_one_voxel(tmp_path, form):
    """An empty volume and a single voxel are volumes like others."""
    one = np.zeros((5, 3, 4), np.float32)
    write_vdb(tmp_path / "a.1.vdb", {"density": one}, voxel_size=0.5)
    one[4, 0, 2] = 7
    write_vdb(tmp_path / "a.2.vdb", {"density": one}, voxel_size=0.5)
    for crop in ([], ["--crop"]):
        out = tmp_path / f"out{len(crop)}"
        assert run("export", tmp_path / "a.#.vdb", "-o", out, "--format", form, *crop, "-q") == 0
        empty, single = (READERS[form](out / f"density.000{n}.{form}") for n in (1, 2))
        assert seen(empty)["density"] == {}
        assert seen(single)["density"] == {(2.0, 0.0, 1.0): 7.0}


def test_a_repaired_frame_is_told(tmp_path, capsys):
    """NaN in a vector counts once a voxel; a negative density is no number either."""
    grids = frame_of(1)
    np.savez(tmp_path / "a.1.npz", **{n: g.copy() for n, g in grids.items()}, voxel_size=SIZE)
    grids["density"][0, 0, 0], grids["velocity"][1, 1, 1] = -1, np.nan
    np.savez(tmp_path / "a.2.npz", **grids, voxel_size=SIZE)
    assert run("export", tmp_path / "a.#.npz", "-o", tmp_path / "out", "--json") == 1
    failed = json.loads(capsys.readouterr().out)["failed"]
    assert "density is negative or not finite in 1 of 756 voxels: write 0 there with --repair" in failed["frame 2"]
    assert run("export", tmp_path / "a.#.npz", "-o", tmp_path / "all", "--repair", "--json") == 0
    told = json.loads(capsys.readouterr().out)["frames"]
    assert told["2"]["repaired"] == {"density": 1, "velocity": 1}
    assert "repaired" not in told["1"]
    assert read_vdb(tmp_path / "all" / "density.0002.vdb").grids["velocity"][1, 1, 1].tolist() == [0, 0, 0]
