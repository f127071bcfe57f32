"""The panels of Fig. 3, of the library and of the command line."""

import numpy as np
import pytest
from PIL import Image
from tiny import BARE, pair, quick, run

from warpfluid.options import ReconstructOptions
from warpfluid.projector import Projector
from warpfluid.reconstruction.em import reconstruct
from warpfluid.report.panels import panels
from warpfluid.views import Views


@pytest.fixture(scope="module")
def steps(fire):
    """Two iterations, observed; and their result."""
    small = fire[::2, ::2, ::2]
    views = Views(Projector((0.0, 90.0), small.shape, device="cpu").project(small), (0.0, 90.0))
    seen = []
    result = reconstruct(views, ReconstructOptions(iterations=2, angles=20), observe=seen.append, device="cpu")
    return views, seen, result


def test_an_observer_sees_every_iteration(steps):
    """What is rendered is the volume before, what is made holds the inputs, and the last volume is the result's."""
    views, (first, second), result = steps
    assert (first.iteration, second.iteration) == (1, 2)
    np.testing.assert_allclose(
        second.rendered, Projector(second.angles_deg, first.volume.shape).project(first.volume), atol=0.5
    )
    for angle, image in zip(views.angles_deg, views.images, strict=True):
        np.testing.assert_allclose(second.made[second.angles_deg.index(angle)], image, atol=1e-3)
    np.testing.assert_array_equal(second.volume, result.volume)
    assert not np.array_equal(first.volume, second.volume)


def test_panels_show_an_angle_a_column(steps):
    """Three rows of views in the order of the steps, then slices."""
    views, (first, _), _ = steps
    width, rows = views.size
    picture = panels(first, "gray", (0, 90))
    assert picture.shape == (3 * rows, 2 * width + 4 + 2 * width + 4, 3)
    made = np.clip(np.rint(views.images[1].T[::-1]), 0, 255)
    np.testing.assert_allclose(picture[rows : 2 * rows, width + 4 : 2 * width + 4, 0], made, atol=1)


def test_the_command_writes_panels(tmp_path):
    """One picture a frame and iteration."""
    views = pair(tmp_path, range(1, 3))
    flags = quick(
        "--iterations", "2", "--coherence", "none", *BARE, "-o", tmp_path / "run", "--debug-dir", tmp_path / "x"
    )
    assert run("reconstruct", *views, *flags, "-q") == 0
    written = sorted(path.name for path in (tmp_path / "x").iterdir())
    assert written == ["0001.01.png", "0001.02.png", "0002.01.png", "0002.02.png"]
    assert np.ptp(np.asarray(Image.open(tmp_path / "x" / written[0]))) > 50
