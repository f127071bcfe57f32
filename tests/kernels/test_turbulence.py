"""The turbulent force: free of divergence, as strong, as fine and as restless as asked for."""

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st
from mac import ALL_CLOSED, ALL_OPEN, ALL_WRAP, MIXED, SHAPE, pushed, random_faces, six, still, wraps
from scipy import fft

from warpfluid.kernels.forces.random_waves import NODES_A_WAVE, make_waves
from warpfluid.kernels.forces.turbulence import add_turbulence

PLAIN = {"strength": 2.0, "frequency": 0.1, "phase": 0.3, "octaves": 1, "seed": 0, "time_step": 1.0}


def force(shape, device, sides=ALL_OPEN, **others):
    """The force on the faces of a box."""
    return pushed(add_turbulence, still(shape), device, sides=six(sides), **(PLAIN | others))


def divergence(faces):
    return sum(np.diff(face.astype(float), axis=axis) for axis, face in enumerate(faces))


def centred(faces):
    """The force in the voxels, (3, x, z, y)."""
    means = []
    for axis, face in enumerate(faces):
        ends = np.moveaxis(face, axis, 0)
        means.append(np.moveaxis((ends[1:] + ends[:-1]) / 2, 0, axis))
    return np.array(means)


def size(faces):
    """Root mean square of the vectors."""
    return np.sqrt(sum(np.mean(face.astype(float) ** 2) for face in faces))


def blob(shape):
    """A mask that is 1 in the middle and 0 in the outer third."""
    place = np.meshgrid(*(np.linspace(-1, 1, n) for n in shape), indexing="ij")
    return np.clip(1.5 - 2 * np.sqrt(sum(p**2 for p in place)), 0, 1)


@pytest.mark.parametrize("masked", [False, True])
@pytest.mark.parametrize("sides", [ALL_OPEN, ALL_WRAP, ALL_CLOSED, MIXED])
def test_has_no_divergence(sides, masked, device):
    """To rounding; at walls, where the force ends, that is the pressure's work."""
    shape = (40, 31, 50)
    mask = wp.array(blob(shape), dtype=float, device=device) if masked else None
    faces = force(shape, device, sides, octaves=2, frequency=0.06, mask=mask)
    inside = tuple(slice(1, -1) if sides in (ALL_CLOSED, MIXED) else slice(None) for _ in range(3))
    gradient = np.sqrt(np.mean(np.diff(faces[0], axis=0) ** 2))
    assert np.abs(divergence(faces))[inside].max() < 1e-5 * gradient
    assert gradient > 0.01


@pytest.mark.parametrize("octaves", [1, 3])
@pytest.mark.parametrize("seed", [0, 1])
def test_is_as_strong_as_asked_for(seed, octaves, device):
    """The root mean square of the vectors, equally along all axes."""
    faces = force((96, 80, 90), device, seed=seed, octaves=octaves, frequency=0.06 if octaves > 1 else 0.12)
    assert size(faces) == pytest.approx(2, rel=0.05)
    for face in faces:
        assert np.sqrt(np.mean(face**2)) == pytest.approx(2 / np.sqrt(3), rel=0.08)


@pytest.mark.parametrize("frequency", [0.06, 0.1, 0.2])
def test_spectrum_peaks_at_the_frequency(frequency, device):
    """And lies within half an octave of it, in every direction."""
    n = 80
    window = np.hanning(n)
    window = window[:, None, None] * window[:, None] * window
    field = centred(force((n, n, n), device, frequency=frequency))
    power = (np.abs(np.fft.fftn(field * window, axes=(1, 2, 3))) ** 2).sum(0)
    grid = np.meshgrid(*[np.fft.fftfreq(n)] * 3, indexing="ij")
    length = np.sqrt(sum(k**2 for k in grid))
    energy, edges = np.histogram(length, bins=np.arange(0, 0.5, 0.01), weights=power)
    assert edges[energy.argmax()] + 0.005 == pytest.approx(frequency, rel=0.2)
    band = (length > frequency / 1.6) & (length < frequency * 1.6)
    assert power[band].sum() > 0.95 * power.sum()
    shares = [(power * (np.abs(k) > 0.8 * length)).sum() / power.sum() for k in grid]
    assert max(shares) < 1.35 * min(shares)


def test_is_the_curl_of_the_waves(device):
    """Summed up one by one in float64; splines add a few percent at most."""
    shape, nodes, frequency = (30, 24, 26), (128,) * 3, 0.1
    waves = make_waves(nodes, (1.0,) * 3, 7, 0)
    turns = NODES_A_WAVE * frequency * waves.cycles  # [cycles/voxel]
    response = np.prod([(2 + np.cos(2 * np.pi * k)) / 3 for k in waves.cycles], axis=0)
    mirrored = np.where(waves.cycles[2] == 0, 1, 2)
    turned = waves.amplitude * np.exp(0.3j * waves.pace) * response * mirrored
    curl = 2j * np.sin(np.pi * turns)
    curl = np.cross(curl.T, turned.T).T
    faces = force(shape, device, seed=7)
    rng = np.random.default_rng(0)
    expected, got = [], []
    for axis in range(3):
        for _ in range(30):
            index = rng.integers(0, shape)
            place = index - (np.arange(3) == axis) / 2 - [14.5, 11.5, -0.5]
            expected.append((curl[axis] * np.exp(2j * np.pi * (place @ turns))).sum().real)
            got.append(faces[axis][tuple(index)])
    ratio = np.dot(expected, got) / np.dot(expected, expected)
    np.testing.assert_allclose(got, ratio * np.array(expected), atol=0.1)
    assert np.corrcoef(expected, got)[0, 1] > 0.999


def test_does_not_depend_on_the_resolution(device):
    """Twice the voxels and half the frequency: the same force at the same place."""
    coarse = centred(force((20, 16, 24), device))
    fine = centred(force((40, 32, 48), device, frequency=0.05))
    fine = fine.reshape(3, 20, 2, 16, 2, 24, 2).mean(axis=(2, 4, 6))
    assert np.corrcoef(coarse.ravel(), fine.ravel())[0, 1] > 0.99
    assert np.std(fine) == pytest.approx(np.std(coarse), rel=0.1)


def test_changes_gradually(device):
    """A moment later it is nearly the same, after a phase of 1 little of it is left, and it never comes back."""
    now, soon, later, late = (centred(force((60, 60, 60), device, phase=p)).ravel() for p in (5, 5.01, 6, 25))
    assert np.std(soon - now) < 0.03 * np.std(now)
    assert np.std(soon - now) > 0
    assert abs(np.corrcoef(now, later)[0, 1]) < 0.3
    assert abs(np.corrcoef(now, late)[0, 1]) < 0.1
    assert np.std(late) == pytest.approx(np.std(now), rel=0.08)


def test_has_no_period(device):
    """The pattern is not like itself anywhere else in a box of 24 waves."""
    n = 96
    field = force((n, n, n), device, frequency=0.25)[2][..., :n]
    likeness = fft.irfftn(np.abs(fft.rfftn(field - field.mean(), s=(2 * n,) * 3)) ** 2)
    lag = np.abs(np.fft.fftfreq(2 * n, 1 / (2 * n)))
    overlap = np.maximum(n - lag, 1)
    likeness /= likeness[0, 0, 0] / n**3 * overlap[:, None, None] * overlap[:, None] * overlap
    lag = np.maximum(lag[:, None, None], np.maximum(lag[:, None], lag))
    assert np.abs(likeness[(lag > 12) & (lag < 72)]).max() < 0.2


@given(
    shape=st.tuples(st.integers(1, 20), st.integers(1, 20), st.integers(1, 60)),
    frequency=st.floats(0.01, 0.5),
    sides=st.sampled_from([ALL_WRAP, MIXED, ALL_OPEN]),
)
@settings(max_examples=15)
def test_repeats_where_the_box_wraps(shape, frequency, sides):
    """Both ends are the same face, boxes of any size have no seam, and numbers are finite."""
    faces = force(shape, "cpu", sides, frequency=frequency)
    for axis, face in enumerate(faces):
        assert np.isfinite(face).all()
        if wraps(sides, axis):
            ends = np.moveaxis(face, axis, 0)
            np.testing.assert_array_equal(ends[0], ends[-1])
    if sides != MIXED:
        assert np.abs(divergence(faces)).max() <= 1e-4 * max(size(faces), 1e-9)


def test_wrapped_waves_fit(device):
    """Across the seam the force is as smooth as elsewhere, and as strong."""
    faces = force((64, 50, 70), device, ALL_WRAP, frequency=0.07)
    assert size(faces) == pytest.approx(2, rel=0.15)
    for axis, face in enumerate(faces):
        for across in {0, 1, 2} - {axis}:
            steps = np.moveaxis(np.diff(np.concatenate([face, face], across), axis=across), across, 0)
            seam = steps[face.shape[across] - 1]
            assert np.sqrt(np.mean(seam**2)) < 1.5 * np.sqrt(np.mean(steps**2))


def test_a_mask_confines_it(device):
    """Nothing at all where it is 0, the same bits well inside where it is 1."""
    shape = (30, 30, 50)
    mask = np.zeros(shape)
    mask[8:20, 5:20, 10:40] = 1
    free = force(shape, device)
    masked = force(shape, device, mask=wp.array(mask, dtype=float, device=device))
    for axis in range(3):
        for end in (slice(None, -1), slice(1, None)):
            part = tuple(end if k == axis else slice(None) for k in range(3))
            assert not masked[axis][part][mask == 0].any()
        np.testing.assert_array_equal(masked[axis][9:19, 6:19, 11:39], free[axis][9:19, 6:19, 11:39])


def test_seeds_and_octaves(device):
    """Another seed is another pattern, octaves too fine for the grid are left out, walls are not pushed."""
    shape = (40, 20, 30)
    first, again, other = (force(shape, device, seed=s) for s in (3, 3, 4))
    np.testing.assert_array_equal(first[0], again[0])
    assert abs(np.corrcoef(first[0].ravel(), other[0].ravel())[0, 1]) < 0.2
    fine = [force(shape, device, frequency=0.2, octaves=o)[1] for o in (1, 4)]
    np.testing.assert_array_equal(*fine)
    two = [force(shape, device, octaves=o)[1] for o in (1, 2)]
    assert not np.array_equal(*two)
    assert not force(shape, device, ALL_CLOSED)[2][..., [0, -1]].any()


@pytest.mark.parametrize("nothing", [{"strength": 0.0}, {"time_step": 0.0}])
def test_no_strength_keeps_the_bits(nothing, device):
    """Not even -0 becomes 0."""
    faces = [-face * (face > 0) for face in random_faces()]
    got = pushed(add_turbulence, faces, device, sides=six(ALL_OPEN), **(PLAIN | nothing))
    for before, after in zip(faces, got, strict=True):
        np.testing.assert_array_equal(before.view(np.int32), after.view(np.int32))


def test_any_number_of_threads_gives_the_same_bits(monkeypatch):
    """One thread or three."""
    results = []
    for threads in ("1", "3"):
        monkeypatch.setenv("WARPFLUID_THREADS", threads)
        mask = wp.array(blob((40, 30, 60)), dtype=float, device="cpu")
        results.append(force((40, 30, 60), "cpu", octaves=2, mask=mask))
    for a, b in zip(*results, strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("wrong", [{"frequency": 0.0}, {"octaves": 0}, {"octaves": 7}, {"seed": -1}])
def test_refuses_senseless_numbers(wrong, device):
    """Each is named."""
    with pytest.raises(ValueError, match=next(iter(wrong))):
        force(SHAPE, device, **wrong)
