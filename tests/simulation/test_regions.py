"""Pockets that fluid cannot leave are found, however they are shut off."""

import numpy as np
import pytest
import warp as wp
from scipy import ndimage

from warpfluid.simulation.regions import Regions
from warpfluid.simulation.state import Faces, face_shape, six_sides

SHAPE = (7, 6, 9)


def shut(solid):
    """Faces of a box with solid voxels."""
    faces = []
    for axis in range(3):
        share = np.ones(face_shape(solid.shape, axis), np.float32)
        moved = np.moveaxis(share, axis, 0)
        moved[:-1][np.moveaxis(solid, axis, 0)] = 0
        moved[1:][np.moveaxis(solid, axis, 0)] = 0
        faces.append(share)
    return faces


def regions(faces, *kind):
    return Regions(Faces(*(wp.array(part) for part in faces)), six_sides(*kind))


@pytest.mark.parametrize("seed", range(5))
def test_finds_what_scipy_labels(seed):
    """In random rubble in a closed box; single voxels without an open face are no fluid."""
    solid = np.random.default_rng(seed).random(SHAPE) < 0.6
    labels, count = ndimage.label(~solid)
    alone = ndimage.sum_labels(np.ones(SHAPE), labels, range(1, count + 1)) == 1
    found = regions(shut(solid), "closed", "closed", "closed")
    assert found.count == count - alone.sum()
    for i in range(found.count):
        voxels = found.voxels[found.labels == i]
        (name,) = np.unique(labels.ravel()[voxels])
        assert len(voxels) == (labels == name).sum()


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_wall_without_thickness_divides(axis):
    """Faces alone are shut; a wrap joins the two halves again."""
    faces = shut(np.zeros(SHAPE, bool))
    np.moveaxis(faces[axis], axis, 0)[3] = 0
    assert regions(faces, "closed", "closed", "closed").count == 2
    kind = ["closed"] * 3
    kind[axis] = "wrap"
    assert regions(faces, *kind).count == 1
    kind[axis] = "closed-low"
    assert regions(faces, *kind).count == 1
    assert regions(faces, "open", "open", "open").count == 0


def test_removes_the_mean_of_each(device):
    """And leaves what has a way out alone."""
    solid = np.zeros(SHAPE, bool)
    solid[3] = True
    values = np.random.default_rng(0).standard_normal(SHAPE).astype(np.float32)
    field = wp.array(values, device=device)
    found = regions(shut(solid), "closed-low", "closed", "closed")
    found.remove_means(field)
    assert found.count == 1
    np.testing.assert_array_equal(field.numpy()[3:], values[3:])
    np.testing.assert_allclose(field.numpy()[:3], values[:3] - values[:3].mean(), atol=1e-6)
