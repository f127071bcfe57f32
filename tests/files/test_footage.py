"""Footage: one front for videos and image sequences."""

import pickle

import numpy as np
import pytest

from warpfluid.files.exr import write_exr
from warpfluid.files.footage import open_footage
from warpfluid.files.images import write_png
from warpfluid.files.video import write_video


def level(frame, rows=6, columns=10):
    """Return a picture whose grey level is the frame's number."""
    return np.full((rows, columns, 3), frame, np.uint8)


def make_sequence(folder, frames):
    """Write one PNG a frame."""
    for frame in frames:
        write_png(folder / f"front.{frame:04d}.png", level(frame))
    return folder / "front.####.png"


def test_an_image_sequence_keeps_its_numbers(tmp_path):
    """Everything about the sequence is known after opening it, and frames are read by number."""
    pattern = make_sequence(tmp_path, [101, 102, 105])
    footage = open_footage(pattern)
    assert (footage.source, footage.kind, footage.depth) == (str(pattern), "images", "8 bit")
    assert (footage.frames, footage.size) == ((101, 102, 105), (10, 6))
    assert (footage.rate, footage.linear) == (None, False)
    assert [path.name for path in footage.paths] == [f"front.0{frame}.png" for frame in (101, 102, 105)]
    for frame in (105, 101, 102):
        assert np.allclose(255 * footage.read(frame), level(frame))


@pytest.mark.parametrize("first_frame", [1, 0, 1001])
def test_a_video_is_numbered_from_its_first_frame(tmp_path, first_frame):
    """Videos have no numbers of their own."""
    write_video(tmp_path / "front.mp4", [level(40 * index, 48, 64) for index in range(5)], 25)
    footage = open_footage(str(tmp_path / "front.mp4"), first_frame=first_frame)
    assert (footage.kind, footage.depth, footage.rate, footage.linear) == ("video", "8 bit", 25.0, False)
    assert (footage.size, footage.paths) == ((64, 48), (tmp_path / "front.mp4",))
    assert footage.frames == tuple(range(first_frame, first_frame + 5))
    for index in (3, 0, 4):
        assert np.allclose(255 * footage.read(first_frame + index), 40 * index, atol=3)


def test_video_has_numbers_from_one_by_default(tmp_path):
    """The first frame is frame 1."""
    write_video(tmp_path / "a.mp4", [level(0, 48, 64)] * 3, 24)
    assert open_footage(tmp_path / "a.mp4").frames == (1, 2, 3)


@pytest.mark.parametrize("kind", ["images", "video"])
def test_footage_goes_to_another_process(tmp_path, kind):
    """Workers get footage and read it themselves."""
    source = make_sequence(tmp_path, [1, 2, 3])
    if kind == "video":
        source = tmp_path / "a.mp4"
        write_video(source, [level(80 * index, 48, 64) for index in range(3)], 24)
    footage = open_footage(source)
    expected = footage.read(2)
    copy = pickle.loads(pickle.dumps(footage))
    assert copy == footage
    assert np.array_equal(copy.read(2), expected)


@pytest.mark.parametrize(
    ("frame", "nearest"), [(103, "are 102 and 105"), (1, "is 101"), (900, "is 105"), (-1, "is 101")]
)
def test_a_missing_frame_names_the_nearest(tmp_path, frame, nearest):
    """The error names the frame, those next to it and all there are."""
    footage = open_footage(make_sequence(tmp_path, [101, 102, 105]))
    with pytest.raises(ValueError, match=rf"no frame {frame}: nearest to it {nearest}, of 101-102,105"):
        footage.read(frame)


def test_exr_is_linear(tmp_path):
    """Float files hold linear light, not clipped."""
    write_exr(tmp_path / "a.1001.exr", {"RGB": np.full((4, 5, 3), 12.5)})
    footage = open_footage(tmp_path)
    assert (footage.depth, footage.linear, footage.frames) == ("float", True, (1001,))
    assert np.array_equal(footage.read(1001), np.full((4, 5, 3), 12.5, np.float32))


def test_deep_png_is_not_linear(tmp_path):
    """16-bit integers are encoded for display like 8-bit ones."""
    write_png(tmp_path / "a.1.png", np.full((4, 5), 1234, np.uint16))
    footage = open_footage(tmp_path / "a.1.png")
    assert (footage.depth, footage.linear) == ("16 bit", False)
    assert np.allclose(65535 * footage.read(1), 1234)


@pytest.mark.parametrize(("bad", "found"), [([np.nan], 3), ([np.inf, -np.inf], 6)])
def test_light_must_be_finite(tmp_path, bad, found):
    """The error names the file and how many values are wrong."""
    pixels = np.zeros((4, 5, 3))
    pixels[0, : len(bad)] = np.array(bad)[:, None]
    write_exr(tmp_path / "a.1.exr", {"RGB": np.zeros((4, 5, 3))})
    write_exr(tmp_path / "a.2.exr", {"RGB": pixels})
    footage = open_footage(tmp_path)
    footage.read(1)
    with pytest.raises(ValueError, match=rf"a\.2\.exr holds {found} values"):
        footage.read(2)


def test_all_pictures_have_one_size(tmp_path):
    """The error names the file and both sizes."""
    make_sequence(tmp_path, [1, 2])
    write_png(tmp_path / "front.0003.png", level(3, rows=7))
    footage = open_footage(tmp_path)
    footage.read(2)
    with pytest.raises(ValueError, match=r"front\.0003\.png is 10 x 7 pixels, but the first picture is 10 x 6"):
        footage.read(3)


def test_a_damaged_first_picture_shows_at_once(tmp_path):
    """Opening reads the first frame."""
    (tmp_path / "a.1.png").write_bytes(b"nothing")
    with pytest.raises(ValueError, match=r"a\.1\.png"):
        open_footage(tmp_path)


@pytest.mark.parametrize("name", ["notes.txt", "front.%04d.dpx"])
def test_other_kinds_are_refused(tmp_path, name):
    """The error lists what can be read."""
    (tmp_path / "notes.txt").touch()
    with pytest.raises(ValueError, match=rf"{name}.*\.exr.*\.mp4"):
        open_footage(tmp_path / name)


@pytest.mark.parametrize("name", ["a.mp4", "a.exr", "a.####.exr", "front"])
def test_what_is_missing_is_an_os_error(tmp_path, name):
    """The error names it."""
    with pytest.raises(FileNotFoundError, match=name.replace(".", r"\.")):
        open_footage(tmp_path / name)
