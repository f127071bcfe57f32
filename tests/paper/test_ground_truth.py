"""A simulated flame whose volume is known, rendered by another program."""

from pathlib import Path

import numpy as np
import pytest

import warpfluid as wf
from warpfluid.files.images import read_image
from warpfluid.metrics import compare_pictures

DATA = Path(__file__).parents[1] / "data" / "fire-plume"
RENDERED_DEG = (0, 15, 30, 45, 60, 75, 90, 120, 150)
UNSEEN_DEG = (15, 30, 45, 60, 75, 120, 150)


def cycles_picture(angle_deg):
    """A Cycles render, shape (rows, columns)."""
    return read_image(DATA / f"vol008_angle{angle_deg:03d}.png")[..., 0]


@pytest.fixture(scope="module")
def truth():
    """The true volume, shape (x, z, y)."""
    volume = np.load(DATA / "emission_008.npz")["volume"].astype(np.float32)
    return np.ascontiguousarray(volume.transpose(0, 2, 1))


@pytest.fixture(scope="module")
def from_cycles():
    """The reconstruction from the Cycles renders of front and side."""
    views = wf.Views.from_pictures([cycles_picture(0), cycles_picture(90)], [0, 90])
    return wf.reconstruct(views, wf.ReconstructOptions(iterations=5, angles=120), device="cpu")


@pytest.mark.parametrize("angle_deg", RENDERED_DEG)
def test_our_rays_are_those_of_cycles(truth, angle_deg):
    """Ray sums of the true volume correlate with Cycles; the mirrored angle does not."""
    ours = wf.Projector([angle_deg, -angle_deg], truth.shape, device="cpu").project(truth)
    theirs = cycles_picture(angle_deg)[::-1].T
    right, mirrored = (np.corrcoef(image.ravel(), theirs.ravel())[0, 1] for image in ours)
    assert right >= 0.999
    if angle_deg % 90:
        assert mirrored < 0.95


def test_unseen_views_look_like_the_truth(from_cycles):
    """At unseen angles the result is far nearer to the look of the Cycles renders than least squares is."""
    white = 255 / max(cycles_picture(angle).max() for angle in (0, 90))
    scores = {}
    for name, volume in (("ours", from_cycles.volume), ("lsm", from_cycles.initial)):
        made = wf.Projector(UNSEEN_DEG, volume.shape, device="cpu").project(volume)
        pairs = zip(made, UNSEEN_DEG, strict=True)
        rows = [compare_pictures(image.T[::-1], cycles_picture(angle) * white) for image, angle in pairs]
        scores[name] = {key: np.mean([row[key] for row in rows]) for key in rows[0]}
    ours, lsm = scores["ours"], scores["lsm"]
    assert ours["patch_swd"] < 0.06 < 0.15 < lsm["patch_swd"]
    assert ours["log_spectrum"] < 0.2 < 0.5 < lsm["log_spectrum"]
    assert 0.93 < ours["gradient_ratio"] < 1.08
    assert 0.93 < ours["streak"] < 1.1


def test_input_views_are_exact(from_cycles):
    """Rendered at the inputs' angles, the volume is what Cycles rendered, but for the truth's own disagreement."""
    rendered = from_cycles.render([0, 90])
    for image, angle_deg in zip(rendered, (0, 90), strict=True):
        picture = cycles_picture(angle_deg)[::-1].T * (255 / max(cycles_picture(a).max() for a in (0, 90)))
        assert 20 * np.log10(255 / np.sqrt(np.mean((image - picture) ** 2))) > 40


def test_energy_falls_below_a_quarter(from_cycles):
    """The energy never rises after the first iteration and ends below a quarter of its start."""
    after_m, after_e = from_cycles.energies.T
    assert (np.diff(after_m[1:]) <= 0).all()
    assert (np.diff(after_e[1:]) <= 0).all()
    assert after_e[-1] < 0.25 * after_m[0]
