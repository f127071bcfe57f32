"""The numbers and their floors: the truth is perfect, a blur is not, and the floors are what they say."""

import numpy as np
import pytest
from plumes import blurred, plume

from warpfluid.comparison import measure
from warpfluid.comparison.measure import against_footage, against_truth, as_given, mean_numbers, unseen_angles, views_of
from warpfluid.comparison.motion import measured_pairs, motion_against_footage, motion_against_truth, speeds
from warpfluid.metrics import METRICS, compare_pictures, grid_index

GIVEN = (0.0, 90.0)
UNSEEN = (30.0, 45.0, 120.0)
TRUTH = plume()


@pytest.fixture(scope="module")
def found():
    """The truth itself, a blur and half of the light, measured."""
    volumes = {"copy": TRUTH, "blur": blurred(TRUTH), "half": TRUTH / 2}
    return against_truth(volumes, TRUTH, GIVEN, UNSEEN, device="cpu")


def test_a_copy_of_the_truth_is_perfect(found):
    """All distances are 0 and all ratios 1, but for the weave, which is the truth's own."""
    for name, value in found["copy"].items():
        wanted = {"psnr": pytest.approx(228, abs=1), "ssim": 1, "grid_index": grid_index(TRUTH, GIVEN)}
        assert value == wanted.get(name, {"low": 0, "one": 1}.get(METRICS[name].best)), name


def test_what_is_worse_is_farther_than_the_floors(found):
    """A blur lies beyond the truth from aside in each number that ranks it; half of the light has half of the total."""
    floor = found[measure.aside(20)]
    for name in ("patch_swd", "log_spectrum", "magnitudes", "perimeter"):
        assert found["blur"][name] > 1.5 * floor[name] > 0
        assert found[measure.aside(10)][name] < floor[name]
    assert found["blur"]["gradient_ratio"] < 0.8
    assert found["half"]["total"] == pytest.approx(0.5)


def test_floors_are_what_they_say(found):
    """The truth, looked at from 20 degrees aside, and mirrored, against itself."""
    true, beside = (views_of(TRUTH, np.add(UNSEEN, angle), device="cpu") for angle in (0, 20))
    rows = [compare_pictures(*pair) for pair in zip(beside, true, strict=True)]
    assert found["truth +20°"]["patch_swd"] == pytest.approx(np.mean([row["patch_swd"] for row in rows]))
    assert found["truth, mirrored"]["intensity_w1"] == 0
    assert found["truth, mirrored"]["silhouette"] > 0.05
    assert found["truth, mirrored"]["row_mass"] == pytest.approx(0, abs=1e-6)


def test_unseen_angles():
    """Every fifteen degrees of half a turn, none near a given one, also where angles are written otherwise."""
    assert unseen_angles(GIVEN) == (15, 30, 45, 60, 75, 105, 120, 135, 150, 165)
    assert unseen_angles([0]) == unseen_angles([180]) == unseen_angles([-360]) == tuple(range(15, 180, 15))
    assert set(unseen_angles([-52])) == {*range(0, 180, 15)} - {135}
    assert len(unseen_angles([])) == 12
    assert unseen_angles(range(0, 180, 10)) == tuple(range(5, 180, 10))


def test_against_footage():
    """Unseen views against given ones; the floors are the views, and two moments, against each other."""
    images = views_of(TRUTH, GIVEN, device="cpu")[:, ::-1].transpose(0, 2, 1)
    later = views_of(plume(3), GIVEN, device="cpu")[:, ::-1].transpose(0, 2, 1)
    volumes = {"copy": TRUTH, "blur": blurred(TRUTH)}
    found = against_footage(volumes, images, GIVEN, UNSEEN, other_frame=later, device="cpu")
    assert list(found) == ["copy", "blur", "footage, other view", "footage, other frame"]
    assert found["blur"]["patch_swd"] > 1.3 * found["copy"]["patch_swd"]
    front, side = views_of(TRUTH, GIVEN, device="cpu")
    each = [compare_pictures(front, side)["perimeter"], compare_pictures(side, front)["perimeter"]]
    assert found["footage, other view"]["perimeter"] == pytest.approx(np.mean(each), rel=1e-4)
    assert found["footage, other frame"]["patch_swd"] > 0
    assert "psnr" not in found["copy"]
    assert against_footage(volumes, 0 * images, GIVEN, UNSEEN, device="cpu") == {}


def test_given_views():
    """What a volume renders of the views that it was made of, also through a tone curve."""
    seen = views_of(TRUTH, GIVEN, device="cpu")
    exact = as_given(TRUTH, seen, GIVEN, device="cpu")
    assert exact == {"input_psnr": pytest.approx(228, abs=1), "input_ssim": 1, "total": 1}
    darker = as_given(0.9 * TRUTH, seen, GIVEN, device="cpu")
    rms = np.sqrt(np.mean([np.mean((0.1 * p) ** 2) for p in seen]))
    assert darker["input_psnr"] == pytest.approx(20 * np.log10(255 / rms), abs=0.1)
    toned = views_of(TRUTH, GIVEN, shoulder=3.5, device="cpu")
    assert toned.sum() > 1.2 * seen.sum()
    assert as_given(TRUTH, toned, GIVEN, shoulder=3.5, device="cpu")["input_psnr"] > 200


def test_means_are_in_the_order_of_the_table():
    """Means over the frames that have a number."""
    frames = [{"a": {"psnr": 1.0, "patch_swd": 1.0}}, {"a": {"patch_swd": 3.0}, "b": {"psnr": 5.0}}]
    found = mean_numbers(frames)
    assert found == {"a": {"patch_swd": 2, "psnr": 1}, "b": {"psnr": 5}}
    assert list(found["a"]) == ["patch_swd", "psnr"]


def test_flicker_is_told_from_motion():
    """What rises as the truth does has 1; noise that is new in each frame more; what stands still in between less."""
    flicker = lambda frame: plume(frame) * (1.3 if frame % 2 else 0.7)  # noqa: E731
    volumes = {"copy": plume, "flicker": flicker}
    frames = range(1, 5)
    found = motion_against_truth(volumes, plume, frames, UNSEEN, device="cpu")
    assert found["copy"] == 1
    assert found["flicker"] > 1.5
    images = lambda frame: views_of(plume(frame), GIVEN, device="cpu")[:, ::-1].transpose(0, 2, 1)  # noqa: E731
    found = motion_against_footage(volumes, images, frames, UNSEEN, device="cpu")
    assert 0.6 < found["copy"] < 1.6
    assert found["flicker"] > 1.3 * found["copy"]
    assert motion_against_footage(volumes, lambda frame: None, frames, UNSEEN, device="cpu") == {}
    assert motion_against_truth(volumes, plume, [1], UNSEEN, device="cpu") == {}


def test_speed_of_a_known_motion():
    """A picture that rises by two pixels a frame, also where every second frame is missing."""
    image = views_of(plume(), [0], device="cpu")[:, ::-1].transpose(0, 2, 1)
    found = speeds(lambda frame: np.roll(image, 2 * frame, axis=2), [1, 2], device="cpu")
    assert found["median"] == pytest.approx(2, abs=0.5)
    assert speeds(lambda frame: np.roll(image, frame, axis=2), [1, 3], device="cpu")["median"] == pytest.approx(
        1, abs=0.3
    )
    assert speeds(lambda frame: image, [1]) == {}


def test_pairs_are_successive():
    """A gap is not taken for a step."""
    assert measured_pairs([1, 2, 5, 6]) == [(1, 2), (5, 6)]
    assert measured_pairs([1, 3, 5]) == [(1, 3), (3, 5)]
    assert measured_pairs([7]) == []
    assert len(measured_pairs(range(100), 3)) == 3
