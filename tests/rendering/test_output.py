"""Files of pictures, read again by others where there are any."""

from pathlib import Path

import numpy as np
import pytest

from warpfluid.files.images import read_image
from warpfluid.files.video import Video
from warpfluid.rendering.display import quantize
from warpfluid.rendering.output import Target, layers, side_by_side
from warpfluid.rendering.picture import Picture

SIZES = [(7, 11), (8, 6), (1, 1)]  # rows, columns


def picture(shape=(7, 11), seed=0):
    """Return a picture of noise in which nothing is equal; one pixel is empty."""
    rng = np.random.default_rng(seed)
    image = Picture(
        color=rng.random((*shape, 3), np.float32),
        alpha=rng.random(shape, np.float32),
        depth=rng.random(shape, np.float32) * 90,
        density=rng.random(shape, np.float32) * 255,
        emission=rng.random((*shape, 3), np.float32),
    )
    image.depth[0, 0] = np.inf
    return image


def screen(image, number):
    return image.color


@pytest.mark.parametrize("shape", SIZES)
@pytest.mark.parametrize("half", [False, True])
def test_exr_layers_as_openimageio_reads_them(tmp_path, shape, half):
    oiio = pytest.importorskip("OpenImageIO")
    image = picture(shape)
    Target(path=tmp_path / "a.exr", half=half).write(1, [image], screen, 0.5)
    file = oiio.ImageInput.open(str(tmp_path / "a.exr"))
    names, pixels = file.spec().channelnames, file.read_image(format="float")
    formats = {str(kind) for kind in file.spec().channelformats} or {str(file.spec().format)}
    file.close()
    assert formats == {"half" if half else "float"}
    read = dict(zip(names, np.moveaxis(pixels.reshape(*shape, len(names)), -1, 0), strict=True))
    wanted = {name: image.color[..., i] for i, name in enumerate("RGB")}
    wanted |= {f"emission.{name}": image.emission[..., i] for i, name in enumerate("RGB")}
    wanted |= {"A": image.alpha, "Z": image.depth * 0.5, "density": image.density}
    assert read.keys() == wanted.keys()
    for name, plane in wanted.items():
        expected = plane.astype(np.float16 if half else np.float32).astype(np.float32)
        np.testing.assert_array_equal(read[name], expected, err_msg=name)


def test_beauty_is_what_other_readers_take(tmp_path):
    image = picture()
    Target(path=tmp_path / "a.exr").write(1, [image], screen, 1.0)
    np.testing.assert_array_equal(read_image(tmp_path / "a.exr"), image.color)


@pytest.mark.parametrize(("deep", "steps"), [(False, 255), (True, 65535)])
def test_png(tmp_path, deep, steps):
    image = picture()
    files = Target(path=tmp_path / "a.##.png", deep=deep).write(3, [image], screen, 1.0)
    assert files == [tmp_path / "a.03.png"]
    np.testing.assert_allclose(read_image(files[0]), image.color, atol=0.5001 / steps)


@pytest.mark.parametrize("shape", [(21, 33), (24, 16)])
def test_film_frame_by_frame(tmp_path, shape):
    """Smooth pictures, as the codec blurs; an odd side has its last line twice."""
    rows, columns = np.mgrid[: shape[0], : shape[1]]
    images = [picture(shape) for _ in range(5)]
    for k, image in enumerate(images):
        image.color[...] = (0.2 + 0.1 * k + 0.2 * columns / shape[1] + 0.2 * rows / shape[0])[..., None]
    target = Target(path=tmp_path / "a.mp4")
    target.film((target.screen(k, [image], screen) for k, image in enumerate(images)), 25.0)
    video = Video(tmp_path / "a.mp4")
    assert (video.count, video.rate) == (5, 25.0)
    assert video.size == (shape[1] + shape[1] % 2, shape[0] + shape[0] % 2)
    for k, image in enumerate(images):
        np.testing.assert_allclose(video.read(k)[: shape[0], : shape[1]], image.color, atol=0.045)


@pytest.mark.parametrize("ending", ["webp", "gif"])
def test_animations_frame_by_frame(tmp_path, ending):
    from PIL import Image

    images = [picture((9, 5)) for _ in range(3)]
    for k, image in enumerate(images):
        image.color[...] = (0.8, 0.2 * k, 0.1)
    target = Target(path=tmp_path / f"a.{ending}")
    target.film((target.screen(k, [image], screen) for k, image in enumerate(images)), 10.0)
    with Image.open(tmp_path / f"a.{ending}") as file:
        assert file.n_frames == 3
        for k, image in enumerate(images):
            file.seek(k)
            found = np.asarray(file.convert("RGB"), float)
            np.testing.assert_allclose(found, quantize(image.color), atol=6)


def test_two_eyes_side_by_side(tmp_path):
    left, right = picture(seed=1), picture(seed=2)
    (file,) = Target(path=tmp_path / "a.exr").write(1, [left, right], screen, 1.0)
    np.testing.assert_array_equal(read_image(file), np.concatenate([left.color, right.color], axis=1))
    assert side_by_side([left, right]).depth.shape == (7, 22)


def test_two_eyes_in_files_of_their_own(tmp_path):
    left, right = picture(seed=1), picture(seed=2)
    files = Target(path=tmp_path / "a.####.exr", separate=True).write(12, [left, right], screen, 1.0)
    assert [file.name for file in files] == ["a.left.0012.exr", "a.right.0012.exr"]
    for file, image in zip(files, (left, right), strict=True):
        np.testing.assert_array_equal(read_image(file), image.color)


def test_layers_are_named_as_compositors_expect():
    assert list(layers(picture(), 1.0)) == ["RGBA", "Z", "density", "emission.R", "emission.G", "emission.B"]


@pytest.mark.parametrize(
    ("name", "facts", "words"),
    [
        ("a.tif", {}, "unknown kind: end the name in one of .exr, .png, .mp4"),
        ("a", {}, "unknown kind"),
        ("a.##.mp4", {}, "needs no frame number"),
        ("a.mp4", {"separate": True}, "choose --stereo side-by-side"),
        ("file/a.png", {}, "cannot be a folder, there is a file"),
        ("a.##.##.png", {}, "one place for the frame number"),
    ],
)
def test_names_that_no_picture_can_have(tmp_path, name, facts, words):
    (tmp_path / "file").touch()
    with pytest.raises(ValueError, match=words):
        Target(path=tmp_path / Path(name), **facts)
