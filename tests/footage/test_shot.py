"""A shot: footage paired by frame, and everything that is wrong told at once."""

import numpy as np
import pytest

from warpfluid.files.images import write_png
from warpfluid.files.video import write_video
from warpfluid.footage.shot import open_shot
from warpfluid.options import InputOptions


def picture(seed=0, width=16, height=12):
    """Grey light on black, uint8 (rows, columns, 3)."""
    grey = np.zeros((height, width), np.uint8)
    grey[2:-2, 3:-3] = np.random.default_rng(seed).integers(50, 250, (height - 4, width - 6))
    return np.repeat(grey[..., None], 3, axis=2)


def sequence(folder, frames, make=picture):
    """Write a picture a frame and return the folder's name."""
    folder.mkdir()
    for frame in frames:
        write_png(folder / f"fire.{frame:04d}.png", make(frame))
    return str(folder)


@pytest.fixture
def pair(tmp_path):
    """Return a front and a side of five frames."""
    front = sequence(tmp_path / "front", range(11, 16))
    side = sequence(tmp_path / "side", range(11, 16), lambda frame: picture(frame + 50))
    return [f"0={front}", f"90={side}"]


def refusal(views, **options):
    """Return the message with which a shot is refused."""
    with pytest.raises(ValueError, match=r".") as error:
        open_shot(views, InputOptions(**options))
    return str(error.value)


def test_images_are_the_pictures_turned(pair):
    """Without row equalisation the images are the files' pictures, v up."""
    shot = open_shot(pair, InputOptions(equalize_rows=False))
    assert shot.frames == (11, 12, 13, 14, 15)
    assert shot.size == (16, 12)
    assert shot.angles_deg == (0, 90)
    views = shot.views(12)
    np.testing.assert_allclose(views.pictures()[0], picture(12)[..., 0], atol=1e-3)
    np.testing.assert_allclose(views.pictures()[1], picture(62)[..., 0], atol=1e-3)


def test_rows_are_made_equal(pair):
    """By default every view has the same light in each row, and inspect can still see the raw ones."""
    shot = open_shot(pair)
    sums = shot.views(11).row_sums()
    np.testing.assert_allclose(sums[0], sums[1], rtol=1e-5)
    raw = shot.views(11, equalize_rows=False).row_sums()
    assert not np.allclose(raw[0], raw[1])


def test_pairs_of_angle_and_path(pair):
    """Python callers give angles as numbers."""
    shot = open_shot([(0, pair[0][2:]), (45.5, pair[1][3:])])
    assert shot.angles_deg == (0, 45.5)
    assert shot.sources[1].name.startswith("45.5=")


def test_frames_that_are_asked_for(pair):
    """Only those, in order."""
    assert open_shot(pair, InputOptions(frames="15,11-12")).frames == (11, 12, 15)
    message = refusal(pair, frames="15-17")
    assert message.count("lacks frame 16-17") == len(message.splitlines()) == 2  # a line a view
    with pytest.raises(ValueError, match="no frame 99"):
        open_shot(pair, InputOptions(frames="11")).views(99)


def test_unequal_lengths_are_noted(tmp_path):
    """The common frames are used and the user is told."""
    front, side = sequence(tmp_path / "a", range(1, 9)), sequence(tmp_path / "b", range(3, 7))
    shot = open_shot([f"0={front}", f"90={side}"])
    assert shot.frames == (3, 4, 5, 6)
    assert any("1-8" in note and "3-6" in note for note in shot.notes)


def test_a_hole_is_an_error(tmp_path):
    """A missing frame is named with its view, not skipped; a sequence on twos has no holes."""
    front = sequence(tmp_path / "a", [1, 2, 3, 4, 5])
    side = sequence(tmp_path / "b", [1, 2, 5])
    message = refusal([f"0={front}", f"90={side}"])
    assert f"90={side} lacks frame 3-4" in message
    assert "--frames" in message
    assert "lacks frame 3-4" in refusal([f"0={side}"])
    assert open_shot([f"0={front}", f"90={side}"], InputOptions(frames="1-2")).frames == (1, 2)
    assert open_shot([f"0={sequence(tmp_path / 'twos', [1, 3, 5])}"]).frames == (1, 3, 5)


def test_no_common_frame(tmp_path):
    """The error shows what frames each view has."""
    front, side = sequence(tmp_path / "a", [1, 2]), sequence(tmp_path / "b", [7, 8])
    message = refusal([f"0={front}", f"90={side}"])
    assert "no frame in common" in message
    assert "7-8" in message


def test_a_video_starts_where_the_sequence_does(tmp_path):
    """A video's second picture goes with the sequence's second file."""
    front = sequence(tmp_path / "a", range(1001, 1005))
    write_video(tmp_path / "side.mp4", [picture(frame) for frame in range(1001, 1005)], 24)
    shot = open_shot([f"0={front}", f"90={tmp_path / 'side.mp4'}"], InputOptions(equalize_rows=False))
    assert shot.frames == (1001, 1002, 1003, 1004)
    assert shot.rate == 24
    assert any("1001" in note for note in shot.notes)
    images = shot.views(1003).images
    assert np.abs(images[0] - images[1]).mean() < 12  # the video's compression


def test_single_pictures_are_one_frame(tmp_path):
    """Two stills belong together whatever numbers their names end in."""
    for angle in (0, 90):
        write_png(tmp_path / f"angle{angle:03d}.png", picture(angle))
    shot = open_shot([f"{angle}={tmp_path / f'angle{angle:03d}.png'}" for angle in (0, 90)])
    assert len(shot.frames) == 1
    assert shot.views(shot.frames[0]).images.shape == (2, 16, 12)


def test_resolution_and_crop(pair):
    """A width keeps the proportions, both may change them with a note, and a crop is cut first."""
    assert open_shot(pair, InputOptions(resolution="12")).size == (12, 9)
    shot = open_shot(pair, InputOptions(resolution="8x12"))
    assert shot.size == (8, 12)
    assert any("proportions" in note for note in shot.notes)
    shot = open_shot(pair, InputOptions(crop="10x9+3+2", equalize_rows=False))
    np.testing.assert_allclose(shot.views(11).pictures()[0], picture(11)[2:11, 3:13, 0], atol=1e-3)
    assert "does not fit" in refusal(pair, crop="10x9+8+2")
    assert "only ever reduced" in refusal(pair, resolution="17")
    assert "8 pixels or more" in refusal(pair, resolution="8x6")
    assert "at least 8 x 8" in refusal(pair, crop="10x6+0+0")


def test_unlike_sizes_can_be_made_equal(pair, tmp_path):
    """The error names the ways out, and one of them works."""
    wide = sequence(tmp_path / "wide", range(11, 16), lambda frame: picture(frame, width=32, height=24))
    message = refusal([pair[0], f"90={wide}"])
    assert "16 x 12" in message
    assert "32 x 24" in message
    assert "--resolution or --crop" in message
    assert open_shot([pair[0], f"90={wide}"], InputOptions(resolution="16")).size == (16, 12)


def test_backgrounds(tmp_path):
    """A picture or the median takes the set off and leaves what moves."""

    def scene(frame):
        grey = np.full((12, 16), 60, np.uint8)
        grey[4:7, 2 * (frame % 6) : 2 * (frame % 6) + 2] = 160
        return grey

    folder = sequence(tmp_path / "a", range(1, 7), scene)
    write_png(tmp_path / "plate.png", np.full((12, 16), 60, np.uint8))
    for background in ("median", str(tmp_path / "plate.png")):
        image = open_shot([f"0={folder}"], InputOptions(background=background)).views(2).images[0]
        assert image[4, 6] == pytest.approx(100, abs=0.01)
        assert image.sum() == pytest.approx(600, abs=1)
    assert "at least 3 frames" in refusal([f"0={folder}"], background="median", frames="1")
    write_png(tmp_path / "small.png", np.zeros((8, 8), np.uint8))
    assert "same size" in refusal([f"0={folder}"], background=str(tmp_path / "small.png"))
    assert "nothing.png" in refusal([f"0={folder}"], background=str(tmp_path / "nothing.png"))


def test_float_footage_has_one_white(tmp_path):
    """The brightest pixel of all views and frames is 255, and no tone curve is undone: floats are linear."""
    from warpfluid.files.exr import write_exr

    for name, brightest in (("a", 3.0), ("b", 7.5)):
        (tmp_path / name).mkdir()
        for frame in (1, 2):
            light = picture(frame)[..., 0].astype(np.float32)
            light *= brightest * frame / 2 / light.max()
            write_exr(tmp_path / name / f"{frame:03d}.exr", {"Y": light})
    views = [f"0={tmp_path / 'a'}", f"90={tmp_path / 'b'}"]
    shot = open_shot(views, InputOptions(equalize_rows=False, decode="srgb"))
    assert shot.views(2).images.max(axis=(1, 2)) == pytest.approx([255 * 3 / 7.5, 255], rel=1e-3)
    assert shot.views(1).images.max() == pytest.approx(127.5, rel=1e-3)
    fixed = open_shot(views, InputOptions(equalize_rows=False, white=15.0))
    assert fixed.views(2).images.max() == pytest.approx(127.5, rel=1e-3)


def test_black_frames_are_legal_but_not_a_black_shot(tmp_path):
    """Fire may begin later; footage without any light is refused."""
    late = sequence(tmp_path / "a", range(1, 4), lambda frame: picture(frame) * (frame > 2))
    assert open_shot([f"0={late}"]).views(1).images.max() == 0
    black = sequence(tmp_path / "b", range(1, 4), lambda frame: picture(frame) * 0)
    assert "black in every frame" in refusal([f"0={black}"])
    white = sequence(tmp_path / "c", range(1, 4), lambda frame: picture(frame) * 0 + 255)
    message = refusal([f"0={white}"])
    assert "--background" in message
    assert "--black-level" in message


def test_everything_wrong_is_told_at_once(pair, tmp_path):
    """One error, a line for each mistake."""
    views = [*pair, pair[0].replace("0=", "180=", 1), "side=x.mp4", f"30={tmp_path / 'gone.mp4'}", "45"]
    lines = refusal(views, resolution="big", crop="all", frames="x", white=-1)
    expected = (
        "180 degrees apart",
        "'side=x.mp4' is not ANGLE=PATH",
        "gone.mp4",
        "'45' is not",
        "--resolution",
    )
    for words in (*expected, "--crop", "frames 'x'", "--white -1"):
        assert sum(words in line for line in lines.splitlines()) == 1, words
    assert "there is no view" in refusal([])
    assert "above 1" in refusal(pair, white=200.0)


def test_hashes_tell_footage_apart(pair, tmp_path):
    """The same files hash alike, and one changed pixel shows."""
    before = {frame: open_shot(pair).hashes(frame) for frame in (12, 13)}
    assert {frame: open_shot(pair).hashes(frame) for frame in (12, 13)} == before
    assert len(set(before[12].values())) == 2
    changed = picture(13)
    changed[5, 5] += 1
    write_png(tmp_path / "front" / "fire.0013.png", changed)
    after = {frame: open_shot(pair).hashes(frame) for frame in (12, 13)}
    assert after[12] == before[12]
    assert [before[13][name] == after[13][name] for name in before[13]] == [False, True]
