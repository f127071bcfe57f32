"""Potentials on edges against NumPy's differences."""

import numpy as np
import pytest
import warp as wp
from mac import ALL_OPEN, ALL_WRAP, MIXED, on, random_faces, six, still

from warpfluid.kernels.forces.edges import add_curl, mask_edges

SHAPE = (8, 7, 53)


def random_edges(device, seed=0):
    """A potential, three arrays."""
    rng = np.random.default_rng(seed)
    shapes = [[n + (k != axis) for k, n in enumerate(SHAPE)] for axis in range(3)]
    return [wp.array(rng.standard_normal(shape), dtype=float, device=device) for shape in shapes]


@pytest.mark.parametrize("sides", [ALL_OPEN, ALL_WRAP])
def test_the_curl_is_differences_around_faces(sides, device):
    """The last edge of a wrapped axis counts as its first."""
    edges, faces = random_edges(device), random_faces(SHAPE)
    velocity = on(device, faces)
    add_curl(*velocity.values(), *edges, sides=six(sides))
    a = [edge.numpy().astype(float) for edge in edges]
    if sides == ALL_WRAP:
        for axis in range(3):
            for across in {0, 1, 2} - {axis}:
                ends = np.moveaxis(a[axis], across, 0)
                ends[-1] = ends[0]
    for axis, got in enumerate(velocity.values()):
        b, c = (axis + 1) % 3, (axis + 2) % 3
        curl = np.diff(a[c], axis=b) - np.diff(a[b], axis=c)
        np.testing.assert_allclose(got.numpy(), faces[axis] + curl, atol=3e-6)


@pytest.mark.parametrize("sides", [ALL_OPEN, ALL_WRAP, MIXED])
def test_an_edge_takes_the_least_of_its_four_voxels(sides, device):
    """Around the box where it wraps, the border goes on elsewhere."""
    edges = random_edges(device)
    before = [edge.numpy().copy() for edge in edges]
    mask = np.random.default_rng(1).random(SHAPE).astype(np.float32)
    mask_edges(*edges, wp.array(mask, device=device), sides=six(sides))
    for axis, (start, got) in enumerate(zip(before, edges, strict=True)):
        least = mask
        for across in {0, 1, 2} - {axis}:
            mode = "wrap" if sides[2 * across] == ALL_WRAP[0] else "edge"
            padded = np.moveaxis(np.pad(least, [(int(k == across),) * 2 for k in range(3)], mode=mode), across, 0)
            least = np.moveaxis(np.minimum(padded[1:], padded[:-1]), 0, across)
        np.testing.assert_array_equal(got.numpy(), least * start)


def test_a_curl_of_nothing_keeps_the_bits(device):
    """Of a potential that is the same everywhere."""
    edges = [wp.full(edge.shape, 3.0, dtype=float, device=device) for edge in random_edges(device)]
    velocity = on(device, still(SHAPE))
    add_curl(*velocity.values(), *edges, sides=six(ALL_OPEN))
    assert not any(face.numpy().any() for face in velocity.values())
