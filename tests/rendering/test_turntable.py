"""Turntables: the convention of angles, one exposure, films that play."""

import itertools

import numpy as np
import pytest

from warpfluid.rendering import turntable
from warpfluid.rendering.turntable import (
    render_turntable,
    slices_picture,
    strip,
    turntable_angles,
    write_turntable,
)

SIZE, HEIGHT = 12, 10


def spark(x, z, y, value=255.0):
    """A volume that is dark but for one voxel."""
    volume = np.zeros((SIZE, SIZE, HEIGHT), np.float32)
    volume[x, z, y] = value
    return volume


@pytest.mark.parametrize("angle", [0, 30, 45, 90, 200, 300])
def test_a_spark_is_where_the_convention_says(angle):
    """A voxel's light appears at u = x cos t + z sin t, at its height, and is all there."""
    x, z, y, middle = 9, 3, 7, (SIZE - 1) / 2
    picture = render_turntable(spark(x, z, y), [angle], "gray")[0, ..., 0].astype(float)
    assert picture.shape == (2 * HEIGHT, 2 * SIZE)
    rows, columns = np.indices(picture.shape)
    light = np.maximum(picture - 20, 0)  # without the ringing of the enlargement
    u, row = (light * columns).sum() / light.sum() / 2 - 0.25, (light * rows).sum() / light.sum() / 2 - 0.25
    t = np.deg2rad(angle)
    assert u - middle == pytest.approx((x - middle) * np.cos(t) + (z - middle) * np.sin(t), abs=0.25)
    assert row == pytest.approx(HEIGHT - 1 - y, abs=0.1)


def test_large_pictures_keep_their_size():
    """From 256 columns on nothing is enlarged, and pixels are ray sums."""
    volume = np.zeros((256, 256, 2), np.float32)
    volume[10, 20:23, 1] = 50
    picture = render_turntable(volume, [0], "gray")[0]
    assert picture.shape == (2, 256, 3)
    assert picture[0, 10].tolist() == [150, 150, 150]
    assert picture.sum() == 450


@pytest.mark.parametrize(
    ("width", "height", "lines", "size"),
    [(40, 60, 480, 8), (300, 100, 480, 5), (9, 9, 480, 8), (300, 480, 480, 1), (40, 500, 480, 2), (300, 9, 0, 1)],
)
def test_films_of_small_boxes_are_enlarged(width, height, lines, size):
    """By whole numbers; the light a voxel's width is what it was."""
    volume = np.zeros((width, width, height), np.float32)
    volume[3:6, 2, 4:7] = 20
    picture = render_turntable(volume, [0], "gray", lines=lines)[0, ..., 0]
    assert picture.shape == (size * height, size * width)
    assert picture.mean(dtype=float) == pytest.approx(20 * 9 / (width * height), rel=0.1)


def test_all_pictures_share_their_exposure():
    """With a free white the brightest view sets it; a column of voxels is bright only along its row."""
    row = np.zeros((SIZE, SIZE, HEIGHT), np.float32)
    row[2:10, 5, 4:7] = 0.01
    front, side = render_turntable(row, [0, 90], "gray", white=None)[..., 0]
    assert side.max() > 230
    assert 20 < front.max() < 60
    np.testing.assert_array_equal(render_turntable(1000 * row, [0], "gray", white=None)[0].shape, (20, 24, 3))


def test_a_black_volume_stays_black():
    """There is nothing to expose, and no error."""
    assert not render_turntable(0 * spark(1, 1, 1), [0, 45], white=None).any()


def test_a_strip_is_its_stills():
    """Stills stand side by side with a gap between them."""
    volume, angles = spark(3, 4, 5), [0, 45, 90]
    stills = render_turntable(volume, angles)
    picture = strip(volume, angles)
    width = stills.shape[2]
    assert picture.shape == (2 * HEIGHT, 3 * width + 2 * turntable.GAP, 3)
    np.testing.assert_array_equal(picture[:, width + turntable.GAP :][:, :width], stills[1])
    assert not picture[:, width : width + turntable.GAP].any()


def test_slices_are_seen_from_above():
    """x goes right, z down, and each height has its own slice."""
    volume = spark(9, 3, 7)
    picture = slices_picture(volume, [2, 7], "gray")
    assert picture.shape == (SIZE, 2 * SIZE + turntable.GAP, 3)
    assert np.argwhere(picture[..., 0]).tolist() == [[3, SIZE + turntable.GAP + 9]]
    assert slices_picture(volume, 7, "gray", white=510)[3, 9, 0] == 128


def test_a_turn_has_no_angle_twice():
    """The angles of a turn are even, and its end is not its start."""
    assert turntable_angles(4).tolist() == [0, 90, 180, 270]
    with pytest.raises(ValueError, match="count is 0"):
        turntable_angles(0)


@pytest.mark.parametrize("ending", ["mp4", "webp", "gif"])
def test_films_play(tmp_path, ending):
    """One volume turns once; the file holds as many pictures as asked for."""
    import av

    write_turntable(tmp_path / f"film.{ending}", spark(9, 3, 7), pictures=6, rate=12)
    if ending == "mp4":
        with av.open(tmp_path / "film.mp4") as film:
            assert len(list(film.decode(video=0))) == 6
    else:
        from PIL import Image

        with Image.open(tmp_path / f"film.{ending}") as film:
            assert (film.n_frames, film.size) == (6, (8 * SIZE, 8 * HEIGHT))


def test_a_sequence_plays_while_the_camera_walks():
    """Each volume is drawn once, at the first one's exposure, and only when its turn comes."""
    volumes = (spark(9, 3, y, value) for y, value in zip(itertools.count(), (1, 2, 3), strict=False))
    film = turntable._film(((volume, 90 * i) for i, volume in enumerate(volumes)), "gray", None)
    pictures = [next(film), next(film)]
    assert pictures[0].max() > 200
    rows = [np.argwhere(p[..., 0] == p.max())[:, 0].mean() for p in pictures]  # eight of them a voxel
    np.testing.assert_allclose(rows, [8 * HEIGHT - 4.5, 8 * HEIGHT - 12.5], atol=3)
    assert next(volumes).max() == 3, "the third volume is not read yet"


def test_wrong_volumes_heights_and_endings_are_refused(tmp_path):
    """Messages name what was found."""
    with pytest.raises(ValueError, match=r"volume has shape \(3, 3\)"):
        render_turntable(np.zeros((3, 3)), [0])
    with pytest.raises(ValueError, match="heights 0 to 9"):
        slices_picture(spark(1, 1, 1), [10])
    with pytest.raises(ValueError, match=r"ends in '\.avi'"):
        write_turntable(tmp_path / "film.avi", spark(1, 1, 1))
