"""The pressure step around solids and in fluids of different mass."""

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st

from warpfluid.kernels.sides import WRAP
from warpfluid.simulation.pressure import make_incompressible
from warpfluid.simulation.state import KINDS, Faces, Solids, face_shape, six_sides

CLOSED_BOX = six_sides("closed", "closed", "closed")
OPEN_BOX = six_sides("open", "open", "open")
PLUME = six_sides("open", "open", "closed-low")
sizes = st.integers(1, 12)
kinds = st.sampled_from(list(KINDS))


def on(device, faces):
    return Faces(*(wp.array(part, dtype=float, device=device) for part in faces))


def fields(shape, seed=0):
    rng = np.random.default_rng(seed)
    return [rng.standard_normal(face_shape(shape, axis)).astype(np.float32) for axis in range(3)]


def numbers(velocity):
    return [part.numpy() for part in velocity]


def sphere(shape, radius, device, motion=(0.0, 0.0, 0.0)):
    """A solid in the middle of a box, with the shares of its faces as a smooth step."""

    def share(at):
        away = np.linalg.norm(at - (np.array(shape) - 1) / 2, axis=-1)
        return np.clip(away - radius + 0.5, 0, 1).astype(np.float32)

    open, velocity = [], []
    for axis in range(3):
        at = np.stack(np.indices(face_shape(shape, axis)), axis=-1).astype(float)
        at[..., axis] -= 0.5
        open.append(share(at))
        velocity.append(np.full(face_shape(shape, axis), motion[axis], np.float32))
    fluid = wp.array(share(np.stack(np.indices(shape), axis=-1)), device=device)
    return Solids(on(device, open), on(device, velocity), fluid)


def flux(velocity, solids):
    """What leaves each voxel, through fluid and with the solid, in float64."""
    total = 0.0
    for axis, (u, open, solid) in enumerate(zip(velocity, solids.open, solids.velocity, strict=True)):
        u, open, solid = (part.numpy().astype(np.float64) for part in (u, open, solid))
        total = total + np.diff(open * u + (1 - open) * solid, axis=axis)
    return total


@given(shape=st.tuples(sizes, sizes, sizes), kind=st.tuples(kinds, kinds, kinds), seed=st.integers(0, 9))
@settings(max_examples=40)
def test_direct_and_multigrid_agree(shape, kind, seed):
    """Two ways to one velocity, for any sides and sizes."""
    sides, faces = six_sides(*kind), fields(shape, seed)
    one, other = on("cpu", faces), on("cpu", faces)
    make_incompressible(one, sides, method="direct", tolerance=1e-6)
    done = make_incompressible(other, sides, method="multigrid", tolerance=1e-6)
    assert done.relative <= 1e-5 or done.residual <= 1e-5
    for a, b in zip(numbers(one), numbers(other), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-4)


@given(shape=st.tuples(sizes, sizes, sizes), kind=st.tuples(kinds, kinds, kinds), seed=st.integers(0, 9))
@settings(max_examples=40)
def test_nothing_is_left_in_rubble(shape, kind, seed):
    """Random shares, masses and pockets of every kind."""
    rng, sides, open = np.random.default_rng(seed), six_sides(*kind), []
    for axis in range(3):
        share = np.clip(1.5 * rng.random(face_shape(shape, axis)) - 0.6, 0, 1).astype(np.float32)
        if sides[2 * axis] == WRAP:
            np.moveaxis(share, axis, 0)[-1] = np.moveaxis(share, axis, 0)[0]
        open.append(share)
    still = [np.zeros_like(part) for part in open]
    solids = Solids(on("cpu", open), on("cpu", still), wp.ones(shape, dtype=float, device="cpu"))
    mass = wp.array(rng.uniform(1, 20, shape).astype(np.float32), device="cpu")
    velocity = on("cpu", fields(shape, seed))
    done = make_incompressible(velocity, sides, solids=solids, mass=mass)
    assert done.relative <= 1e-4
    assert np.abs(flux(velocity, solids)).max() <= 1e-4 * done.before + 1e-5
    for part, share in zip(numbers(velocity), open, strict=True):
        assert not part[share == 0].any()


@pytest.mark.parametrize("sides", [CLOSED_BOX, PLUME])
@pytest.mark.parametrize("motion", [(0.0, 0.0, 0.0), (3.0, 0.0, -2.0)])
def test_fluid_goes_around_a_sphere(sides, motion, device):
    """Standing or moving; within it the velocity is its own."""
    shape = (17, 16, 19)
    solids = sphere(shape, 4.3, device, motion)
    velocity = on(device, fields(shape))
    done = make_incompressible(velocity, sides, solids=solids)
    assert done.method == "multigrid"
    assert done.relative <= 1e-4
    assert np.abs(flux(velocity, solids)).max() <= 1e-4 * done.before + 1e-5
    for part, share, own in zip(velocity, solids.open, solids.velocity, strict=True):
        inside = share.numpy() == 0
        inside[[0, -1]] = inside[:, [0, -1]] = inside[:, :, [0, -1]] = False
        np.testing.assert_array_equal(part.numpy()[inside], own.numpy()[inside])


def test_a_stream_speeds_up_beside_a_sphere(device):
    """Potential flow: at the waist of a sphere the speed is 3/2 of the stream's, at its poles 0."""
    shape = (48, 48, 48)
    solids = sphere(shape, 8.0, device)
    velocity = Faces.zeros(shape, device)
    velocity.x.fill_(1.0)
    make_incompressible(velocity, OPEN_BOX, solids=solids)
    x = velocity.x.numpy()
    at = np.indices(face_shape(shape, 0)) - 23.5
    at[0] -= 0.5
    away = np.sqrt((at**2).sum(axis=0))
    shell = (away > 9.5) & (away < 14)
    expected = 1 + 8.0**3 * (away[shell] ** 2 - 3 * at[0][shell] ** 2) / (2 * away[shell] ** 5)
    assert np.abs(x[shell] - expected).mean() < 0.04
    assert x[shell].max() > 1.2
    assert x[shell].min() < 0.6


def test_what_is_kept_of_solids_that_stand_gives_the_same_bits(device):
    """The second step is not the first, but on equal input it is."""
    shape = (12, 12, 12)
    solids, faces = sphere(shape, 3.2, device), fields(shape)
    first, second = on(device, faces), on(device, faces)
    make_incompressible(first, PLUME, solids=solids)
    make_incompressible(on(device, fields(shape, 7)), CLOSED_BOX, solids=solids)
    make_incompressible(second, PLUME, solids=solids)
    for a, b in zip(numbers(first), numbers(second), strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("ratio", [1.0, 20.0])
def test_a_heavy_blob_falls_nearly_freely(ratio, device):
    """By (ratio - 1) / (ratio + 1/2) of g, for air must make way: it moves as half a blob would; at 1 it floats."""
    shape = (40, 40, 40)
    away = np.sqrt(((np.indices(shape) - 19.5) ** 2).sum(axis=0))
    mass = np.where(away < 6, ratio, 1.0).astype(np.float32)
    velocity = Faces.zeros(shape, device)
    velocity.y.fill_(-9.8)
    make_incompressible(velocity, CLOSED_BOX, mass=wp.array(mass, device=device), tolerance=1e-5)
    y = velocity.y.numpy()
    inner = np.sqrt(((np.indices(y.shape) - np.array([19.5, 19.5, 20.0]).reshape(3, 1, 1, 1)) ** 2).sum(axis=0)) < 4
    assert y[inner].mean() == pytest.approx(-9.8 * (ratio - 1) / (ratio + 0.5), rel=0.06, abs=1e-3)


def test_one_mass_is_no_mass(device):
    """Mass matters only where it differs."""
    shape, faces = (9, 8, 7), fields((9, 8, 7))
    one, other = on(device, faces), on(device, faces)
    make_incompressible(one, PLUME, tolerance=1e-6)
    make_incompressible(other, PLUME, mass=wp.full(shape, 3.0, dtype=float, device=device), tolerance=1e-6)
    for a, b in zip(numbers(one), numbers(other), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-4)


def test_expansion_counts_where_there_is_fluid(device):
    """What leaves through the sides is what the fluid's share wanted."""
    shape = (16, 16, 16)
    solids = sphere(shape, 4.3, device)
    velocity = Faces.zeros(shape, device)
    expansion = wp.full(shape, 1.0, dtype=float, device=device)
    make_incompressible(velocity, OPEN_BOX, solids=solids, expansion=expansion)
    alive = (
        sum(
            part.numpy().take(range(16), axis) + part.numpy().take(range(1, 17), axis)
            for axis, part in enumerate(solids.open)
        )
        > 0
    )
    out = sum(np.take(p, -1, axis).sum() - np.take(p, 0, axis).sum() for axis, p in enumerate(numbers(velocity)))
    assert out == pytest.approx((solids.fluid.numpy() * alive).sum(), rel=1e-3)


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan])
def test_refuses_mass_that_is_none(value, device):
    """It would fall with any acceleration."""
    mass = np.ones((4, 4, 4), np.float32)
    mass[1, 2, 3] = value
    with pytest.raises(ValueError, match="mass"):
        make_incompressible(Faces.zeros((4, 4, 4), device), PLUME, mass=wp.array(mass, device=device))


def test_the_number_of_threads_changes_nothing(monkeypatch):
    """Not a bit."""
    shape, found = (20, 33, 50), []
    for threads in ("1", "3"):
        monkeypatch.setenv("WARPFLUID_THREADS", threads)
        velocity = on("cpu", fields(shape))
        make_incompressible(velocity, PLUME, solids=sphere(shape, 5.1, "cpu"))
        found.append(numbers(velocity))
    for a, b in zip(*found, strict=True):
        np.testing.assert_array_equal(a, b)
