"""What the paper says of the systems it is compared with (Figs. 9 to 11), on a small fire."""

import numpy as np
import pytest

from warpfluid.metrics import compare_pictures, grid_index
from warpfluid.options import ReconstructOptions
from warpfluid.projector import Projector
from warpfluid.reconstruction.em import reconstruct
from warpfluid.views import Views

UNSEEN = (25.0, 45.0, 70.0, 115.0, 135.0, 160.0)
OTHERS = ("lsm", "multiplication", "stochastic")
SYSTEMS = {
    "ours": ReconstructOptions(angles=60),
    "paper": ReconstructOptions.paper(angles=60),
    **{name: ReconstructOptions.paper(method=name, mutations=3_000_000) for name in OTHERS},
}


def pictures(volume):
    """Unseen views as files hold them, top row first."""
    return [image.T[::-1] for image in Projector(UNSEEN, volume.shape, device="cpu").project(volume)]


@pytest.fixture(scope="module", params=[(0.0, 90.0), (0.0,)], ids=["two views", "one view"])
def scores(request, fire):
    """Distance of the unseen views from the true ones, and the grid, of each system."""
    angles = request.param
    views = Views(Projector(angles, fire.shape, device="cpu").project(fire), angles)
    found = {}
    for name, options in SYSTEMS.items():
        volume = reconstruct(views, options, device="cpu").volume
        rows = [compare_pictures(a, b) for a, b in zip(pictures(volume), pictures(fire), strict=True)]
        found[name] = {key: np.mean([row[key] for row in rows]) for key in ("band_w1", "patch_swd")}
        found[name]["grid"] = grid_index(volume)
    return found


@pytest.mark.parametrize("metric", ["band_w1", "patch_swd"])
@pytest.mark.parametrize("method", ["ours", "paper"])
def test_unseen_views_look_more_like_the_truth(scores, method, metric):
    """At most 0.6 of the distance that least squares leaves, and three quarters of any other's."""
    assert scores[method][metric] < 0.6 * scores["lsm"][metric]
    for other in OTHERS:
        assert scores[method][metric] < 0.75 * scores[other][metric], other


@pytest.mark.parametrize("method", ["ours", "paper"])
def test_the_grid_goes(scores, method, fire):
    """Slices of all others are woven along the inputs' rays; those of appearance transfer are not."""
    assert scores[method]["grid"] < 1.2 * grid_index(fire)
    for other in OTHERS:
        assert scores[other]["grid"] > 1.5 * grid_index(fire), other
