"""Finer files: nothing is lost, small eddies are added where the fluid has some, and they come with the flow."""

import numpy as np
import pytest
import warp as wp
from scipy.ndimage import gaussian_filter, zoom

from warpfluid.device import pick_device
from warpfluid.files.vdb import read_vdb
from warpfluid.kernels.fluid.fine_paths import follow_back, sample
from warpfluid.kernels.forces.eddies import curl, lay_tile
from warpfluid.options import OutputOptions, Scene, SimulateOptions
from warpfluid.options.scene import parse_thing
from warpfluid.run import Run
from warpfluid.settings import SimulateSettings
from warpfluid.simulation.animate import Animator
from warpfluid.simulation.animation import Animation
from warpfluid.simulation.detail import Detail, mean_strain
from warpfluid.simulation.source import empty_box
from warpfluid.simulation.state import CELLS, Faces, FluidState, face_shape, six_sides

SHAPE, FULL = (20, 16, 24), 2.0
SIDES = six_sides("open", "open", "closed-low")


def arrays(device, *fields):
    return [wp.array(field, dtype=float, device=device) for field in fields]


def blob(device, *, speed=40.0) -> FluidState:
    """Return a lumpy ball of smoke that fine eddies stir."""
    rng = np.random.default_rng(3)
    faces = [speed * gaussian_filter(rng.normal(size=face_shape(SHAPE, axis)), 0.8) for axis in range(3)]
    places = np.indices(SHAPE).transpose(1, 2, 3, 0) - (np.array(SHAPE) - 1) / 2
    ball = np.exp(-(((places**2).sum(-1) / 40) ** 2)) * (1 + 2 * gaussian_filter(rng.normal(size=SHAPE), 1.2)).clip(0)
    cells = [FULL * ball, 0.5 * ball, 0 * ball, 0 * ball]
    return FluidState(Faces(*arrays(device, *faces)), *arrays(device, *cells))


def detail_of(device, factor=2, seed=0) -> Detail:
    return Detail(factor, SHAPE, SIDES, seed, pick_device(device))


def means(fine: np.ndarray, factor: int) -> np.ndarray:
    """Return the coarse grey levels of a fine volume: as many ray sums, so fine voxels hold a part of them."""
    parts = [size for n in fine.shape for size in (n // factor, factor)]
    return fine.reshape(parts).mean((1, 3, 5)) * factor


@pytest.mark.parametrize("factor", [2, 3, 4])
def test_the_low_pass_is_kept(device, factor):
    """Blurred over two coarse voxels the finer frame is the coarse one; in all, rays keep their sums."""
    state = blob(device)
    fine = detail_of(device, factor).refine(state, FULL, strength=1.0).cells["density"]
    assert fine.shape == tuple(factor * n for n in SHAPE)
    coarse, found = state.density.numpy(), means(fine, factor)
    low, expected = gaussian_filter(found, 2), gaussian_filter(coarse, 2)
    assert np.linalg.norm(low - expected) < 0.02 * np.linalg.norm(expected)
    rays, were = (gaussian_filter(volume.sum(1), 2) for volume in (found, coarse))
    assert np.linalg.norm(rays - were) < 0.02 * np.linalg.norm(were)
    assert found.sum() == pytest.approx(coarse.sum(), rel=1e-5)
    assert fine.min() >= 0


def test_without_strength_it_is_interpolated(device):
    """A cubic spline, as SciPy has it; where nothing moves strength adds nothing."""
    state = blob(device, speed=0.0)
    smooth = gaussian_filter(state.density.numpy(), 1.5)
    (state.density,) = arrays(device, smooth)
    detail = detail_of(device)
    plain, still = (detail.refine(state, FULL, strength=strength).cells["density"] for strength in (0.0, 1.0))
    np.testing.assert_array_equal(still, plain)
    expected = zoom(smooth, 2, order=3, mode="nearest", grid_mode=True) / 2
    assert np.linalg.norm(plain - expected) < 0.02 * np.linalg.norm(expected)


def test_eddies_add_what_the_grid_cannot_hold(device):
    """The high pass grows with the strength, on density and on heat, and another seed draws others."""
    state = blob(device)

    def sharp(name, strength, seed=0):
        field = detail_of(device, seed=seed).refine(state, FULL, strength=strength).cells[name]
        return field - gaussian_filter(field, 2)

    for name in ("density", "temperature"):
        sizes = [np.linalg.norm(sharp(name, strength)) for strength in (0.0, 1.0, 2.0)]
        assert 1.1 * sizes[0] < sizes[1] < sizes[2]
    one, other = sharp("density", 1.0), sharp("density", 1.0, seed=1)
    assert np.linalg.norm(one - other) > 0.3 * np.linalg.norm(one)


def test_patterns_come_with_the_flow(device):
    """In a uniform wind they are carried as far as it blows, and live long; in shear they wear."""
    state, detail = blob(device, speed=0.0), detail_of(device)
    state.velocity.x.fill_(24.0)
    for _ in range(3):
        detail.advance(state, 1 / 24, FULL)
    assert detail.state()["phase"] == pytest.approx(3 / 24 / 2)
    for name, expected in (("00", 3), ("10", 3), ("01", 0), ("12", 0)):
        np.testing.assert_allclose(detail.state()[name][6:], expected, atol=1e-4)
    shear = [np.zeros(face_shape(SHAPE, axis)) for axis in range(3)]
    shear[0] += 6 * np.arange(SHAPE[2])
    strain = mean_strain(Faces(*arrays(device, *shear)), np.ones(SHAPE, bool))
    assert strain == pytest.approx(6 / np.sqrt(2), rel=1e-5)


def test_a_carried_tile_is_the_tile_moved(device):
    """By whole voxels, exactly."""
    rng = np.random.default_rng(0)
    tile = wp.array(rng.normal(size=(8, 8, 8, 3)), dtype=wp.vec3, device=device)
    ones, none = np.ones(SHAPE), np.zeros(SHAPE)
    facts = {"offset": (0.3, 0.1, 5.0), "nodes_a_voxel": 1.7, "gain": 1.0, "factor": 2}
    made = []
    for away in ((none, none, none), (3 * ones, none, -2 * ones)):
        out = wp.zeros(tuple(2 * n for n in SHAPE), dtype=wp.vec3, device=device)
        made.append(lay_tile(tile, *arrays(device, ones, *away), **facts, out=out).numpy())
    np.testing.assert_allclose(made[1][6:, :, :-4], made[0][:-6, :, 4:], atol=1e-4)


def test_the_flow_has_no_divergence(device):
    """The curl of anything, by the same differences."""
    potential = wp.array(np.random.default_rng(1).normal(size=(9, 10, 53, 3)), dtype=wp.vec3, device=device)
    flow = curl(potential, scale=0.5, out=wp.zeros_like(potential)).numpy()
    inner, middle = flow[1:-1, 1:-1, 1:-1], slice(1, -1)
    divergence = 0
    for k in range(3):
        after, before = ([middle] * 3 + [k] for _ in range(2))
        after[k], before[k] = slice(2, None), slice(None, -2)
        divergence = divergence + inner[tuple(after)] - inner[tuple(before)]
    assert np.abs(divergence).max() < 1e-5 * np.abs(flow).max()


def test_paths_turn_with_the_flow(device):
    """In a steady rotation by a radian they end a radian back, on the same circle."""
    shape = (33, 33, 5)
    x, z, _ = np.indices(shape) - np.array([16, 16, 0]).reshape(3, 1, 1, 1)
    flow = wp.array(np.stack([-z, x, 0 * x], -1), dtype=wp.vec3, device=device)
    path = follow_back(flow, steps=16, out=wp.zeros_like(flow)).numpy() - (16, 16, 0)
    inside = np.hypot(x, z) < 12
    angle = np.array([np.cos(-1), np.sin(-1)])
    back = np.stack([angle[0] * x - angle[1] * z, angle[1] * x + angle[0] * z], -1)
    np.testing.assert_allclose(path[inside][:, :2], back[inside], atol=0.03)


def test_splines_stay_within_their_voxels(device):
    """A step makes no ring beside it, and what is not covered is 0."""
    step = np.zeros(SHAPE)
    step[10:] = 1
    path = np.indices(tuple(2 * n for n in SHAPE)).transpose(1, 2, 3, 0)
    out = wp.zeros(path.shape[:3], dtype=float, device=device)
    cover = np.ones(SHAPE)
    cover[:, 8:] = 0
    field, covered = arrays(device, step, cover)
    found = sample(field, wp.array(path, dtype=wp.vec3, device=device), factor=2, cover=covered, out=out).numpy()
    assert (found[:19, :14] == 0).all()
    assert (found[21:, :14] == 1).all()
    assert not found[:, 18:].any()


def test_too_much_detail_is_refused(device):
    """Before any memory is asked for."""
    with pytest.raises(ValueError, match=r"detail 4 of 400 x 600 x 400 voxels makes more than 2\^31: lower --detail"):
        Detail(4, (400, 400, 600), SIDES, 0, pick_device(device))


def test_files_are_finer_and_runs_go_on(tmp_path, device):
    """The box stays as large, velocity and density keep their units, and a resumed run has the same bits."""
    options = SimulateOptions(detail=2, temperature_buoyancy=20.0, density_dissipation=0.0)
    emitter = parse_thing("emitter", "sphere center=0,2,0 radius=1.5 density=4 temperature=1 noise=1")
    scene, output = Scene(emitter=(emitter,)), OutputOptions(voxel_size=0.1, turntable=False, report=False)
    settings = SimulateSettings(source=None, size=(12, 16), simulate=options, scene=scene, output=output)
    source = empty_box((12, 16))
    plan = Animation(source=source, options=options, scene=scene, output=output, device=pick_device(device))
    whole, parts = Run(tmp_path / "whole"), Run(tmp_path / "parts")
    whole.begin(settings, {})
    records = list(Animator(plan, (1, 2, 3)).run(whole, resume=False))
    parts.begin(settings, {})
    list(Animator(plan, (1, 2)).run(parts, resume=False))
    last = Animator(plan, (1, 2, 3))
    list(last.run(parts, resume=True))
    assert whole.volume_path(3).read_bytes() == parts.volume_path(3).read_bytes()
    file = read_vdb(whole.volume_path(3))
    assert file.voxel_size == pytest.approx(0.05)
    assert file.grids["density"].shape == (24, 32, 24)
    assert file.grids["density"].sum() == pytest.approx(4 * records[-1]["total"], rel=1e-4)
    state = last.state
    speeds = [np.abs(part.numpy()).max() * 0.1 for part in state.velocity]
    assert np.abs(file.grids["velocity"]).max() == pytest.approx(max(speeds), rel=0.2)
    assert set(file.grids) >= {"density", "velocity", "temperature"}
    assert all(getattr(state, name).shape == (12, 12, 16) for name in CELLS)
