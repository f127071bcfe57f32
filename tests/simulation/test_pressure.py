"""The pressure step leaves no divergence, and changes nothing that has none."""

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage, sparse
from scipy.sparse.linalg import spsolve

from warpfluid.kernels.sides import CLOSED, OPEN, WRAP
from warpfluid.simulation import spectral
from warpfluid.simulation.pressure import make_incompressible
from warpfluid.simulation.state import KINDS, Faces, face_shape, six_sides

SHAPE = (9, 6, 11)
CLOSED_BOX = six_sides("closed", "closed", "closed")
PLUME = six_sides("open", "open", "closed-low")
sizes = st.integers(1, 12)
kinds = st.sampled_from(list(KINDS))


def fields(shape, seed=0, smooth=0.0):
    """Random faces, as NumPy arrays."""
    rng = np.random.default_rng(seed)
    faces = [rng.standard_normal(face_shape(shape, axis)).astype(np.float32) for axis in range(3)]
    return [ndimage.gaussian_filter(part, smooth) for part in faces] if smooth else faces


def on(device, faces):
    return Faces(*(wp.array(part, dtype=float, device=device) for part in faces))


def copy(velocity):
    return Faces(*(wp.clone(part) for part in velocity))


def divergence(faces):
    """In float64, as the definition has it."""
    return sum(np.diff(np.asarray(part, np.float64), axis=axis) for axis, part in enumerate(faces))


def numbers(velocity):
    return [part.numpy() for part in velocity]


def row(n, low, high):
    """Minus the Laplacian along one axis."""
    matrix = sparse.lil_array((n, n))
    for i in range(n):
        for j, side in ((i - 1, low), (i + 1, high)):
            if 0 <= j < n or side == WRAP:
                matrix[i, i] += 1
                matrix[i, j % n] -= 1
            elif side == OPEN:
                matrix[i, i] += 2
    return matrix


def poisson(shape, sides):
    """Minus the Laplacian of a box, as a sparse matrix."""
    rows = [row(n, sides[2 * axis], sides[2 * axis + 1]) for axis, n in enumerate(shape)]
    one = [sparse.eye_array(n) for n in shape]
    parts = [[rows[axis] if k == axis else one[k] for k in range(3)] for axis in range(3)]
    return sum(sparse.kron(sparse.kron(a, b), c) for a, b, c in parts).tocsr()


@given(shape=st.tuples(sizes, sizes, sizes), kind=st.tuples(kinds, kinds, kinds), seed=st.integers(0, 9))
@settings(max_examples=60)
def test_no_divergence_is_left(shape, kind, seed):
    """Whatever the sides and sizes; walls hold, and what wraps is equal on both faces."""
    velocity = on("cpu", fields(shape, seed))
    sides = six_sides(*kind)
    done = make_incompressible(velocity, sides, method="direct")
    assert done.relative <= 1e-4
    found = divergence(numbers(velocity))
    if OPEN not in list(sides):
        found -= found.mean()
    assert np.abs(found).max() <= 1e-4 * done.before + 1e-6
    for axis, part in enumerate(numbers(velocity)):
        ends = np.take(part, 0, axis), np.take(part, -1, axis)
        for end, side in zip(ends, sides[2 * axis : 2 * axis + 2], strict=True):
            assert side != CLOSED or not end.any()
        if sides[2 * axis] == WRAP:
            np.testing.assert_array_equal(*ends)


@pytest.mark.parametrize("kind", [("closed", "open", "wrap"), ("closed-low", "closed-high", "open")])
def test_is_what_a_sparse_solve_gives(kind, device):
    """The correction is the gradient of the pressure that SciPy finds."""
    sides, faces = six_sides(*kind), fields(SHAPE)
    velocity = on(device, faces)
    make_incompressible(velocity, sides)
    for axis, part in enumerate(faces):
        ends = np.moveaxis(part, axis, 0)
        low, high = sides[2 * axis], sides[2 * axis + 1]
        if low == WRAP:
            ends[0] = ends[-1] = (ends[0] + ends[-1]) / 2
        ends[0] *= low != CLOSED
        ends[-1] *= high != CLOSED
    p = spsolve(poisson(SHAPE, sides), -divergence(faces).ravel()).reshape(SHAPE)
    for axis, part in enumerate(numbers(velocity)):
        inner = tuple(slice(1, -1) if k == axis else slice(None) for k in range(3))
        np.testing.assert_allclose(part[inner], faces[axis][inner] - np.diff(p, axis=axis), atol=2e-5)


def test_twice_is_once(device):
    """What has no divergence is not changed."""
    velocity = on(device, fields(SHAPE, smooth=1.0))
    make_incompressible(velocity, PLUME)
    once = numbers(copy(velocity))
    make_incompressible(velocity, PLUME)
    for a, b in zip(once, numbers(velocity), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-6)


def test_a_curl_stays_and_a_gradient_goes(device):
    """The two parts of a field: only that without divergence is left (Helmholtz)."""
    nx, nz, ny = SHAPE
    stream = np.zeros((nx + 1, nz, ny + 1), np.float32)
    stream[1:-1, :, 1:-1] = np.random.default_rng(1).standard_normal((nx - 1, nz, ny - 1))
    curl = [-np.diff(stream, axis=2), np.zeros((nx, nz + 1, ny), np.float32), np.diff(stream, axis=0)]
    velocity = on(device, curl)
    make_incompressible(velocity, CLOSED_BOX)
    for before, after in zip(curl, numbers(velocity), strict=True):
        np.testing.assert_allclose(after, before, atol=1e-5)
    p = np.random.default_rng(2).standard_normal(SHAPE).astype(np.float32)
    for axis, part in enumerate(curl):
        inner = tuple(slice(1, -1) if k == axis else slice(None) for k in range(3))
        part[inner] += np.diff(p, axis=axis)
    mixed = on(device, curl)
    make_incompressible(mixed, CLOSED_BOX, tolerance=1e-5)
    for before, after in zip(velocity, mixed, strict=True):
        np.testing.assert_allclose(after.numpy(), before.numpy(), atol=2e-5)


def test_a_uniform_force_in_a_closed_box_moves_nothing(device):
    """The pressure carries it: a fluid at rest under gravity stays at rest."""
    velocity = Faces.zeros(SHAPE, device)
    velocity.y.fill_(-9.8)
    make_incompressible(velocity, CLOSED_BOX, tolerance=1e-5)
    for part in numbers(velocity):
        np.testing.assert_allclose(part, 0, atol=1e-4)


def test_expansion_leaves_through_the_open_sides(device):
    """The flux through them is the sum of what was asked for (Gauss)."""
    velocity = Faces.zeros(SHAPE, device)
    expansion = np.zeros(SHAPE, np.float32)
    expansion[3:6, 2:4, 1:5] = 2.0
    make_incompressible(velocity, PLUME, expansion=wp.array(expansion, device=device))
    x, z, y = (part.astype(np.float64) for part in numbers(velocity))
    flux = x[-1].sum() - x[0].sum() + z[:, -1].sum() - z[:, 0].sum() + y[..., -1].sum() - y[..., 0].sum()
    assert flux == pytest.approx(expansion.sum(), rel=1e-4)
    np.testing.assert_allclose(divergence((x, z, y)), expansion, atol=1e-3)


def test_expansion_without_a_way_out_loses_its_mean(device):
    """A closed box cannot grow."""
    velocity = Faces.zeros(SHAPE, device)
    expansion = np.random.default_rng(0).random(SHAPE).astype(np.float32)
    done = make_incompressible(velocity, CLOSED_BOX, expansion=wp.array(expansion, device=device))
    assert done.relative <= 1e-4
    np.testing.assert_allclose(divergence(numbers(velocity)), expansion - expansion.mean(), atol=1e-4)


def test_the_last_pressure_is_a_good_start(device):
    """Given back, it leaves nothing to do."""
    faces, pressure = fields(SHAPE), wp.zeros(SHAPE, dtype=float, device=device)
    first = make_incompressible(on(device, faces), PLUME, pressure=pressure)
    again = make_incompressible(on(device, faces), PLUME, pressure=pressure)
    assert first.iterations > 0
    assert again.iterations == 0
    assert again.relative <= 1e-4


@pytest.mark.filterwarnings("ignore:Rank deficiency")  # a constant may be added to the pressure
@pytest.mark.parametrize("kind", ["closed", "wrap"])
def test_agrees_with_phiflow(kind):
    """A solver of others, on the same staggered grid."""
    flow = pytest.importorskip("phi.flow")
    shape = (8, 6, 10)
    faces = fields(shape, smooth=0.7)
    velocity = on("cpu", faces)
    sides = six_sides(kind, kind, kind)
    make_incompressible(velocity, sides, tolerance=1e-5)
    kept = []
    for axis, part in enumerate(faces):
        ends = np.moveaxis(part, axis, 0)
        if kind == "wrap":
            ends[0] = (ends[0] + ends[-1]) / 2
        kept.append(np.moveaxis(ends[:-1] if kind == "wrap" else ends[1:-1], 0, axis))
    names = flow.spatial("x,z,y")
    stacked = flow.math.stack([flow.tensor(part, names) for part in kept], flow.dual(vector="x,z,y"))
    edge = flow.extrapolation.PERIODIC if kind == "wrap" else flow.extrapolation.ZERO
    theirs = flow.StaggeredGrid(stacked, edge, x=shape[0], z=shape[1], y=shape[2])
    solve = flow.Solve("CG", 1e-6, 1e-6, max_iterations=2000)
    theirs, _ = flow.fluid.make_incompressible(theirs, (), solve)
    for axis, name in enumerate("xzy"):
        part = np.moveaxis(numbers(velocity)[axis], axis, 0)
        ours = np.moveaxis(part[:-1] if kind == "wrap" else part[1:-1], 0, axis)
        np.testing.assert_allclose(ours, theirs.values[{"~vector": name}].numpy("x,z,y"), atol=1e-4)


@pytest.mark.parametrize("n", [1, 2, 3, 7, 8])
@pytest.mark.parametrize("kind", list(KINDS))
def test_modes_are_sines_and_cosines(n, kind):
    """They are orthonormal, and minus the Laplacian of a row of voxels is diagonal in them."""
    vectors, values = spectral.diagonalise(n, *KINDS[kind])
    matrix = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    for end, side in ((0, KINDS[kind][0]), (n - 1, KINDS[kind][1])):
        matrix[end, end] += {OPEN: 1.0, CLOSED: -1.0, WRAP: 0.0}[side]
    if kind == "wrap":
        matrix[0, n - 1] -= 1.0
        matrix[n - 1, 0] -= 1.0
    np.testing.assert_allclose(vectors.T @ vectors, np.eye(n), atol=1e-6)
    np.testing.assert_allclose(vectors * values @ vectors.T, matrix, atol=2e-6)
    assert np.sum(values == 0.0) == (kind in ("closed", "wrap"))


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"method": "jacobi"}, "method"),
        ({"expansion": (3, 3, 3)}, "expansion"),
        ({"mass": (9, 6, 11), "method": "direct"}, "direct"),
    ],
)
def test_refuses_what_does_not_fit(arguments, word, device):
    """In words that name the argument."""
    made = {k: wp.ones(v, dtype=float, device=device) if isinstance(v, tuple) else v for k, v in arguments.items()}
    with pytest.raises(ValueError, match=word):
        make_incompressible(Faces.zeros(SHAPE, device), PLUME, **made)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_says_that_numbers_ran_away(value, device):
    """Instead of spreading them over the whole box."""
    faces = fields(SHAPE)
    faces[1][4, 3, 5] = value
    with pytest.raises(FloatingPointError, match="not finite"):
        make_incompressible(on(device, faces), PLUME)
