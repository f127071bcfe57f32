"""The visual hull against a search over voxels, views and pixels."""

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st

from warpfluid.device import pick_device
from warpfluid.kernels.launch import run_count
from warpfluid.kernels.tomography.visual_hull import occupied_runs, silhouette_hull
from warpfluid.projector import Projector, directions

CLEAR = 3e-4  # overlaps of box and bin shorter than this may count or not [pixel]


def hull_of(lit, angles_deg, device):
    array = wp.array(lit.astype(np.uint8), dtype=wp.uint8, device=device)
    return silhouette_hull(array, directions(np.asarray(angles_deg, float), pick_device(device))).numpy()


def brute_force(lit, angles_deg):
    """The hull, and which voxels it is clear about: a voxel is in when its box overlaps a lit bin in every view."""
    _, n, heights = lit.shape
    middle = (n - 1) / 2
    inside, clear = np.ones((2, n, n, heights), bool)
    for view, angle in zip(lit, np.deg2rad(angles_deg), strict=True):
        half = max(abs(np.cos(angle)), abs(np.sin(angle))) / 2
        for x in range(n):
            for z in range(n):
                q = (x - middle) * np.cos(angle) + (z - middle) * np.sin(angle) + middle
                bins = np.arange(n)
                overlap = np.minimum(q + half, bins + 0.5) - np.maximum(q - half, bins - 0.5)
                clear[x, z] &= not (np.abs(overlap) < CLEAR).any()
                inside[x, z] &= view[overlap > 0].any(axis=0)
    return inside, clear


@given(
    n=st.integers(2, 14),
    heights=st.integers(1, 60),
    angles=st.lists(st.floats(-400, 400), min_size=1, max_size=4),
    share=st.floats(0.1, 0.9),
    seed=st.integers(0, 99),
)
@settings(max_examples=25)
def test_is_what_every_view_sees_lit(device, n, heights, angles, share, seed):
    """For any angles and silhouettes, full of holes too."""
    lit = np.random.default_rng(seed).random((len(angles), n, heights)) < share
    inside, clear = brute_force(lit, angles)
    np.testing.assert_array_equal(hull_of(lit, angles, device)[clear], inside.astype(np.float32)[clear])


def test_front_and_side_give_a_product(device):
    """At 0 and 90 degrees boxes and pixels coincide: no voxel beside a lit one slips in."""
    front, side = np.random.default_rng(1).random((2, 11, 52)) < 0.5
    expected = front[:, None] & side[None]
    np.testing.assert_array_equal(hull_of(np.stack([front, side]), [0, 90], device), expected)


@pytest.mark.parametrize("angles", [[0, 90], [20, 75, 130], [-52, 10]])
def test_holds_everything_that_the_views_show(angles, device):
    """A voxel with light in it is never cut away."""
    rng = np.random.default_rng(2)
    n, heights = 15, 50
    x = np.arange(n) - (n - 1) / 2
    volume = (rng.random((n, n, heights)) < 0.01) * (np.hypot(x[:, None], x) < n / 2 - 1)[..., None]
    images = Projector(angles, volume.shape, device=device).project(volume.astype(np.float32))
    hull = hull_of(images > 1e-3, angles, device)  # a corner of a box in a bin is no silhouette
    assert (hull[volume > 0] == 1).all()


@pytest.mark.parametrize("heights", [1, 4, 47, 48, 49, 100])
def test_occupied_runs(heights, device):
    """A run is marked when it holds a voxel of the hull, the short one at the top too."""
    hull = (np.random.default_rng(heights).random((5, 6, heights)) < 0.03).astype(np.float32)
    hull[0, 0, -1] = 1
    runs = run_count(heights, pick_device(device))
    run = 4 if device.startswith("cuda") else 48
    padded = np.pad(hull, ((0, 0), (0, 0), (0, runs * run - heights)))
    expected = padded.reshape(5, 6, runs, run).any(axis=-1)
    found = occupied_runs(wp.array(hull, dtype=float, device=device)).numpy()
    np.testing.assert_array_equal(found, expected)
