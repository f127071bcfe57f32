"""Inspection: row sums tell a known offset, shift and exposure, and the hints say what to do."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warpfluid.estimate import estimate_cost, hull_share
from warpfluid.files.images import read_image, write_png
from warpfluid.inspection import inspect_shot, write_views_picture
from warpfluid.options import InputOptions, ReconstructOptions
from warpfluid.row_sums import compare_row_sums
from warpfluid.shot import open_shot
from warpfluid.views import Views


def history(frames=30, heights=60):
    """Row sums of puffs that rise at their own speeds and fade."""
    rng = np.random.default_rng(3)
    t, v = np.mgrid[0:frames, 0:heights].astype(float)
    puffs = zip(rng.uniform(-20, 30, 12), rng.uniform(0.5, 2.5, 12), rng.uniform(0.5, 2, 12), strict=True)
    return sum(light * np.exp(-(((v - start - speed * t) / 4) ** 2)) for start, speed, light in puffs)


@settings(deadline=None, max_examples=15)
@given(st.integers(-6, 6), st.integers(-12, 12), st.floats(0.3, 3))
def test_known_remedy_is_found(offset, shift, scale):
    """A view that runs late, sits low and is dim is told to the frame and pixel."""
    light = history(46, 90)
    reference = light[8:38, 15:75]
    sums = light[8 - offset : 38 - offset, 15 + shift : 75 + shift] / scale
    remedy = compare_row_sums(reference, sums)
    assert (remedy.time_offset, remedy.vertical_shift) == (offset, shift)
    assert remedy.exposure_scale == pytest.approx(scale, rel=1e-6)
    assert remedy.disagreement_after == pytest.approx(0, abs=1e-6)


def test_equal_row_sums_need_no_remedy():
    """Views of one fluid agree, and so do two of nothing."""
    for sums in (history(), np.zeros((5, 20))):
        remedy = compare_row_sums(sums, sums)
        assert (remedy.disagreement, remedy.time_offset, remedy.vertical_shift) == (0, 0, 0)
        assert remedy.exposure_scale == 1


def test_a_steady_flame_fits_at_any_time():
    """Where every offset does as well the smallest remedy is given."""
    steady = np.broadcast_to(np.hanning(40), (20, 40))
    remedy = compare_row_sums(steady, steady * 2)
    assert (remedy.time_offset, remedy.vertical_shift) == (0, 0)
    assert remedy.exposure_scale == pytest.approx(0.5)


def test_hull_of_discs_is_their_cylinder():
    """Two views of a full-height bar leave the square they have in common, all angles of a disc the disc."""
    images = np.zeros((2, 40, 20), np.float32)
    images[:, 10:30] = 9
    assert hull_share(images, (0, 90), ReconstructOptions()) == pytest.approx(0.25)
    angles = tuple(np.arange(0, 180, 10.0))
    discs = np.repeat(images[:1], len(angles), axis=0)
    assert hull_share(discs, angles, ReconstructOptions()) == pytest.approx(np.pi / 16, rel=0.08)


def test_hull_of_one_view():
    """A bar becomes the round about its bulk, or with the silhouette a slab."""
    image = np.zeros((1, 40, 20), np.float32)
    image[:, 10:30] = 9
    assert hull_share(image, (0,), ReconstructOptions(hull="silhouette")) == pytest.approx(0.5)
    assert 0.15 < hull_share(image, (0,), ReconstructOptions()) < 0.4
    assert hull_share(image * 0, (0,), ReconstructOptions()) == 0


def test_cost_grows_with_the_volume():
    """Twice the size is about eight times the memory of the volume, and no iterations are cheaper."""
    small, large = (estimate_cost((n, n), 0.2, ReconstructOptions(angles=90)) for n in (256, 512))
    assert 4 < large[0] / small[0] < 9
    assert 4 < large[1] / small[1] < 9
    assert estimate_cost((256, 256), 0.2, ReconstructOptions(method="lsm", angles=90))[0] < small[0]


def flame(frame, tall=32, wide=24):
    """A puff that rises, uint8 (rows, columns)."""
    rows, columns = np.mgrid[0:tall, 0:wide]
    middle = tall - 6 - 1.5 * frame
    bell = np.exp(-(((rows - middle) / 4) ** 2) - ((columns - wide / 2) / 4) ** 2)
    return (180 * bell).astype(np.uint8)


def write(folder, make, frames=range(1, 13)):
    folder.mkdir()
    for frame in frames:
        write_png(folder / f"{frame:03d}.png", make(frame))
    return str(folder)


def test_a_late_view_is_noticed(tmp_path):
    """A side that runs two frames late gets that as a hint, and everything goes into JSON."""
    front = write(tmp_path / "front", flame)
    side = write(tmp_path / "side", lambda frame: flame(frame - 2))
    found = inspect_shot(open_shot([f"0={front}", f"90={side}"]))
    assert found.pairs[0].remedy.time_offset == 2
    assert found.pairs[0].remedy.disagreement_after < 0.02
    assert any("2 frames earlier" in hint for hint in found.hints)
    data = json.loads(json.dumps(found.to_dict()))
    assert data == found.to_dict()
    assert data["pairs"][0]["remedy"]["time_offset"] == 2
    assert data["volume_size"] == [24, 32, 24]
    assert any("view 90 against view 0" in line for line in found.lines())


def test_one_view_is_described(tmp_path):
    """What stands in a file is reported as it is."""
    folder = write(tmp_path / "front", flame)
    found = inspect_shot(open_shot([f"0={folder}"], InputOptions(frames="1-6")))
    view = found.views[0]
    assert (view.footage_size, view.size, view.frames, view.kind) == ((24, 32), (24, 32), "1-12", "images")
    assert (view.brightest, view.background, view.saturated) == (pytest.approx(180, abs=2), 0, 0)
    assert (found.frames, found.frame_count, found.pairs) == ("1-6", 6, ())
    assert found.hints == ()


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda frame: flame(frame) // 2 + 30, "--black-level 30"),
        (lambda frame: np.where(flame(frame) > 5, 240, 0).astype(np.uint8), "--shoulder"),
        (lambda frame: np.roll(flame(frame), 12, axis=1), "left and right edge"),
        (lambda frame: flame(frame) // 2 + 30, "hull fills"),
    ],
)
def test_hints(tmp_path, make, words):
    """Footage that an option would help gets that option as a hint."""
    found = inspect_shot(open_shot([f"0={write(tmp_path / 'a', make)}"]), ReconstructOptions(hull="silhouette"))
    assert any(words in hint for hint in found.hints)


def test_different_scenes_are_noticed(tmp_path):
    """Views that no shift brings together are called in question."""
    front = write(tmp_path / "a", flame)
    side = write(tmp_path / "b", lambda frame: np.roll(flame(12 - frame), 16, axis=0))
    found = inspect_shot(open_shot([f"0={front}", f"90={side}"]))
    assert any("no shift mends it" in hint for hint in found.hints)


@pytest.mark.parametrize("angles", [(0,), (0, 90), (52, 35, 0, -52, -66)])
def test_views_picture_shows_each_view(tmp_path, angles):
    """The picture holds light where the views do, for one view as for many, and for black ones."""
    images = np.repeat(flame(5)[None, ::-1].swapaxes(1, 2).astype(np.float32), len(angles), axis=0)
    write_views_picture(tmp_path / "lit.png", Views(images, angles))
    write_views_picture(tmp_path / "black.png", Views(images * 0, angles))
    lit, black = read_image(tmp_path / "lit.png"), read_image(tmp_path / "black.png")
    assert lit.shape == (800, 1280, 3)
    assert lit.mean() > black.mean()
    assert ((lit - black).max(axis=2) > 0.2).sum() > 500
