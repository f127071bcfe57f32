"""Lightness and wind against their laws."""

import numpy as np
import pytest
import warp as wp
from mac import ALL_CLOSED, ALL_OPEN, SHAPE, SIDES, face_means, pushed, random_faces, six, still, without_walls, wraps

from warpfluid.kernels.forces.air import add_buoyancy, add_wind

CALM = {"temperature_buoyancy": 2.0, "density_buoyancy": -0.5, "reference": 40.0, "time_step": 0.1}


def smoke(device, seed=1):
    """A temperature and a density."""
    rng = np.random.default_rng(seed)
    arrays = {"temperature": rng.random(SHAPE), "density": 100 * rng.random(SHAPE)}
    return {name: wp.array(array, dtype=float, device=device) for name, array in arrays.items()}


@pytest.mark.parametrize("sides", SIDES)
def test_buoyancy_is_the_law(sides, device):
    """The mean of both voxels' lift, along any direction, never through a wall."""
    fields, up, faces = smoke(device), (3.0, -1.0, 9.8), random_faces(sides=sides)
    lift = 2 * fields["temperature"].numpy().astype(float) - 0.5 * fields["density"].numpy() / 40
    changes = without_walls([0.1 * g * mean for g, mean in zip(up, face_means(lift, sides), strict=True)], sides)
    got = pushed(add_buoyancy, faces, device, **fields, up=up, sides=six(sides), **CALM)
    for axis in range(3):
        np.testing.assert_allclose(got[axis], faces[axis] + changes[axis], atol=2e-6)
        if wraps(sides, axis):
            ends = np.moveaxis(got[axis], axis, 0)
            np.testing.assert_array_equal(ends[0], ends[-1])


def test_hot_gas_rises_and_smoke_sinks(device):
    """The signs that an artist expects."""
    full, none = np.ones(SHAPE), np.zeros(SHAPE)
    for temperature, density, sign in ((full, none, 1), (none, full, -1)):
        fields = {"temperature": temperature, "density": density}
        fields = {name: wp.array(field, dtype=float, device=device) for name, field in fields.items()}
        got = pushed(add_buoyancy, still(), device, **fields, up=(0, 0, 9.8), sides=six(ALL_CLOSED), **CALM)
        assert (sign * got[2][..., 1:-1] > 0).all()
        assert not got[0].any()
        assert not got[1].any()


@pytest.mark.parametrize(
    "nothing", [{"up": (0.0, 0.0, 0.0)}, {"temperature_buoyancy": 0.0, "density_buoyancy": 0.0}, {"time_step": 0.0}]
)
def test_no_lift_keeps_the_bits(nothing, device):
    """Not even -0 becomes 0."""
    faces = [-face * (face > 0) for face in random_faces()]
    got = pushed(
        add_buoyancy, faces, device, **smoke(device), sides=six(ALL_OPEN), **({"up": (0, 0, 9.8)} | CALM | nothing)
    )
    for before, after in zip(faces, got, strict=True):
        np.testing.assert_array_equal(before.view(np.int32), after.view(np.int32))


@pytest.mark.parametrize("masked", [False, True])
@pytest.mark.parametrize("sides", SIDES)
def test_wind_is_the_law(sides, masked, device):
    """An exponential approach, slower where the mask is thin."""
    faces, wind = random_faces(sides=sides), (3.0, -1.0, 0.5)
    mask = np.random.default_rng(2).random(SHAPE) if masked else None
    covers = face_means(mask, sides) if masked else [np.ones(face.shape) for face in faces]
    changes = [(w - u) * (1 - np.exp(-2 * 0.1 * c)) for w, u, c in zip(wind, faces, covers, strict=True)]
    changes = without_walls(changes, sides)
    mask = wp.array(mask, dtype=float, device=device) if masked else None
    got = pushed(add_wind, faces, device, wind=wind, rate=2.0, time_step=0.1, sides=six(sides), mask=mask)
    for before, change, after in zip(faces, changes, got, strict=True):
        np.testing.assert_allclose(after, before + change, atol=1e-6)


def test_wind_leaves_components_alone(device):
    """Those that are None, bit for bit."""
    faces = random_faces()
    got = pushed(add_wind, faces, device, wind=(1.0, None, None), rate=2.0, time_step=0.1, sides=six(ALL_OPEN))
    assert np.abs(got[0] - faces[0]).min() > 0
    for before, after in zip(faces[1:], got[1:], strict=True):
        np.testing.assert_array_equal(before, after)


def test_wind_does_not_depend_on_the_step(device):
    """Four short steps are one long one, and a strong wind takes everything along."""
    faces = random_faces()
    wind = {"wind": (1.0, 2.0, 3.0), "rate": 4.0, "sides": six(ALL_OPEN)}
    once = pushed(add_wind, faces, device, time_step=0.4, **wind)
    often = faces
    for _ in range(4):
        often = pushed(add_wind, often, device, time_step=0.1, **wind)
    for a, b in zip(once, often, strict=True):
        np.testing.assert_allclose(a, b, atol=2e-6)
    storm = pushed(add_wind, faces, device, time_step=1e3, **wind)
    assert [np.unique(face).tolist() for face in storm] == [[1], [2], [3]]


@pytest.mark.parametrize("nothing", [{"rate": 0.0}, {"time_step": 0.0}, {"mask": 0.0}])
def test_no_wind_keeps_the_bits(nothing, device):
    """No rate, no time or an empty mask."""
    faces = random_faces()
    if "mask" in nothing:
        nothing = {"mask": wp.zeros(SHAPE, dtype=float, device=device)}
    others = {"wind": (1.0, 2.0, 3.0), "rate": 4.0, "time_step": 0.1} | nothing
    got = pushed(add_wind, faces, device, sides=six(ALL_OPEN), **others)
    for before, after in zip(faces, got, strict=True):
        np.testing.assert_array_equal(before, after)


def test_any_number_of_threads_gives_the_same_bits(monkeypatch):
    """One thread or three."""
    results = []
    for threads in ("1", "3"):
        monkeypatch.setenv("WARPFLUID_THREADS", threads)
        faces = random_faces((40, 7, 53))
        mask = wp.array(np.random.default_rng(0).random((40, 7, 53)), dtype=float, device="cpu")
        results.append(pushed(add_wind, faces, "cpu", rate=2.0, time_step=0.1, sides=six(ALL_OPEN), mask=mask))
    for a, b in zip(*results, strict=True):
        np.testing.assert_array_equal(a, b)


def test_refuses_senseless_numbers(device):
    """A rate below 0 grows, a reference of 0 divides by it."""
    with pytest.raises(ValueError, match="rate"):
        pushed(add_wind, still(), device, rate=-1.0, time_step=0.1, sides=six(ALL_OPEN))
    others = CALM | {"reference": 0.0}
    with pytest.raises(ValueError, match="reference"):
        pushed(add_buoyancy, still(), device, **smoke(device), up=(0, 0, 1), sides=six(ALL_OPEN), **others)
