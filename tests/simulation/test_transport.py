"""Transport against SciPy, PhiFlow, closed forms and identities."""

import numpy as np
import pytest
import warp as wp
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter, map_coordinates

from warpfluid.kernels.fluid import totals
from warpfluid.simulation.state import Faces, face_shape, six_sides
from warpfluid.simulation.transport import SCHEMES, advect_scalar, advect_scalars, advect_velocity, keep_total

BOXES = {
    "open": six_sides("open", "open", "open"),
    "closed": six_sides("closed", "closed", "closed"),
    "wrap": six_sides("wrap", "wrap", "wrap"),
    "mixed": six_sides("wrap", "closed-high", "closed-low"),
}
PERIODS = {"open": (0, 0, 0), "closed": (0, 0, 0), "wrap": (1, 1, 1), "mixed": (1, 0, 0)}


def on(device, array):
    return wp.array(np.ascontiguousarray(array), dtype=float, device=device)


def faces(parts, device):
    return Faces(*(on(device, part) for part in parts))


def uniform(shape, velocity, device):
    return faces([np.full(face_shape(shape, axis), v) for axis, v in enumerate(velocity)], device)


def swirl(shape, seed=0, speed=3.0, closed=False):
    """A smooth velocity [voxel/s] of which the faces that wrapping joins agree."""
    rng = np.random.default_rng(seed)
    parts = []
    for axis in range(3):
        part = gaussian_filter(rng.standard_normal(shape), 2, mode="wrap")
        part = np.concatenate([part, part.take([0], axis)], axis) * speed / np.abs(part).max()
        if closed:
            np.moveaxis(part, axis, 0)[[0, -1]] = 0
        parts.append(part.astype(np.float32))
    return parts


def noise(shape, seed=1):
    return np.random.default_rng(seed).standard_normal(shape).astype(np.float32)


def at_places(shape, place):
    """Coordinates of the voxels' centres (3), or of the faces along an axis, in those of the centres."""
    coordinates = np.indices(shape if place == 3 else face_shape(shape, place)).astype(float)
    if place < 3:
        coordinates[place] -= 0.5
    return coordinates


def read(field, at, name, place=3):
    """Interpolate linearly at coordinates of the centres, by SciPy: zeros or the border beyond, or the box again."""
    at = np.array(at, dtype=float)
    if place < 3:
        at[place] += 0.5
    for axis, wraps in enumerate(PERIODS[name]):
        if wraps:
            period = field.shape[axis] - (axis == place)
            at[axis] %= period
            if axis != place:
                field = np.concatenate([field, field.take([0], axis)], axis)
    kinds = np.array(BOXES[name]).reshape(3, 2)
    for axis in range(3):
        if not PERIODS[name][axis] and place == 3:  # zeros beyond open sides
            pads = [(0, 0)] * 3
            pads[axis] = (1, 1)
            field = np.pad(field, pads, mode="edge")
            for side, where in ((0, 0), (1, -1)):
                if kinds[axis, side] == 0:
                    np.moveaxis(field, axis, 0)[where] = 0
            at[axis] += 1
    return map_coordinates(field.astype(float), at, order=1, mode="nearest")


def trace(velocity, shape, name, place, time_step):
    """The midpoint rule, with SciPy."""
    here = at_places(shape, place)

    def sample(at):
        return np.array([read(part, at, name, axis) for axis, part in enumerate(velocity)])

    return here + time_step * sample(here + 0.5 * time_step * sample(here))


@pytest.mark.parametrize("name", BOXES)
@pytest.mark.parametrize("place", [0, 1, 2, 3])
def test_semi_lagrangian_agrees_with_scipy(name, place, device):
    """The midpoint rule and linear interpolation, in every kind of box, up to and beyond its sides."""
    shape, time_step = (9, 12, 53), 0.7
    velocity = swirl(shape, speed=4)
    source = trace(velocity, shape, name, place, -time_step)
    if place == 3:
        field = noise(shape)
        out = advect_scalar(
            on(device, field), faces(velocity, device), BOXES[name], time_step, scheme="semi-lagrangian"
        )
    else:
        moved = swirl(shape, seed=7, speed=1)
        field = moved[place]
        out = advect_velocity(
            faces(moved, device), faces(velocity, device), BOXES[name], time_step, scheme="semi-lagrangian"
        )[place]
    np.testing.assert_allclose(out.numpy(), read(field, source, name, place), atol=3e-5)


@pytest.mark.parametrize("name", BOXES)
def test_maccormack_agrees_with_its_definition(name, device):
    """Half the error of going back and forth is taken off where that stays inside, and the eight values bound it."""
    shape, time_step = (9, 12, 53), 0.7
    velocity, field = swirl(shape, speed=4), noise(shape)
    back, forth = (trace(velocity, shape, name, 3, sign * time_step) for sign in (-1, 1))
    carried = read(field, back, name)
    raw = carried + 0.5 * (field - read(carried, forth, name))
    inside = [at if wraps else at.clip(0, n - 1) for at, n, wraps in zip(back, shape, PERIODS[name], strict=True)]
    corners = [np.floor(inside) + np.array(corner).reshape(3, 1, 1, 1) for corner in np.ndindex(2, 2, 2)]
    corners = [
        [at if wraps else at.clip(0, n - 1) for at, n, wraps in zip(corner, shape, PERIODS[name], strict=True)]
        for corner in corners
    ]
    values = [read(field, corner, name) for corner in corners]
    values.append(np.where(read(np.ones(shape), back, name) < 1 - 1e-6, 0, values[0]))
    expected = np.clip(raw, np.min(values, axis=0), np.max(values, axis=0))
    leaves = np.zeros(shape, bool)
    for axis in range(3):
        if not PERIODS[name][axis]:
            for at in (back[axis], forth[axis]):
                leaves |= (at < -0.5) | (at > shape[axis] - 0.5)
    expected = np.where(leaves, carried, expected)
    out = advect_scalar(on(device, field), faces(velocity, device), BOXES[name], time_step, scheme="maccormack")
    near_a_cell = np.abs(back - np.round(back)).min(axis=0) < 1e-4  # rounding decides which eight values
    assert near_a_cell.mean() < 0.01
    assert 0.05 < leaves.mean() < 0.95 or name == "wrap"
    np.testing.assert_allclose(out.numpy()[~near_a_cell], expected[~near_a_cell], atol=1e-4)


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("name", ["closed", "wrap"])
def test_constant_fields_stay_constant(scheme, name, device):
    """Nothing thins out or piles up by interpolation."""
    shape = (10, 9, 49)
    velocity = faces(swirl(shape, speed=9, closed=name == "closed"), device)
    out = advect_scalar(on(device, np.full(shape, 0.3)), velocity, BOXES[name], 0.5, scheme=scheme)
    assert np.all(out.numpy() == np.float32(0.3))
    moved = uniform(shape, (0.3, -0.7, 1.9), device)
    for part, value in zip(
        advect_velocity(moved, velocity, BOXES[name], 0.5, scheme=scheme), (0.3, -0.7, 1.9), strict=True
    ):
        assert np.all(part.numpy() == np.float32(value))


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("name", BOXES)
def test_rest_changes_nothing(scheme, name, device):
    """Bit for bit, but for the spline, which rounds."""
    shape = (8, 7, 50)
    rest, field, moved = Faces.zeros(shape, device), noise(shape), swirl(shape)
    tolerance = 5e-6 if scheme == "cubic" else 0
    out = advect_scalar(on(device, field), rest, BOXES[name], 0.5, scheme=scheme)
    np.testing.assert_allclose(out.numpy(), field, rtol=0, atol=tolerance)
    for part, before in zip(
        advect_velocity(faces(moved, device), rest, BOXES[name], 0.5, scheme=scheme), moved, strict=True
    ):
        np.testing.assert_allclose(part.numpy(), before, rtol=0, atol=3 * tolerance)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_whole_steps_round_a_periodic_box_return(scheme, device):
    """Uniform motion by whole voxels is exact; the faces that wrapping joins stay equal."""
    shape = (6, 8, 50)
    velocity, field, moved = uniform(shape, (3, -4, 25), device), noise(shape), swirl(shape)
    once = advect_scalar(on(device, field), velocity, BOXES["wrap"], 1.0, scheme=scheme)
    np.testing.assert_allclose(once.numpy(), np.roll(field, (3, -4, 25), (0, 1, 2)), atol=5e-6)
    twice = advect_scalar(once, velocity, BOXES["wrap"], 1.0, scheme=scheme)
    np.testing.assert_allclose(twice.numpy(), field, atol=1e-5)
    out = advect_velocity(faces(moved, device), velocity, BOXES["wrap"], 2.0, scheme=scheme)
    for axis, (part, before) in enumerate(zip(out, moved, strict=True)):
        np.testing.assert_allclose(part.numpy(), before, atol=3e-5)
        np.testing.assert_array_equal(part.numpy().take(0, axis), part.numpy().take(-1, axis))


@pytest.mark.parametrize("scheme", ["maccormack", "bfecc", "cubic"])
def test_rotation_halves_the_error_of_linear_interpolation(scheme, device):
    """A notched cylinder (Zalesak 1979) after a quarter turn."""
    n, steps = 50, 30
    shape, middle, angle = (n, n, 4), (n - 1) / 2, 0.5 * np.pi / 30
    x, z, _ = np.indices(shape) - middle

    def cylinder(x, z):
        inside = np.hypot(x - 11, z) < 10
        return gaussian_filter((inside & ~((np.abs(z) < 2) & (x < 14))).astype(np.float32), (1, 1, 0))

    parts = [np.zeros(face_shape(shape, axis)) for axis in range(3)]
    parts[0] += -angle * (np.arange(n) - middle).reshape(1, -1, 1)
    parts[1] += angle * (np.arange(n) - middle).reshape(-1, 1, 1)
    velocity, expected = faces(parts, device), cylinder(z, -x)
    errors = {}
    for name in ("semi-lagrangian", scheme):
        field = on(device, cylinder(x, z))
        for _ in range(steps):
            field = advect_scalar(field, velocity, BOXES["closed"], 1.0, scheme=name)
        errors[name] = np.abs(field.numpy() - expected).mean()
    assert errors[scheme] < 0.5 * errors["semi-lagrangian"]


@given(st.integers(0, 2**32 - 1), st.floats(-2, 2), st.sampled_from(SCHEMES), st.sampled_from(sorted(BOXES)))
def test_makes_no_new_extrema(seed, time_step, scheme, name):
    """Whatever the velocity, forth or back in time."""
    shape = (7, 6, 11)
    velocity = faces(swirl(shape, seed, speed=8), "cpu")
    field, moved = np.abs(noise(shape, seed)), swirl(shape, seed + 1)
    out = advect_scalar(on("cpu", field), velocity, BOXES[name], time_step, scheme=scheme).numpy()
    lowest = field.min() if name in ("closed", "wrap") else 0
    assert lowest <= out.min()
    assert out.max() <= field.max()
    for part, before in zip(
        advect_velocity(faces(moved, "cpu"), velocity, BOXES[name], time_step, scheme=scheme), moved, strict=True
    ):
        assert before.min() <= part.numpy().min()
        assert part.numpy().max() <= before.max()


def test_several_fields_share_the_paths(device):
    """The same bits as one by one."""
    shape = (9, 8, 20)
    velocity = faces(swirl(shape), device)
    fields = [on(device, noise(shape, seed)) for seed in range(3)]
    together = advect_scalars(fields, velocity, BOXES["open"], 0.4, scheme="maccormack")
    for field, out in zip(fields, together, strict=True):
        alone = advect_scalar(field, velocity, BOXES["open"], 0.4, scheme="maccormack")
        np.testing.assert_array_equal(out.numpy(), alone.numpy())


def test_an_unknown_scheme_is_refused(device):
    """With the names of those there are."""
    with pytest.raises(ValueError, match="maccormack"):
        advect_velocity(
            Faces.zeros((3, 3, 3), device), Faces.zeros((3, 3, 3), device), BOXES["open"], 1, scheme="euler"
        )


def whirl(at):
    """Taylor and Green's, in a box of side 1: velocity along x and z at (x, z)."""
    x, z = 2 * np.pi * at
    return 0.1 * np.array([np.sin(x) * np.cos(z), -np.cos(x) * np.sin(z)])


def traced_back(at, seconds, steps=40):
    """Follow the whirl back in time (fourth-order Runge-Kutta)."""
    step = -seconds / steps
    for _ in range(steps):
        a = whirl(at)
        b = whirl(at + 0.5 * step * a)
        c = whirl(at + 0.5 * step * b)
        at = at + step * (a + 2 * b + 2 * c + whirl(at + step * c)) / 6
    return at


@pytest.mark.parametrize(("scheme", "at_least"), [("maccormack", 1.7), ("bfecc", 1.7), ("semi-lagrangian", 0.7)])
def test_order_of_convergence(scheme, at_least, device):
    """A steady whirl winds up its own components: how fast the mean error falls with voxels and steps."""
    errors = []
    for n in (32, 64):
        shape, steps = (n, n, 1), n // 4
        at = [(at_places(shape, axis)[:2] + 0.5) / n for axis in range(3)]
        velocity = faces([whirl(at[0])[0] * n, whirl(at[1])[1] * n, np.zeros(face_shape(shape, 2))], device)
        moved = velocity
        for _ in range(steps):
            moved = advect_velocity(moved, velocity, BOXES["wrap"], 2.0 / steps, scheme=scheme)
        errors.append(np.abs(moved.x.numpy() / n - whirl(traced_back(at[0], 2.0))[0]).mean())
    assert at_least < np.log2(errors[0] / errors[1]) < at_least + 0.6


@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_number_of_threads_does_not_matter(scheme, device, monkeypatch):
    """The same bits with one thread and with three."""
    shape = (37, 8, 60)
    velocity, field = faces(swirl(shape), device), on(device, noise(shape))
    found = []
    for threads in ("1", "3"):
        monkeypatch.setenv("WARPFLUID_THREADS", threads)
        found.append(advect_scalar(field, velocity, BOXES["mixed"], 0.3, scheme=scheme).numpy())
        found[-1] = [
            found[-1],
            *(part.numpy() for part in advect_velocity(velocity, velocity, BOXES["mixed"], 0.3, scheme=scheme)),
        ]
    for one, three in zip(*found, strict=True):
        np.testing.assert_array_equal(one, three)


def test_memory_of_the_caller_is_used(device):
    """The same values, in the arrays that were given."""
    shape = (9, 8, 20)
    velocity, field = faces(swirl(shape), device), on(device, noise(shape))
    out, faces_out = wp.empty_like(field), Faces(*(wp.empty_like(part) for part in velocity))
    for scheme in SCHEMES:
        expected = advect_scalar(field, velocity, BOXES["open"], 0.4, scheme=scheme).numpy()
        assert advect_scalar(field, velocity, BOXES["open"], 0.4, scheme=scheme, out=out) is out
        np.testing.assert_array_equal(out.numpy(), expected)
        expected = advect_velocity(velocity, velocity, BOXES["open"], 0.4, scheme=scheme)
        advect_velocity(velocity, velocity, BOXES["open"], 0.4, scheme=scheme, out=faces_out)
        for part, there in zip(faces_out, expected, strict=True):
            np.testing.assert_array_equal(part.numpy(), there.numpy())


@pytest.mark.parametrize("factor", [0.25, 1.0, 3.0])
def test_the_total_is_kept(factor, device):
    """By a common factor, to the precision of the numbers; nothing comes of nothing."""
    field = np.abs(noise((9, 8, 70)))
    wanted = factor * totals.total(on(device, field))
    assert wanted == pytest.approx(factor * field.sum(dtype=float), rel=1e-12)
    kept = keep_total(on(device, field), wanted).numpy()
    np.testing.assert_allclose(kept, factor * field, rtol=1e-6)
    assert kept.sum(dtype=float) == pytest.approx(wanted, rel=1e-7)
    empty = wp.zeros((4, 4, 4), dtype=float, device=device)
    assert not keep_total(empty, 1.0).numpy().any()


@pytest.mark.filterwarnings("ignore:Field.closest_values:DeprecationWarning")
@pytest.mark.parametrize("scheme", ["semi-lagrangian", "maccormack"])
def test_agrees_with_phiflow(scheme, device):
    """An independent solver, in a periodic box; its paths are straight, so the velocity is uniform here."""
    flow = pytest.importorskip("phi.flow")
    shape, velocity = (12, 10, 14), (1.3, -0.45, 2.7)
    field = gaussian_filter(noise(shape), 1, mode="wrap")
    tensor = flow.math.tensor(field, flow.spatial("x,y,z"))
    grid = flow.CenteredGrid(tensor, flow.extrapolation.PERIODIC, flow.Box(x=12, y=10, z=14))
    wind = flow.CenteredGrid(velocity, flow.extrapolation.PERIODIC, flow.Box(x=12, y=10, z=14), x=12, y=10, z=14)
    method = {"semi-lagrangian": flow.advect.semi_lagrangian, "maccormack": flow.advect.mac_cormack}[scheme]
    theirs = method(grid, wind, 0.8).values.numpy("x,y,z")
    ours = advect_scalar(on(device, field), uniform(shape, velocity, device), BOXES["wrap"], 0.8, scheme=scheme)
    np.testing.assert_allclose(ours.numpy(), theirs, atol=2e-6)
