"""What the iteration is given: grey levels, angles within half a turn, the missing side, the hull."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from warpfluid.device import pick_device
from warpfluid.footage.tone import apply_shoulder, undo_shoulder
from warpfluid.options import ReconstructOptions
from warpfluid.projector import Projector
from warpfluid.reconstruction.inputs import make_inputs
from warpfluid.views import Views


def prepared(images, angles, white=255.0, device="cpu", **options):
    settled = ReconstructOptions(**options).settled(views=len(angles), width=images.shape[1], bright=0.0)
    return make_inputs(Views(images, angles, white), settled, pick_device(device))


def whole_hull(inputs):
    return inputs.whole(inputs.hull)


@given(grey=st.floats(0, 255), strength=st.one_of(st.just(0.0), st.floats(0.01, 10)))
def test_the_shoulder_comes_off_and_goes_on_again(grey, strength):
    """Either way round."""
    assert apply_shoulder(undo_shoulder(np.float64(grey), strength), strength) == pytest.approx(grey, abs=1e-6)
    assert undo_shoulder(apply_shoulder(np.float64(grey), strength), strength) == pytest.approx(grey, abs=1e-2)


@given(strength=st.floats(0.1, 6))
def test_the_shoulder_darkens_greys_and_keeps_black_and_white(strength):
    """Film compresses the bright end: taking that off darkens everything between."""
    grey = np.linspace(0, 255, 50)
    light = undo_shoulder(grey, strength)
    assert light[[0, -1]] == pytest.approx([0, 255], abs=1e-9)
    assert (light[1:-1] < grey[1:-1]).all()
    assert (np.diff(light, 2) > 0).all()


def test_angles_come_within_half_a_turn(fire, device):
    """Odd half turns mirror the picture; the hull does not notice."""
    images = Projector([128, 200, 15], fire.shape, device=device).project(fire)
    expected = prepared(images, (128, 200, 15), device=device)
    np.testing.assert_allclose(expected.angles_deg, (128, 20, 15))
    np.testing.assert_array_equal(expected.images[1], images[1, ::-1])
    turned = np.stack([images[0][::-1], images[1], images[2]])
    found = prepared(turned, (-52, 560, 375), device=device)
    assert found.angles_deg == expected.angles_deg
    np.testing.assert_array_equal(found.images, expected.images)
    np.testing.assert_array_equal(whole_hull(found), whole_hull(expected))
    assert found.measured == 3


def test_white_scales_the_pictures(fire):
    """Inside, white is always 255."""
    images = Projector([0, 90], fire.shape, device="cpu").project(fire)
    found = prepared(images / 256, (0, 90), white=255 / 256)
    np.testing.assert_array_equal(found.images, prepared(images, (0, 90)).images)


def test_row_sums_are_the_mean_over_the_measured_views(fire):
    """A stand-in has no say."""
    images = Projector([0, 90], fire.shape, device="cpu").project(fire)
    images[1] *= 1.2
    np.testing.assert_allclose(prepared(images, (0, 90)).row_sums, 1.1 * images[0].sum(axis=0), rtol=1e-5)
    np.testing.assert_allclose(prepared(images[:1], (0,)).row_sums, images[0].sum(axis=0), rtol=1e-5)


def test_the_hull_is_cut_to_what_it_needs(fire, device):
    """Put back into the box it is the silhouettes' product, and holds all of the fire."""
    images = Projector([0, 90], fire.shape, device=device).project(fire)
    inputs = prepared(images, (0, 90), device=device, threshold=0.5)
    expected = (images[0] > 0.5)[:, None] & (images[1] > 0.5)[None]
    np.testing.assert_array_equal(whole_hull(inputs), expected)
    assert inputs.hull.shape[0] < fire.shape[0]
    assert whole_hull(inputs)[fire > 0.5].all()
    corner, shape = inputs.corner, inputs.hull.shape
    np.testing.assert_array_equal(
        inputs.hull.numpy(), expected[corner[0] : corner[0] + shape[0], corner[1] : corner[1] + shape[1]]
    )
    part = inputs.projector((30.0, 120.0), "box")
    whole = Projector([30, 120], fire.shape, hull=expected.astype(np.float32), device=device)
    volume = (fire * expected).astype(np.float32)
    np.testing.assert_allclose(part.project(volume[inputs.part]), whole.project(volume), rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize("angle", [0.0, 30.0, 90.0, -40.0])
def test_one_view_gets_a_mirrored_side_and_a_round_hull(fire, angle):
    """The front alone is measured; the hull is as deep as wide, and the front sees nothing outside it."""
    (front,) = Projector([angle], fire.shape, device="cpu").project(fire)
    inputs = prepared(front[None], (angle,))
    assert inputs.measured == 1
    assert inputs.angles_deg[0] == pytest.approx(angle % 180)
    assert abs(inputs.angles_deg[1] - inputs.angles_deg[0]) == pytest.approx(90)
    assert inputs.side is not None
    hull = whole_hull(inputs)
    front_of_hull, side_of_hull = Projector([angle, angle + 90], fire.shape, device="cpu").project(hull) > 0.5
    assert front_of_hull[front > 3].all()
    wide, deep = (seen.any(axis=1).sum() for seen in (front_of_hull, side_of_hull))
    assert 0.6 < deep / wide < 1.6
    np.testing.assert_allclose(inputs.side.sum(axis=0), front.sum(axis=0), rtol=1e-3, atol=1e-2)


@pytest.mark.parametrize(("stand_in", "mirrored"), [("mirror", True), ("front", False), ("measured", False)])
def test_what_stands_in_for_the_side(fire, stand_in, mirrored):
    """The front, as it is or mirrored; the paper counts it as measured."""
    (front,) = Projector([0], fire.shape, device="cpu").project(fire)
    inputs = prepared(front[None], (0,), stand_in=stand_in)
    np.testing.assert_array_equal(inputs.images[1], front[::-1] if mirrored else front)
    assert inputs.angles_deg == (0.0, 90.0)
    assert inputs.measured == (2 if stand_in == "measured" else 1)


def test_a_spark_beside_the_flame_stays_in_the_hull(fire):
    """Far from the bulk a lit pixel gets a disc of its own."""
    (front,) = Projector([0], fire.shape, device="cpu").project(fire)
    front[2:4, 20] = 150
    hull = whole_hull(prepared(front[None], (0,)))
    assert hull[2:4, :, 20].any(axis=1).all()
    assert hull[2:4, :, 20].sum() <= 2 * 6


def test_light_above_white_is_white():
    """The curve has no value above 255: brighter light, as equalised rows or EXR have, stays finite."""
    assert undo_shoulder(np.array([255.0, 300.0, 1e6]), 3.5) == pytest.approx([255, 255, 255])
