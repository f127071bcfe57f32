"""The tree of Fig. 17: what is measured there, and that histograms scatter the trunk."""

import sys
from pathlib import Path

import numpy as np
import pytest

from warpfluid.options import ReconstructOptions
from warpfluid.projector import Projector
from warpfluid.reconstruction.em import reconstruct
from warpfluid.views import Views

ANGLES = (0.0, 10.0, 20.0, 30.0, 45.0)


@pytest.fixture(scope="module")
def trees():
    """The module of the examples."""
    folder = str(Path(__file__).parents[2] / "examples" / "paper")
    sys.path.append(folder)
    import trees

    yield trees
    sys.path.remove(folder)


@pytest.fixture(scope="module")
def tree(trees):
    """A small tree."""
    return trees.tree(40, 60)


def test_a_tree_has_a_trunk_and_a_crown(trees, tree):
    """Only the trunk below, much beside it above; a seed gives the same tree."""
    assert tree.min() >= 0
    assert tree.sum(axis=1).max() == pytest.approx(255)
    path = np.rint(trees.trunk(40, 60)).astype(int)
    assert all(tree[x, z, y] > 0 for x, z, y in path[: int(0.9 * 60)])
    lit = (tree > 0).sum(axis=(0, 1))
    assert lit[2:10].max() < 15 < 40 < lit[24:40].min()
    np.testing.assert_array_equal(trees.tree(40, 60), tree)
    assert (trees.tree(40, 60, seed=1) != tree).any()


def test_the_contrast_is_that_of_a_trunk(trees, tree):
    """1 for the trunk alone, 0 for evenly lit views, high for the tree from every side."""
    alone = trees.tree(40, 60, branches=0)
    np.testing.assert_allclose(trees.trunk_contrast(project(alone, ANGLES), ANGLES), 1, atol=0.02)
    np.testing.assert_allclose(trees.trunk_contrast(np.full((1, 40, 60), 3.0), (45,)), 0, atol=1e-9)
    found = trees.trunk_contrast(project(tree, ANGLES), ANGLES).mean(axis=1)
    assert (found > 0.3).all()
    swapped = trees.trunk_contrast(project(tree, ANGLES)[::-1], ANGLES).mean(axis=1)
    assert (swapped[[0, -1]] < 0.8 * found[[0, -1]]).all()


def test_the_trunk_is_scattered(trees, tree):
    """It is there at the inputs and fades beside them; least squares loses it, and histograms bring back a part."""
    views, true = Views(project(tree, (0.0, 90.0)), (0.0, 90.0)), trees.trunk_contrast(project(tree, ANGLES), ANGLES)
    share = {}
    for name, options in (("lsm", {"method": "lsm"}), ("ours", {"iterations": 5, "angles": 60})):
        volume = reconstruct(views, ReconstructOptions(**options), device="cpu").volume
        made = trees.trunk_contrast(project(volume, ANGLES), ANGLES)
        share[name] = made.mean(axis=1) / true.mean(axis=1)
        assert share[name][0] > 0.9
    assert share["lsm"][-2:].max() < 0.5
    assert share["lsm"][-1] < share["ours"][-1] < 0.8


def project(volume, angles):
    return Projector(angles, volume.shape, device="cpu").project(volume)
