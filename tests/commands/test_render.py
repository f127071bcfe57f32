"""``warpfluid render``: runs and volumes become pictures and films."""

import json

import numpy as np
import pytest
from tiny import run

from warpfluid.cluster.here import Here
from warpfluid.commands import shooting
from warpfluid.files.images import read_image
from warpfluid.files.vdb import write_vdb
from warpfluid.files.video import Video
from warpfluid.projector import Projector
from warpfluid.rendering.ramps import apply_ramp

SMALL = ("--device", "cpu", "--resolution", "24x30")


def blob(frame=1, shape=(12, 12, 16)):
    """Return a volume (x, z, y) of two blobs that move."""
    x, z, y = np.meshgrid(*(np.linspace(-1, 1, n) for n in shape), indexing="ij")
    at = 0.1 * frame
    near = np.exp(-((x - at) ** 2 + z**2 + (y + 0.3) ** 2) * 12) + np.exp(-((x + 0.4) ** 2 + z**2 + (y - at) ** 2) * 30)
    return np.where(near > 0.05, near, 0).astype(np.float32)


@pytest.fixture
def clip(tmp_path):
    """Return the pattern of three volumes with temperature and velocity."""
    for frame in (1, 2, 3):
        density = blob(frame)
        velocity = np.stack([density * 200, density * 0, density * 0], axis=-1)
        grids = {"density": density, "temperature": density * 2, "velocity": velocity}
        write_vdb(tmp_path / f"fire.{frame:04d}.vdb", {name: grid.swapaxes(1, 2) for name, grid in grids.items()})
    return str(tmp_path / "fire.####.vdb")


def test_a_film(clip, tmp_path):
    assert run("render", clip, "-o", tmp_path / "a.mp4", "--fps", "12", *SMALL) == 0
    video = Video(tmp_path / "a.mp4")
    assert (video.count, video.rate, video.size) == (3, 12.0, (24, 30))
    frames = [video.read(k) for k in range(3)]
    assert all(frame.max() > 0.3 for frame in frames)
    assert np.abs(frames[0] - frames[2]).max() > 0.1


def test_numbered_pictures_and_their_record(clip, tmp_path, capsys):
    assert run("render", clip, "-o", tmp_path / "a.###.png", "--frames", "2-3", "--json", *SMALL) == 0
    record = json.loads(capsys.readouterr().out)
    assert [made["file"] for made in record["pictures"]] == ["a.002.png", "a.003.png"]
    assert record["failed"] == {}
    assert read_image(tmp_path / "a.003.png").shape == (30, 24, 3)
    assert not (tmp_path / "a.001.png").exists()


def test_the_sum_is_the_projectors(clip, tmp_path):
    """At any angle, a pixel a voxel, in grey levels; others' volumes are white at their brightest ray."""
    volume = blob(2)
    scale = 255 / max(blob(frame).sum(axis=1).max() for frame in (1, 2, 3))
    flags = ("--mode", "sum", "--frames", "2", "--device", "cpu", "--resolution", "12x16")
    assert run("render", clip, "-o", tmp_path / "a.exr", *flags, "--angle", "30") == 0
    projector = Projector([30.0], volume.shape, footprint="joseph")
    image = projector.project(volume * np.float32(scale))[0].T[::-1]
    np.testing.assert_allclose(read_image(tmp_path / "a.exr")[..., 0] * 255, image, rtol=2e-5, atol=1e-3)
    assert run("render", clip, "-o", tmp_path / "a.png", *flags, "--angle", "30", "--look", "jet") == 0
    shown = read_image(tmp_path / "a.png") * 255
    assert np.abs(shown - apply_ramp(image, "jet").astype(float)).max() <= 3


@pytest.mark.parametrize("look", ["fire", "smoke", "explosion", "blackbody", "water", "jet", "gray"])
def test_every_look_makes_a_picture(clip, tmp_path, look):
    assert run("render", clip, "-o", tmp_path / "a.png", "--frames", "1", "--look", look, *SMALL) == 0
    picture = read_image(tmp_path / "a.png")
    assert picture.max() > 0.2
    assert picture[0, 0].max() == 0


def test_what_stands_in_is_said_of_a_chosen_look_only(clip, tmp_path, capsys):
    """Or to who asks for more words: a run's own look without its field is the usual case."""
    picture = ("render", clip, "-o", tmp_path / "a.png", "--frames", "1", *SMALL)
    assert run(*picture) == 0
    assert "stands in" not in capsys.readouterr().err
    assert run(*picture, "-v", "--overwrite") == 0
    assert "wants flame" in capsys.readouterr().err


def test_what_stands_in_is_said(clip, tmp_path, capsys):
    assert run("render", clip, "-o", tmp_path / "a.png", "--frames", "1", "--look", "fire", *SMALL) == 0
    assert "the emission of fire wants flame, which is not there" in capsys.readouterr().err


def test_a_turntable_of_one_frame(clip, tmp_path):
    flags = ("--frames", "1", "--turntable", "4", "--look", "smoke", "--ambient", "1", "--key-strength", "0")
    assert run("render", clip, "-o", tmp_path / "a.#.png", *flags, *SMALL, "--projection", "orthographic") == 0
    pictures = [read_image(tmp_path / f"a.{k}.png") for k in (1, 2, 3, 4)]
    assert np.abs(pictures[0] - pictures[1]).max() > 0.1
    np.testing.assert_allclose(pictures[0], pictures[2][:, ::-1], atol=0.35)


def test_keyed_camera(clip, tmp_path):
    """A key at each frame is that constant."""
    assert run("render", clip, "-o", tmp_path / "a.#.png", "--angle", "1:0;3:60", "--frames", "2", *SMALL) == 0
    assert run("render", clip, "-o", tmp_path / "b.#.png", "--angle", "30", "--frames", "2", *SMALL) == 0
    np.testing.assert_array_equal(read_image(tmp_path / "a.2.png"), read_image(tmp_path / "b.2.png"))


def test_a_camera_file(clip, tmp_path):
    keys = [{"frame": 1, "angle": 0, "target": [0, 5, 0]}, {"frame": 3, "angle": 60, "target": [1, 5, 0]}]
    (tmp_path / "path.json").write_text(json.dumps(keys))
    flags = ("--frames", "2", *SMALL)
    assert run("render", clip, "-o", tmp_path / "a.png", "--camera", tmp_path / "path.json", *flags) == 0
    assert run("render", clip, "-o", tmp_path / "b.png", "--angle", "30", "--target", "0.5,5,0", *flags) == 0
    np.testing.assert_array_equal(read_image(tmp_path / "a.png"), read_image(tmp_path / "b.png"))


def test_motion_blur(clip, tmp_path):
    """It moves along x at some 8 voxels a frame where it is dense: the picture is smeared that way."""
    flags = ("--frames", "2", "--mode", "sum", "--device", "cpu", "--resolution", "12x16")
    assert run("render", clip, "-o", tmp_path / "a.exr", *flags) == 0
    assert run("render", clip, "-o", tmp_path / "b.exr", *flags, "--motion-blur", "1", "--fps", "9") == 0
    sharp, blurred = (read_image(tmp_path / name)[..., 0] for name in ("a.exr", "b.exr"))
    np.testing.assert_allclose(blurred.sum(), sharp.sum(), rtol=0.25)
    across, along = (np.abs(np.diff(blurred, axis=a)).sum() / np.abs(np.diff(sharp, axis=a)).sum() for a in (0, 1))
    assert along < across - 0.05


def test_stereo(clip, tmp_path):
    flags = ("--frames", "1", "--look", "smoke", "--eye-distance", "3")
    assert run("render", clip, "-o", tmp_path / "a.exr", *flags, *SMALL, "--stereo", "separate") == 0
    left, right = (read_image(tmp_path / f"a.{eye}.exr") for eye in ("left", "right"))
    assert np.abs(left - right).max() > 0.01
    flags = (*flags, "--stereo", "side-by-side", "--resolution", "48x30", "--device", "cpu")
    assert run("render", clip, "-o", tmp_path / "b.exr", *flags) == 0
    np.testing.assert_array_equal(read_image(tmp_path / "b.exr"), np.concatenate([left, right], axis=1))


def test_resume_makes_what_is_missing(clip, tmp_path, capsys):
    pattern = tmp_path / "a.#.png"
    assert run("render", clip, "-o", pattern, *SMALL) == 0
    kept, gone = tmp_path / "a.1.png", tmp_path / "a.2.png"
    before, age = gone.read_bytes(), kept.stat().st_mtime_ns
    gone.unlink()
    assert run("render", clip, "-o", pattern, *SMALL) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert run("render", clip, "-o", pattern, "--resume", *SMALL) == 0
    assert "3 of 3 pictures" in capsys.readouterr().out
    assert gone.read_bytes() == before
    assert kept.stat().st_mtime_ns == age


@pytest.mark.parametrize("damaged", [2, 3])
def test_a_damaged_frame_is_named_and_the_others_are_made(clip, tmp_path, capsys, damaged):
    path = tmp_path / f"fire.000{damaged}.vdb"
    path.write_bytes(path.read_bytes()[:300])
    assert run("render", clip, "-o", tmp_path / "a.#.png", *SMALL) == 1
    assert f"picture {damaged}: " in capsys.readouterr().err
    assert [(tmp_path / f"a.{k}.png").exists() for k in (1, 2, 3)] == [k != damaged for k in (1, 2, 3)]
    assert run("render", clip, "-o", tmp_path / "a.mp4", *SMALL) == 1
    assert Video(tmp_path / "a.mp4").count == 2


@pytest.mark.parametrize("shape", [(1, 1, 1), (3, 5, 7), (9, 2, 1)])
@pytest.mark.parametrize("look", ["fire", "smoke"])
def test_odd_boxes(tmp_path, shape, look):
    write_vdb(tmp_path / "a.0001.vdb", {"density": np.ones(shape, np.float32)})
    assert run("render", tmp_path / "a.0001.vdb", "-o", tmp_path / "a.png", "--look", look, *SMALL) == 0
    assert read_image(tmp_path / "a.png").max() > 0


@pytest.mark.parametrize("mode", ["lit", "emission", "sum"])
def test_an_empty_volume_shows_what_is_behind(tmp_path, mode):
    write_vdb(tmp_path / "a.0001.vdb", {"density": np.zeros((8, 8, 8), np.float32)})
    flags = ("--look", "smoke", "--mode", mode, "--backdrop", "0.2,0.4,0.6", *SMALL)
    assert run("render", tmp_path / "a.0001.vdb", "-o", tmp_path / "a.png", *flags) == 0
    behind = (0, 0, 0) if mode == "sum" else (0.2, 0.4, 0.6)
    np.testing.assert_allclose(read_image(tmp_path / "a.png"), np.broadcast_to(behind, (30, 24, 3)), atol=1e-6)


def test_a_look_of_ones_own(clip, tmp_path):
    look = {"emission": {"input": {"temperature": 2}, "stops": [[0, 0], [1, [0, 0, 9]]]}}
    (tmp_path / "blue.json").write_text(json.dumps(look))
    flags = ("--frames", "1", "--look", tmp_path / "blue.json", "--rolloff", "1")
    assert run("render", clip, "-o", tmp_path / "a.png", *flags, *SMALL) == 0
    picture = read_image(tmp_path / "a.png")
    assert picture[..., 2].max() > 0.3
    assert picture[..., :2].max() == 0


def test_the_folder_is_made(clip, tmp_path):
    """As the folders of runs and exports are."""
    assert run("render", clip, "-o", tmp_path / "new" / "deep" / "a.png", "--frames", "1", *SMALL) == 0
    assert (tmp_path / "new" / "deep" / "a.png").is_file()


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (("--frames", "9"), "frames 9 are not there"),
        (("-o", "mine.json/a.png"), "cannot be a folder, there is a file"),
        (("-o", "a.tif"), "unknown kind"),
        (("-o", "all.png"), "is one picture, and there are 3"),
        (("-o", "a.mp4", "--resume"), "a film is written in one piece"),
        (("-o", "a.##.png", "--resume", "--overwrite"), "choose one of them"),
        (("--look", "fier"), "look is 'fier'"),
        (("--look", "none.json"), "none.json does not exist"),
        (("--mode", "sum", "--look", "mine.json"), "but the mode sum knows fire"),
        (("--resolution", "960"), "expected WIDTHxHEIGHT"),
        (("--elevation", "91"), "elevation is 91, expected -90 to 90"),
        (("--key-color", "red"), "key-color is 'red', expected three numbers"),
        (("--probe", "none.exr"), "none.exr"),
        (("--camera", "none.json"), "none.json does not exist"),
        (("--camera", "mine.json"), "mine.json holds no list of keys"),
    ],
)
def test_wrong_commands_are_refused_before_any_work(clip, tmp_path, monkeypatch, capsys, flags, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.json").write_text('{"opacity": {"stops": [[0, 1]]}}')
    out = () if "-o" in flags else ("-o", "a.##.png")
    assert run("render", clip, *out, *flags, "--device", "cpu") == 2
    assert words in capsys.readouterr().err
    assert not list(tmp_path.glob("a.*png"))


def test_motion_blur_wants_velocity(tmp_path, capsys):
    write_vdb(tmp_path / "a.0001.vdb", {"density": np.ones((4, 4, 4), np.float32)})
    assert run("render", tmp_path / "a.0001.vdb", "-o", tmp_path / "a.png", "--motion-blur", "0.5") == 2
    assert "needs velocity" in capsys.readouterr().err


def test_no_place_for_the_pictures(clip, capsys):
    assert run("render", clip) == 2
    assert "add -o film.mp4" in capsys.readouterr().err


@pytest.mark.parametrize("flags", [(), ("--turntable", "4", "--look", "smoke", "--stereo", "separate")])
def test_two_processes_make_the_bits_of_one(clip, tmp_path, flags, capsys):
    """Of numbered pictures, and of films."""
    (tmp_path / "one").mkdir()
    (tmp_path / "two").mkdir()
    assert run("render", clip, "-o", tmp_path / "one" / "a.#.png", *flags, *SMALL) == 0
    assert run("render", clip, "-o", tmp_path / "two" / "a.#.png", *flags, *SMALL, "--jobs", "2") == 0
    assert "2 processes" in capsys.readouterr().err
    one, two = (
        {p.name: p.read_bytes() for p in (tmp_path / name).iterdir() if p.suffix == ".png"} for name in ("one", "two")
    )
    assert one == two
    if not flags:
        for name, jobs in (("one", "1"), ("two", "2")):
            assert run("render", clip, "-o", tmp_path / name / "a.webp", *SMALL, "--jobs", jobs) == 0
        assert (tmp_path / "one" / "a.webp").read_bytes() == (tmp_path / "two" / "a.webp").read_bytes()


def test_resume_refuses_pictures_of_another_kind(clip, tmp_path, capsys):
    """Other options are named; a frame whose volume has changed since is made again; strangers are, too."""
    pattern = tmp_path / "a.#.png"
    assert run("render", clip, "-o", pattern, "--frames", "1-2", *SMALL) == 0
    before = {k: (tmp_path / f"a.{k}.png").stat().st_mtime_ns for k in (1, 2)}
    assert run("render", clip, "-o", pattern, "--resume", *SMALL, "--angle", "30", "--exposure", "1") == 2
    message = capsys.readouterr().err
    assert "angle (was 0.0, now 30.0)" in message
    assert "exposure (was 0.0, now 1.0)" in message
    density = blob(7)
    write_vdb(tmp_path / "fire.0002.vdb", {"density": density.swapaxes(1, 2)})
    (tmp_path / "a.3.png").write_bytes(b"of another program")
    assert run("render", clip, "-o", pattern, "--resume", *SMALL) == 0
    assert "kept    1 pictures" in capsys.readouterr().err
    assert (tmp_path / "a.1.png").stat().st_mtime_ns == before[1]
    assert (tmp_path / "a.2.png").stat().st_mtime_ns != before[2]
    assert read_image(tmp_path / "a.3.png").max() > 0.1


def test_resume_needs_the_record(clip, tmp_path, capsys):
    """Pictures that nobody can tell the origin of are not taken, and not replaced unasked."""
    (tmp_path / "a.3.png").write_bytes(b"of another program")
    assert run("render", clip, "-o", tmp_path / "a.#.png", "--resume", *SMALL) == 2
    assert "no record of what its pictures were made with, a.png.jsonl" in capsys.readouterr().err
    assert (tmp_path / "a.3.png").read_bytes() == b"of another program"


def test_resume_after_half_a_line(clip, tmp_path):
    """A picture whose record was not finished is made again; of the others nothing is lost."""
    pattern = tmp_path / "a.#.png"
    assert run("render", clip, "-o", pattern, *SMALL) == 0
    record = tmp_path / "a.png.jsonl"
    record.write_bytes(record.read_bytes()[:-30])
    before = {k: (tmp_path / f"a.{k}.png").read_bytes() for k in (1, 2, 3)}
    times = [(tmp_path / f"a.{k}.png").stat().st_mtime_ns for k in (1, 2)]
    assert run("render", clip, "-o", pattern, "--resume", *SMALL) == 0
    assert [(tmp_path / f"a.{k}.png").stat().st_mtime_ns for k in (1, 2)] == times
    assert {k: (tmp_path / f"a.{k}.png").read_bytes() for k in (1, 2, 3)} == before
    assert len(record.read_text().splitlines()) == 4


class Leaving(Here):
    """A pool whose workers are gone after the first picture."""

    left = 1

    def wait(self):
        if self.left == 0:
            raise ConnectionError("the scheduler is gone")
        self.left -= 1
        return super().wait()


def test_a_cluster_that_is_lost(clip, tmp_path, monkeypatch, capsys):
    """What was made counts, what was not is named, and --resume makes it; half a film is none."""
    with monkeypatch.context() as patch:
        patch.setattr(shooting, "open_pool", lambda job, crew, device, **_: Leaving(job, device, None))
        assert run("render", clip, "-o", tmp_path / "a.#.png", *SMALL) == 1
        message = capsys.readouterr().err
        assert "the cluster: the scheduler is gone" in message
        assert "the other pictures: not made" in message
        assert run("render", clip, "-o", tmp_path / "a.mp4", *SMALL) == 1
        message = capsys.readouterr().err
        assert "the cluster: the scheduler is gone" in message
        assert "a.mp4: not made" in message
        assert not (tmp_path / "a.mp4").exists()
    assert run("render", clip, "-o", tmp_path / "a.#.png", *SMALL, "--resume") == 0
    assert "kept    1 pictures" in capsys.readouterr().err
