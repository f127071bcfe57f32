"""The multigrid cycle is symmetric and good, and what is solved is the equation that NumPy writes down."""

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse

from warpfluid.kernels import vectors
from warpfluid.kernels.poisson import coefficients
from warpfluid.kernels.sides import CLOSED, OPEN, WRAP
from warpfluid.simulation.multigrid import Multigrid, transfer
from warpfluid.simulation.state import KINDS, Faces, face_shape, six_sides

KINDS_OF_BOX = [("open", "open", "closed-low"), ("closed", "wrap", "closed-high"), ("wrap", "wrap", "wrap")]
sizes = st.integers(1, 9)
kinds = st.sampled_from(list(KINDS))


def random_box(shape, seed, sides):
    """Open shares, some 0, and masses; wrapped faces are equal."""
    rng = np.random.default_rng(seed)
    open = []
    for axis in range(3):
        share = np.clip(1.5 * rng.random(face_shape(shape, axis)) - 0.3, 0, 1).astype(np.float32)
        if sides[2 * axis] == WRAP:
            np.moveaxis(share, axis, 0)[-1] = np.moveaxis(share, axis, 0)[0]
        open.append(share)
    return open, rng.uniform(1, 20, shape).astype(np.float32)


def equation(open, mass, sides):
    """The matrix, face by face."""
    shape = mass.shape
    index = np.arange(mass.size).reshape(shape)
    matrix = sparse.lil_array((mass.size, mass.size))
    for axis in range(3):
        n = shape[axis]
        ids, m, o = (np.moveaxis(array, axis, 0) for array in (index, mass, open[axis]))
        for face in range(n + (sides[2 * axis] != WRAP)):
            below, above, side = face - 1, face, None
            if face in (0, n):
                side = sides[2 * axis + (face > 0)]
            for at in np.ndindex(o.shape[1:]):
                here = [ids[i][at] for i in (below, above) if 0 <= i < n or side == WRAP]
                weight = o[face][at] / np.mean([m[i][at] for i in (below, above) if 0 <= i < n or side == WRAP])
                if side == OPEN:
                    matrix[here[0], here[0]] += 2 * weight
                elif side != CLOSED:
                    matrix[here[0], here[0]] += weight
                    matrix[here[1], here[1]] += weight
                    matrix[here[0], here[1]] -= weight
                    matrix[here[1], here[0]] -= weight
    return matrix.tocsr()


def build(open, mass, sides, device):
    faces = Faces(*(wp.array(part, device=device) for part in open))
    return Multigrid(mass.shape, sides, open=faces, mass=wp.array(mass, device=device), device=device)


@given(shape=st.tuples(sizes, sizes, sizes), kind=st.tuples(kinds, kinds, kinds), seed=st.integers(0, 9))
@settings(max_examples=40)
def test_the_equation_is_that_of_the_faces(shape, kind, seed):
    """A p, for any sides, sizes, shares and masses."""
    sides = six_sides(*kind)
    open, mass = random_box(shape, seed, sides)
    p = np.random.default_rng(seed).standard_normal(shape).astype(np.float32)
    found = build(open, mass, sides, "cpu").levels[0].apply(wp.array(p), out=wp.empty(shape, dtype=float))
    expected = (equation(open, mass, sides) @ p.ravel().astype(np.float64)).reshape(shape)
    np.testing.assert_allclose(found.numpy(), expected, atol=1e-5)


@given(shape=st.tuples(sizes, sizes, sizes), kind=st.tuples(kinds, kinds, kinds), seed=st.integers(0, 9))
@settings(max_examples=40)
def test_the_cycle_is_symmetric_and_positive(shape, kind, seed):
    """As conjugate gradients need it."""
    sides = six_sides(*kind)
    box = build(*random_box(shape, seed, sides), sides, "cpu")
    rng = np.random.default_rng(seed)
    alive = box.levels[0].first_step.numpy() > 0
    a, b = (wp.array((alive * rng.standard_normal(shape)).astype(np.float32)) for _ in range(2))
    cycle_a, cycle_b = (box.cycle(field, wp.empty_like(field)) for field in (a, b))
    size = np.sqrt(vectors.dot(a, cycle_a) * vectors.dot(b, cycle_b))
    assert vectors.dot(a, cycle_b) == pytest.approx(vectors.dot(b, cycle_a), abs=1e-4 * size)
    assert size > 0 or not alive.any()


@pytest.mark.parametrize("kind", KINDS_OF_BOX)
@pytest.mark.parametrize("shape", [(32, 32, 32), (33, 20, 47)])
def test_a_cycle_takes_most_of_the_error_away(kind, shape, device):
    """Whatever the size: this is what multigrid is for."""
    box = Multigrid(shape, six_sides(*kind), device=device)
    values = np.random.default_rng(0).standard_normal(shape)
    left = wp.array((values - values.mean()).astype(np.float32), device=device)
    for _ in range(4):
        before = vectors.dot(left, left)
        image = box.levels[0].apply(box.cycle(left, wp.empty_like(left)), out=wp.empty_like(left))
        vectors.add_scaled(left, -1.0, image, out=left)
        assert vectors.dot(left, left) < 0.35**2 * before


@pytest.mark.parametrize("kind", KINDS_OF_BOX)
@pytest.mark.parametrize("n", [1, 2, 3, 8, 9])
def test_coarser_is_finer_transposed(n, kind):
    """And a constant stays one between walls."""

    def dense(taps, columns):
        matrix = np.zeros((taps[0].shape[0], columns))
        for i, (sources, weights) in enumerate(zip(taps[0].numpy(), taps[1].numpy(), strict=True)):
            np.add.at(matrix[i], sources, weights)
        return matrix

    for name in kind:
        finer, coarser = transfer(n, *KINDS[name], "cpu")
        np.testing.assert_array_equal(dense(finer, (n + 1) // 2), dense(coarser, n).T)
        if OPEN not in KINDS[name]:
            np.testing.assert_allclose(dense(finer, (n + 1) // 2).sum(axis=1), 1)


def test_iterations_do_not_grow_around_a_sphere(device):
    """Voxels that it nearly fills do not hold the others up."""
    shape, iterations = (40, 40, 40), []
    for radius in (0.0, 8.0, 12.3):
        open = []
        for axis in range(3):
            at = np.stack(np.indices(face_shape(shape, axis)), axis=-1) - 20.2
            at[..., axis] -= 0.5
            open.append(np.clip(np.linalg.norm(at, axis=-1) - radius + 0.5, 0, 1).astype(np.float32))
        box = build(open, np.ones(shape, np.float32), six_sides("open", "open", "closed-low"), device)
        alive = box.levels[0].first_step.numpy() > 0
        right = np.where(alive, np.random.default_rng(0).standard_normal(shape), 0).astype(np.float32)
        iterations.append(box.solve(wp.array(right, device=device), 1e-4 * np.abs(right).max())[1])
    assert max(iterations) <= 7


def test_a_coarse_face_counts_what_it_covers():
    """Four faces twice as far apart; the last voxel of an odd size is half as long."""
    sides = six_sides("open", "closed", "open")
    fine = Multigrid((5, 4, 4), sides, device="cpu").levels[0].coefficient.x
    out = coefficients.coarsen_coefficient(fine, axis=0, sides=sides, out=wp.empty((4, 2, 2), dtype=float))
    np.testing.assert_allclose(out.numpy()[:, 0, 0], [4, 2, 4 / 1.5, 8])
