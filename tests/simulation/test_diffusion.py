"""Diffusion against closed forms, SciPy's transforms and identities."""

import numpy as np
import pytest
import warp as wp
from scipy import fft

from warpfluid.simulation.state import Faces, face_shape, six_sides
from warpfluid.simulation.transport import diffuse

BOXES = {name: six_sides(name, name, name) for name in ("open", "closed", "wrap")}


def on(device, array):
    return wp.array(np.ascontiguousarray(array), dtype=float, device=device)


def noise(shape, seed=1):
    return np.random.default_rng(seed).random(shape).astype(np.float32)


def eigenvalues(n, period):
    return 2 - 2 * np.cos(2 * np.pi * np.arange(n) / period)


def damped(field, amount, periods, forward, backward):
    """Solve the heat equation of neighbouring differences in the transform that makes it diagonal."""
    spectrum = forward(field.astype(float))
    for axis, period in enumerate(periods):
        decay = np.exp(-amount * eigenvalues(field.shape[axis], period))
        spectrum = spectrum * decay.reshape([-1 if k == axis else 1 for k in range(3)])
    return backward(spectrum).real


@pytest.mark.parametrize("amount", [0.003, 0.4, 7.0, 300.0])
def test_agrees_with_the_cosine_transform_in_a_closed_box(amount, device):
    """Walls mirror: the heat equation is diagonal in the cosine transform, for far more than the box, too."""
    field = noise((9, 12, 55))
    expected = damped(field, amount, [2 * n for n in field.shape], fft.dctn, fft.idctn)
    out = diffuse(on(device, field), amount, BOXES["closed"]).numpy()
    np.testing.assert_allclose(out, expected, atol=2e-6)


@pytest.mark.parametrize("amount", [0.003, 0.4, 7.0])
def test_agrees_with_the_fourier_transform_in_a_periodic_box(amount, device):
    """And the faces that wrapping joins stay equal."""
    field = noise((9, 12, 55))
    expected = damped(field, amount, field.shape, fft.fftn, fft.ifftn)
    np.testing.assert_allclose(diffuse(on(device, field), amount, BOXES["wrap"]).numpy(), expected, atol=2e-6)
    parts = [np.concatenate([part := noise((9, 12, 55), axis), part.take([0], axis)], axis) for axis in range(3)]
    out = diffuse(Faces(*(on(device, part) for part in parts)), amount, BOXES["wrap"])
    for axis, (part, before) in enumerate(zip(out, parts, strict=True)):
        whole = part.numpy()
        np.testing.assert_array_equal(whole.take(0, axis), whole.take(-1, axis))
        before = np.delete(before, -1, axis)
        expected = damped(before, amount, before.shape, fft.fftn, fft.ifftn)
        np.testing.assert_allclose(np.delete(whole, -1, axis), expected, atol=2e-6)


@pytest.mark.parametrize("amount", [0.003, 0.4, 7.0])
def test_walls_hold_what_flows_through_and_let_slip_what_flows_along(amount, device):
    """In a closed box a velocity is diagonal in the sine transform along its own axis, the cosine transform across."""
    shape = (9, 12, 55)
    parts = [noise(face_shape(shape, axis), axis) for axis in range(3)]
    for axis, part in enumerate(parts):
        np.moveaxis(part, axis, 0)[[0, -1]] = 0
    out = diffuse(Faces(*(on(device, part) for part in parts)), amount, BOXES["closed"])
    for axis, (part, before) in enumerate(zip(out, parts, strict=True)):
        inner = np.delete(before, [0, -1], axis).astype(float)
        others = [k for k in range(3) if k != axis]
        spectrum = fft.dctn(fft.dst(inner, 1, axis=axis), axes=others)
        for k in range(3):
            waves = np.arange(inner.shape[k]) + (k == axis)
            decay = np.exp(-amount * (2 - 2 * np.cos(np.pi * waves / shape[k])))
            spectrum *= decay.reshape([-1 if k == j else 1 for j in range(3)])
        expected = fft.idst(fft.idctn(spectrum, axes=others), 1, axis=axis)
        np.testing.assert_allclose(np.delete(part.numpy(), [0, -1], axis), expected, atol=3e-6)
        np.testing.assert_allclose(np.moveaxis(part.numpy(), axis, 0)[[0, -1]], 0, atol=1e-6)


@pytest.mark.parametrize("amount", [0.01, 0.3, 2.5])
def test_the_variance_of_a_blob_grows_by_twice_the_amount(amount, device):
    """Along each axis, and a diffusion in two halves is the whole."""
    n = 61
    field = np.zeros((n, n, n), np.float32)
    field[30, 30, 30] = 1
    out = diffuse(on(device, field), amount, BOXES["open"])
    places = np.arange(n) - 30
    for axis in range(3):
        profile = out.numpy().sum(axis=tuple(k for k in range(3) if k != axis), dtype=float)
        np.testing.assert_allclose((profile * places**2).sum(), 2 * amount, rtol=2e-5)
    halves = diffuse(diffuse(on(device, field), amount / 2, BOXES["open"]), amount / 2, BOXES["open"])
    np.testing.assert_allclose(halves.numpy(), out.numpy(), atol=1e-6)


def test_keeps_the_total_unless_a_side_is_open(device):
    """Closed and periodic boxes lose nothing; an open one does."""
    field = noise((10, 11, 60))
    for name, kept in (("closed", 1.0), ("wrap", 1.0), ("open", 0.95)):
        share = diffuse(on(device, field), 3.0, BOXES[name]).numpy().sum(dtype=float) / field.sum(dtype=float)
        if name == "open":
            assert share < kept
        else:
            assert share == pytest.approx(kept, abs=1e-6)


def test_an_open_box_is_one_in_still_air(device):
    """As in a larger box with nothing around; uniform velocities stay as they are."""
    field = noise((9, 8, 52))
    large = diffuse(on(device, np.pad(field, 12)), 1.5, BOXES["open"]).numpy()
    out = diffuse(on(device, field), 1.5, BOXES["open"]).numpy()
    np.testing.assert_allclose(out, large[12:-12, 12:-12, 12:-12], atol=1e-6)
    wind = Faces(*(on(device, np.full(face_shape((9, 8, 52), axis), 2.0)) for axis in range(3)))
    for part in diffuse(wind, 1.5, BOXES["open"]):
        np.testing.assert_allclose(part.numpy(), 2, rtol=1e-6)


def test_without_strength_the_bits_are_equal(device):
    """In place as well; and a field may be written over."""
    field = noise((7, 8, 50))
    array = on(device, field)
    np.testing.assert_array_equal(diffuse(array, 0.0, BOXES["open"]).numpy(), field)
    expected = diffuse(array, 0.7, BOXES["closed"]).numpy()
    assert diffuse(array, 0.7, BOXES["closed"], out=array) is array
    np.testing.assert_array_equal(array.numpy(), expected)


def test_negative_strength_is_refused(device):
    """It would sharpen without bound."""
    with pytest.raises(ValueError, match="variance"):
        diffuse(on(device, noise((4, 4, 4))), -1.0, BOXES["open"])
