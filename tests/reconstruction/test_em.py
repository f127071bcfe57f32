"""The iteration as a whole: exact inputs, invariances, shapes and starts."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warpfluid.metrics import psnr
from warpfluid.options import ReconstructOptions
from warpfluid.projector import Projector
from warpfluid.reconstruction.em import fan_angles, reconstruct
from warpfluid.views import Views

ANGLES = (0.0, 90.0)


def quick(**changes):
    return ReconstructOptions(**{"iterations": 3, "angles": 60} | changes)


@pytest.fixture(scope="module")
def pictures(fire):
    """Views of the fire by angle."""
    angles = [0.0, 20.0, 75.0, 90.0, 128.0]
    return dict(zip(angles, Projector(angles, fire.shape, device="cpu").project(fire), strict=True))


@pytest.fixture(scope="module")
def views(pictures):
    """Front and side."""
    return Views(np.stack([pictures[angle] for angle in ANGLES]), ANGLES)


@pytest.fixture(scope="module")
def result(views):
    """What the default makes of them in three iterations."""
    return reconstruct(views, quick(), device="cpu")


def test_measured_views_come_out_as_they_went_in(views, device):
    """To 55 dB and more, on every device."""
    found = reconstruct(views, quick(), device=device)
    for rendered, image in zip(found.render(ANGLES), views.images, strict=True):
        assert psnr(rendered, image) > 55


def level_detail(pictures):
    """Power of the finest detail along the height that is alike over some twelfth of the width."""
    windowed = pictures * np.hanning(pictures.shape[1])[:, None] * np.hanning(pictures.shape[2])
    power = np.abs(np.fft.rfft2(windowed)) ** 2
    return power[:, : pictures.shape[1] // 12 + 1, -pictures.shape[2] // 8 :].sum()


def test_one_view_leaves_no_combs(pictures, fire):
    """A highpass that is not parted makes up with level lines for the fine detail that slices lack across."""
    front, angles = Views(pictures[0.0][None], (0.0,)), tuple(range(15, 180, 15))
    truth = level_detail(Projector(angles, fire.shape, device="cpu").project(fire))
    parted, whole = (
        level_detail(reconstruct(front, quick(iterations=8, highpass=kind), device="cpu").render(angles)) / truth
        for kind in ("parted", "whole")
    )
    assert parted < 4.5
    assert parted < 0.5 * whole


def test_what_a_reconstruction_holds(result, views, fire):
    """Volumes of the box's shape, finite and nowhere negative; two energies an iteration."""
    for volume in (result.volume, result.initial):
        assert volume.shape == fire.shape
        assert volume.dtype == np.float32
        assert np.isfinite(volume).all()
        assert volume.min() >= 0
    assert result.energies.shape == (3, 2)
    assert result.angles_deg == views.angles_deg
    assert 0 < result.hull_share < 1
    np.testing.assert_array_equal(result.density, np.swapaxes(result.volume, 1, 2))
    assert result.render([10, 20]).shape == (2, 48, 40)
    assert "48 x 40 x 48" in repr(result)


@pytest.mark.parametrize("balance", [2, 0])
def test_stays_inside_the_visual_hull(views, balance):
    """Where a view is black, so is the volume along the ray; balancing is not what sees to it."""
    found = reconstruct(views, quick(balance=balance), device="cpu")
    dark_front, dark_side = views.images <= 1
    assert not found.volume.transpose(0, 2, 1)[dark_front].any()
    assert not found.volume.transpose(1, 2, 0)[dark_side].any()
    lit = (~dark_front)[:, None] & (~dark_side)[None]
    assert found.hull_share == pytest.approx(lit.mean())


def test_the_energy_is_the_distance_to_the_made_views(views):
    """With measured views alone in the fan it can be worked out from outside: Eq. 1."""
    options = quick(angles=2, iterations=2, row_sums=False)
    found = reconstruct(views, options, device="cpu")
    expected = np.square(found.render(ANGLES) - views.images, dtype=np.float64).sum()
    assert found.energies[-1, 1] == pytest.approx(expected, rel=1e-3)


def test_progress_is_told(views):
    """After each iteration, with its energy."""
    told = []
    found = reconstruct(views, quick(), device="cpu", progress=lambda *what: told.append(what))
    assert [number for number, _ in told] == [1, 2, 3]
    np.testing.assert_array_equal([energy for _, energy in told], found.energies[:, 1])


def test_a_view_may_come_from_behind(pictures, fire):
    """128 degrees and, mirrored, -52 are one and the same."""
    here = Views(np.stack([pictures[20.0], pictures[128.0]]), (20, 128))
    there = Views(np.stack([pictures[20.0], pictures[128.0][::-1]]), (20, -52))
    found = [reconstruct(views, quick(iterations=2), device="cpu").volume for views in (here, there)]
    np.testing.assert_array_equal(*found)


def test_the_order_of_views_hardly_matters(views, result):
    """Balancing visits one after the other; nothing else knows an order."""
    turned = Views(views.images[::-1], ANGLES[::-1])
    found = reconstruct(turned, quick(), device="cpu")
    assert np.abs(found.volume - result.volume).mean() < 0.05 * result.volume.mean()


@pytest.mark.parametrize("angles", [(20.0, 75.0, 128.0), (75.0,), (128.0,)])
def test_any_angles_and_numbers_of_views(pictures, angles, device):
    """Three views, or one from an odd angle."""
    views = Views(np.stack([pictures[angle] for angle in angles]), angles)
    found = reconstruct(views, quick(), device=device)
    for rendered, image in zip(found.render(angles), views.images, strict=True):
        assert psnr(rendered, image) > 30
    assert (np.diff(found.energies[1:, 1]) < 0).all()


def test_pixel_values_scale_the_volume(views, result):
    """Footage in 0..1 gives the same volume in its own units."""
    exact = reconstruct(Views(views.images / 256, ANGLES, white=255 / 256), quick(), device="cpu")
    np.testing.assert_array_equal(exact.volume, result.volume / 256)
    np.testing.assert_array_equal(exact.initial, result.initial / 256)
    found = reconstruct(Views(views.images / 255, ANGLES, white=1), quick(), device="cpu")
    np.testing.assert_allclose(found.volume, result.volume / 255, atol=1e-3 * result.volume.max() / 255)


def test_any_number_of_threads_gives_the_same_bits(views, result, monkeypatch):
    """One thread or two, and again."""
    for threads in ("1", "2"):
        monkeypatch.setenv("WARPFLUID_THREADS", threads)
        found = reconstruct(views, quick(), device="cpu")
        np.testing.assert_array_equal(found.volume, result.volume)
        np.testing.assert_array_equal(found.energies, result.energies)


def test_devices_agree(views, result, device):
    """To rounding, which the matching does not blow up."""
    found = reconstruct(views, quick(), device=device)
    np.testing.assert_allclose(found.energies, result.energies, rtol=1e-2)
    np.testing.assert_allclose(found.initial, result.initial, atol=1e-3 * result.initial.max())


def test_may_start_from_a_volume(views, result, fire):
    """From the truth the views need less change than from least squares; the start itself stays as it is."""
    start = fire.copy()
    found = reconstruct(views, quick(), start=start, device="cpu")
    assert found.energies[0, 0] < 0.7 * result.energies[0, 0]
    near, far = (np.corrcoef(r.volume.ravel(), fire.ravel())[0, 1] for r in (found, result))
    assert near > far
    np.testing.assert_array_equal(start, fire)
    for rendered, image in zip(found.render(ANGLES), views.images, strict=True):
        assert psnr(rendered, image) > 50


def test_a_start_has_the_units_of_the_pictures(views, fire):
    """As the volume has that comes out."""
    whole = reconstruct(views, quick(), start=fire, device="cpu")
    small = Views(views.images / 256, ANGLES, white=255 / 256)
    found = reconstruct(small, quick(), start=fire / 256, device="cpu")
    np.testing.assert_array_equal(found.volume, whole.volume / 256)


def test_refuses_a_start_of_another_shape(views):
    """The message tells the shape that is needed."""
    with pytest.raises(ValueError, match=r"start.*\(48, 48, 40\)"):
        reconstruct(views, quick(), start=np.zeros((48, 40, 48), np.float32), device="cpu")


@pytest.mark.parametrize("brightness", [0.0, 0.5])
@pytest.mark.parametrize("count", [1, 2])
def test_an_empty_frame_gives_an_empty_volume(count, brightness):
    """A shot may begin before its fire does, and noise below the threshold is no fire."""
    images = np.full((count, 20, 16), brightness, np.float32)
    found = reconstruct(Views(images, ANGLES[:count]), quick(), device="cpu")
    assert found.volume.shape == (20, 20, 16)
    assert not found.volume.any()
    assert found.energies.shape == (0, 2)
    assert found.hull_share == 0
    assert "none" in repr(found)


def test_a_view_that_is_black_leaves_nothing(views):
    """What one view does not show is not there; nothing divides by zero."""
    images = views.images.copy()
    images[1] = 0
    found = reconstruct(Views(images, ANGLES), quick(), device="cpu")
    assert np.isfinite(found.volume).all()
    assert not found.volume.any()


def test_least_squares_alone(views, result):
    """``method="lsm"`` is the initial volume of the other method."""
    found = reconstruct(views, quick(method="lsm"), device="cpu")
    np.testing.assert_array_equal(found.volume, found.initial)
    np.testing.assert_array_equal(found.initial, result.initial)
    assert found.energies.shape == (0, 2)


def test_no_iterations_give_the_start(views):
    """The volume that the iteration would have begun with."""
    found = reconstruct(views, quick(iterations=0), device="cpu")
    assert found.volume.any()
    assert found.energies.shape == (0, 2)


def test_the_seed_changes_the_volume_and_nothing_else(views, result):
    """Another fire of the same looks."""
    found = reconstruct(views, quick(seed=1), device="cpu")
    assert np.abs(found.volume - result.volume).max() > 0.01 * result.volume.max()
    np.testing.assert_array_equal(found.initial, result.initial)


@pytest.mark.parametrize(
    "change",
    [
        {"footprint": "joseph"},
        {"preconditioner": "none"},
        {"input_weight": 1.0},
        {"blur": 0.0},
        {"row_sums": False},
        {"slice_rescale": True},
        {"balance": 0},
        {"balance_power": 0.5},
        {"fade": 0.0},
        {"start_noise": 0.0},
        {"noise_grain": 3.0, "noise_grain_y": 8.0},
        {"scales": 3},
        {"interpolation": "hybrid"},
        {"interpolation": "first"},
        {"non_negative": False, "balance": 0},
        {"shoulder": 2.0},
    ],
    ids=lambda change: "-".join(map(str, change.values())),
)
def test_every_option_does_something_sound(views, result, change):
    """Another volume, of about the same light, whose views are near the measured ones."""
    found = reconstruct(views, quick(**change), device="cpu")
    assert np.isfinite(found.volume).all()
    assert not np.array_equal(found.volume, result.volume)
    if "shoulder" not in change:  # which changes the light itself
        assert found.volume.sum() == pytest.approx(result.volume.sum(), rel=0.15)
        assert psnr(found.render([0.0])[0], views.images[0]) > 22


@given(
    count=st.integers(2, 400),
    measured=st.lists(st.floats(0, 179.999), min_size=1, max_size=6, unique_by=lambda angle: round(angle, 2)),
)
@settings(max_examples=150)
def test_a_fan_holds_the_measured_angles(count, measured):
    """Exactly, ascending and within half a turn, with no gap of two spacings, and hardly more angles than asked for."""
    fan, at = fan_angles(count, tuple(measured))
    assert [fan[i] for i in at] == measured
    assert (np.diff(fan) > 0).all()
    assert fan[0] >= 0
    assert fan[-1] < 180
    assert count <= len(fan) <= count + len(measured)
    gaps = np.diff([*fan, fan[0] + 180])
    assert gaps.max() <= 2 * 180 / count + 1e-9


def test_a_fan_through_its_own_angles_is_even():
    """Nothing moves where a measured angle is one of the fan's."""
    fan, at = fan_angles(180, (0.0, 90.0))
    np.testing.assert_array_equal(fan, np.arange(180))
    assert at == [0, 90]
