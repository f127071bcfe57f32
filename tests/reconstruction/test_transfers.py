"""The choice of the M-step, and statistics that others than the inputs give."""

import dataclasses
from typing import get_args, get_type_hints

import numpy as np
import pytest

from warpfluid.options import ReconstructOptions
from warpfluid.projector import Projector
from warpfluid.reconstruction.em import reconstruct
from warpfluid.reconstruction.transfers import TRANSFERS, make_transfer
from warpfluid.views import Views

ANGLES = (0.0, 90.0)
QUICK = ReconstructOptions(iterations=2, angles=24, patch=8)


def views_of(fire, angles, factor=1.0):
    return Views(factor * Projector(angles, fire.shape, device="cpu").project(fire), angles, factor * 255.0)


def test_every_choice_has_an_m_step():
    """The table and the option agree."""
    assert set(get_args(get_type_hints(ReconstructOptions)["transfer"])) == set(TRANSFERS)


@pytest.mark.parametrize("angles", [(0.0,), (0.0, 90.0), (10.0, 50.0, 130.0)])
@pytest.mark.parametrize("transfer", TRANSFERS)
def test_every_m_step_models_a_volume(fire, transfer, angles, device):
    """Of one, two and three views: finite, nowhere negative, as bright as the views, exact where it is measured."""
    views = views_of(fire, angles)
    found = reconstruct(views, dataclasses.replace(QUICK, transfer=transfer), device=device)
    assert np.isfinite(found.volume).all()
    assert found.volume.min() >= 0
    assert found.volume.sum(dtype=np.float64) == pytest.approx(fire.sum(dtype=np.float64), rel=0.05)
    error = np.sqrt(np.mean((found.render(angles) - views.images) ** 2))
    assert error < 0.02 * 255


@pytest.mark.parametrize("transfer", TRANSFERS)
def test_an_input_keeps_its_look(fire, transfer):
    """Made for the inputs' angles, every M-step leaves them alone; outside of the mask all is black."""
    images = views_of(fire, ANGLES).images
    mask = np.ones(images.shape, bool)
    mask[:, :4] = False
    made = make_transfer(images, ANGLES, ANGLES, dataclasses.replace(QUICK, transfer=transfer)).transfer(images, mask)
    np.testing.assert_allclose(made[mask], images[mask], atol=2.5)
    assert not made[~mask].any()


@pytest.mark.parametrize("transfer", TRANSFERS)
def test_the_inputs_as_statistics_change_nothing(fire, transfer):
    """Nor does their white or half a turn."""
    options = dataclasses.replace(QUICK, transfer=transfer, iterations=1)
    views = views_of(fire, ANGLES)
    usual = reconstruct(views, options, device="cpu")
    given = reconstruct(views, options, statistics=views, device="cpu")
    np.testing.assert_array_equal(given.volume, usual.volume)
    other = reconstruct(views, options, statistics=views_of(fire, (180.0, 90.0), 0.5), device="cpu")
    np.testing.assert_allclose(other.volume, usual.volume, atol=0.02 * usual.volume.max())


def test_true_histograms_are_little_better(fire):
    """Figs. 7 and 8: without interpolation grey values are wrong; with it they are about as good as with true ones."""
    views, unseen = views_of(fire, ANGLES), (30.0, 45.0, 60.0, 120.0, 150.0)
    true = Projector(unseen, fire.shape, device="cpu").project(fire)
    every = views_of(fire, tuple(range(0, 180, 5)))
    distance = {}
    for name, interpolation, statistics in (
        ("off", "first", None),
        ("on", "density", None),
        ("true", "density", every),
    ):
        options = ReconstructOptions.paper(interpolation=interpolation, iterations=4, angles=60)
        found = reconstruct(views, options, statistics=statistics, device="cpu").render(unseen)
        pairs = zip(found, true, strict=True)
        distance[name] = np.mean([np.abs(np.sort(a, axis=None) - np.sort(b, axis=None)).mean() for a, b in pairs])
    assert 1.05 * distance["on"] < distance["off"]
    assert distance["true"] == pytest.approx(distance["on"], rel=0.2)


def test_statistics_of_another_size_are_refused(fire):
    """With both sizes."""
    other = Views(np.ones((1, 20, 30), np.float32), (0.0,))
    with pytest.raises(ValueError, match="statistics have images of 20 x 30 pixels, expected 48 x 40"):
        reconstruct(views_of(fire, ANGLES), QUICK, statistics=other, device="cpu")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"transfer": "patches"},
            "transfer is 'patches', expected one of histograms, texture-optimization, p",
        ),
        ({"patch": 3}, "patch is 3, expected 4 to 64"),
        ({"sweeps": 0}, "sweeps is 0, expected 1 to 100"),
    ],
)
def test_wrong_options_are_refused(changes, message):
    """Before any work."""
    with pytest.raises(ValueError, match=message):
        ReconstructOptions(**changes)
