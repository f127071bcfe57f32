"""Stochastic tomography and its convex solver: one energy, two ways down."""

import dataclasses

import numpy as np
import pytest
import warp as wp
from scipy.optimize import minimize, nnls

from warpfluid.options import ReconstructOptions
from warpfluid.projector import Projector
from warpfluid.reconstruction.convex import SadEnergy, minimise
from warpfluid.reconstruction.em import reconstruct
from warpfluid.reconstruction.stochastic import WalkOptions, random_walk
from warpfluid.views import Views

WALK = WalkOptions(mutations=3_000_000, chains=200, quantum=4.0, seed=1)
FAN = tuple(np.arange(0, 180, 22.5))


def problem(volume, angles_deg, weight, device):
    """The energy of a volume's views inside its own silhouettes, and an empty volume."""
    projector = Projector(angles_deg, volume.shape, device=device)
    images = projector.project(volume)
    lit = wp.array((images > 1).astype(np.float32), dtype=float, device=projector.device)
    hull = (projector.backproject(lit).numpy() > len(angles_deg) - 0.5).astype(np.float32)
    inside = Projector(angles_deg, volume.shape, hull=hull, device=device)
    wanted = wp.array(images, dtype=float, device=projector.device)
    return SadEnergy(inside, wanted, weight), wp.zeros(volume.shape, dtype=float, device=projector.device)


@pytest.fixture(scope="module")
def small(fire):
    """A block of the fire, dark at its sides, brightest pixel 255."""
    part = np.ascontiguousarray(np.pad(fire[12:36, 12:36, 4:24], ((2, 2), (2, 2), (1, 1))))
    return part * np.float32(255 / part.sum(axis=1).max())


def small_matrices(shape, angles_deg, footprint="box"):
    """B and the differences of a small box as matrices."""
    units = np.eye(np.prod(shape), dtype=np.float32).reshape(-1, *shape)
    projector = Projector(angles_deg, shape, footprint=footprint, device="cpu")
    views = np.stack([projector.project(unit).ravel() for unit in units], axis=1)
    gaps = [[np.diff(unit, axis=k).ravel() for unit in units] for k in range(3)]
    return views.astype(np.float64), np.concatenate([np.stack(gap, axis=1) for gap in gaps]).astype(np.float64)


@pytest.mark.parametrize(("weight", "footprint"), [(0.3, "box"), (2.0, "box"), (0.5, "joseph")])
def test_the_convex_solver_finds_the_minimum(weight, footprint, device):
    """That of a quadratic program with a bound on every difference, by another solver."""
    shape, angles = (3, 3, 2), (0, 40, 90)
    views, gaps = small_matrices(shape, angles, footprint)
    wanted = views @ np.random.default_rng(2).random(18) + np.random.default_rng(3).normal(0, 0.3, len(views))

    def split(both):
        return both[:18], both[18:]

    found = minimize(
        lambda both: np.square(views @ both[:18] - wanted).sum() + weight * both[18:].sum(),
        np.full(18 + len(gaps), 0.5),
        jac=lambda both: np.concatenate([2 * views.T @ (views @ both[:18] - wanted), np.full(len(gaps), weight)]),
        bounds=[(0, None)] * (18 + len(gaps)),
        constraints=[
            {"type": "ineq", "fun": lambda both, s=sign: split(both)[1] + s * gaps @ split(both)[0]} for sign in (1, -1)
        ],
        method="SLSQP",
        options={"maxiter": 500, "ftol": 1e-12},
    )
    assert found.success
    projector = Projector(angles, shape, footprint=footprint, device=device)
    images = wp.array(wanted.reshape(projector.image_shape), dtype=float, device=projector.device)
    energy, volume = SadEnergy(projector, images, weight), wp.zeros(shape, dtype=float, device=projector.device)
    energies = minimise(energy, volume, steps=3000)
    assert energies[-1, 1] == pytest.approx(found.fun, rel=2e-4)
    np.testing.assert_allclose(volume.numpy().ravel(), found.x[:18], atol=5e-3)


def test_without_differences_it_is_non_negative_least_squares(device):
    """A weight of 0 leaves squares and the bound."""
    shape, angles = (3, 3, 2), (0, 30, 60, 90, 120, 150)
    views, _ = small_matrices(shape, angles)
    wanted = views @ np.random.default_rng(2).random(18) + np.random.default_rng(3).normal(0, 1, len(views))
    projector = Projector(angles, shape, device=device)
    images = wp.array(wanted.reshape(projector.image_shape), dtype=float, device=projector.device)
    volume = wp.zeros(shape, dtype=float, device=projector.device)
    energies = minimise(SadEnergy(projector, images, 0.0), volume, steps=3000)
    expected, error = nnls(views, wanted)
    assert energies[-1, 1] == pytest.approx(error**2, rel=1e-3)
    np.testing.assert_allclose(volume.numpy().ravel(), expected, atol=2e-2)


@pytest.mark.parametrize(("angles", "weight"), [((0.0, 90.0), 1.0), ((0.0, 90.0), 5.0), (FAN, 1.0), (FAN, 5.0)])
def test_the_walk_comes_near_the_minimum(small, angles, weight, device):
    """Within three per cent of the convex minimum, never below it; with many views both volumes agree."""
    energy, lowest = problem(small, angles, weight, device)
    least = minimise(energy, lowest, steps=1500)[-1, 1]
    walked = wp.zeros_like(lowest)
    walk = random_walk(energy, walked, WALK)
    assert 0.999 * least < walk.energies[-1, 1] < 1.03 * least
    if angles is FAN:
        a, b = walked.numpy(), lowest.numpy()
        assert np.linalg.norm(a - b) < 0.08 * np.linalg.norm(b)


def test_views_of_the_convex_solver_weigh_the_same(small, device):
    """It says so."""
    energy, volume = problem(small, (0.0, 90.0), 1.0, device)
    weighted = SadEnergy(energy.projector, energy.images, 1.0, weights=np.array([1.0, 2.0]))
    with pytest.raises(ValueError, match="have weights"):
        minimise(weighted, volume, steps=1)


def test_what_a_walk_tells(small, device):
    """An energy before and after each sweep, which is the energy; quanta that shrink; a share that is one."""
    energy, volume = problem(small, (0.0, 90.0), 1.0, device)
    told = []
    options = dataclasses.replace(WALK, mutations=200_000, sweeps=12)
    walk = random_walk(energy, volume, options, progress=lambda *now: told.append(now))
    assert walk.energies.shape == walk.rates.shape == (12, 2)
    assert told == [(k + 1, after) for k, after in enumerate(walk.energies[:, 1])]
    np.testing.assert_array_equal(walk.energies[1:, 0], walk.energies[:-1, 1])
    assert energy(volume) == walk.energies[-1, 1]
    rates, quanta = walk.rates.T
    assert ((rates > 0) & (rates < 1)).all()
    assert quanta[0] == 4
    assert quanta[-1] == pytest.approx(4 / 256)
    assert (np.diff(quanta) <= 0).all()


def test_mutations_are_shared_out(small, device):
    """More of them end lower; a single one is taken, too."""
    ends = []
    for mutations in (1, 20_000, 200_000):
        energy, volume = problem(small, (0.0, 90.0), 1.0, device)
        ends.append(random_walk(energy, volume, dataclasses.replace(WALK, mutations=mutations)).energies[-1, 1])
    assert ends[0] > ends[1] > ends[2]


def see(volume, angles_deg):
    return Views(Projector(angles_deg, volume.shape, device="cpu").project(volume), angles_deg)


def test_a_seed_is_a_volume(small, monkeypatch, device):
    """The same seed gives the same bits with any number of threads, another one another volume."""
    views = see(small, (0.0, 90.0))
    options = ReconstructOptions(method="stochastic", mutations=100_000, chains=50)
    first = reconstruct(views, options, device=device)
    monkeypatch.setenv("WARPFLUID_THREADS", "5")
    again = reconstruct(views, options, device=device)
    np.testing.assert_array_equal(first.volume, again.volume)
    np.testing.assert_array_equal(first.walk, again.walk)
    other = reconstruct(views, dataclasses.replace(options, seed=1), device=device)
    assert (other.volume != first.volume).any()


def test_random_walks_make_an_e_step(small, device):
    """The energy of Eq. 1 falls about as far as with conjugate gradients."""
    views = see(small, (0.0, 90.0))
    ends = {}
    for e_step in ("least-squares", "stochastic"):
        options = ReconstructOptions(e_step=e_step, angles=20, iterations=2, sad_weight=0.0, mutations=400_000)
        found = reconstruct(views, options, device=device)
        assert found.energies[-1, 1] < found.energies[0, 0]
        ends[e_step] = found.energies[-1, 1]
        assert len(found.walk) == (24 if e_step == "stochastic" else 0)
    assert ends["stochastic"] < 1.5 * ends["least-squares"]
