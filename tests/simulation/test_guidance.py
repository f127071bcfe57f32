"""Guidance: Eqs. 8-10 to the letter, and matter that edits have carried away."""

import numpy as np
import warp as wp
from scipy.ndimage import gaussian_filter

from warpfluid.kernels.blur import blur
from warpfluid.kernels.fluid.guidance import blend, to_faces
from warpfluid.simulation.displacement import advance_displacement, displaced
from warpfluid.simulation.guidance import Footage, Motion, follow, on_faces, share_of
from warpfluid.simulation.state import Faces, face_shape, six_sides

SHAPE, SIGMA = (24, 24, 30), 2.0
SIDES = six_sides("open", "open", "open")


def faces(device, seed, shape=SHAPE):
    rng = np.random.default_rng(seed)
    parts = (rng.standard_normal(face_shape(shape, axis)) for axis in range(3))
    return Faces(*(wp.array(part, dtype=float, device=device) for part in parts))


def test_detail_of_velocity_stays(device):
    """psi' - G(omega) is psi - G(psi), and what G does not let through is untouched (Eqs. 8-9)."""
    velocity, omega = faces(device, 0), faces(device, 1)
    target = Faces(*(blur(part, SIGMA) for part in omega))
    guided = Motion(target, SIGMA, 1.0, SIDES, project=False).guided(velocity)
    for before, asked, after in zip(velocity, target, guided, strict=True):
        residual = before.numpy() - blur(before, SIGMA).numpy()
        np.testing.assert_allclose(after.numpy() - asked.numpy(), residual, atol=1e-5)
        spectra = [np.abs(np.fft.fftn(part.numpy()))[9:13, 9:13, 11:16] for part in (before, after)]
        np.testing.assert_allclose(spectra[1], spectra[0], rtol=1e-2)


def test_no_weight_keeps_bits(device):
    """A weight of 0 ignores the flow."""
    velocity = faces(device, 0)
    guided = Motion(faces(device, 1), SIGMA, 0.0, SIDES, project=False).guided(velocity)
    assert all((a.numpy() == b.numpy()).all() for a, b in zip(velocity, guided, strict=True))


def test_guiding_again_and_again_stays_bounded(device):
    """Eqs. 8-9 in every step end at a velocity whose slow part is the footage's; nothing grows."""
    velocity = faces(device, 0)
    rough = tuple(wp.array(part.numpy()[:24, :24, :30], dtype=float, device=device) for part in faces(device, 1))
    motion = Motion(on_faces(rough, 1.0, SIGMA), SIGMA, 1.0, SIDES, project=False)
    sizes = []
    for _ in range(60):
        velocity = motion.guided(velocity)
        sizes.append(max(float(np.abs(part.numpy()).max()) for part in velocity))
    assert sizes[-1] < 1.05 * sizes[20]


def test_density_is_only_added(device):
    """Eq. 10, piece by piece; with its other half and full weight the density becomes the volume."""
    rng = np.random.default_rng(2)
    d, v = rng.random((2, *SHAPE)).astype(np.float32)
    out = blend(wp.array(d, device=device), wp.array(v, device=device), add=0.2).numpy()
    np.testing.assert_allclose(out, np.where(d < v, 0.2 * v + 0.8 * d, d), atol=1e-6)
    whole = wp.array(d, device=device)
    follow(whole, wp.array(v, device=device), weight=1.0, subtract=1.0)
    np.testing.assert_allclose(whole.numpy(), v, atol=1e-6)


def test_halves_of_two_that_disagree_are_no_haze(device):
    """Noise drawn to other noise keeps the contrast of noise; a weight of 0 and a factor of 1 change nothing."""
    rng = np.random.default_rng(6)
    d, v = (wp.array(rng.random(SHAPE).astype(np.float32) ** 6, device=device) for _ in range(2))
    spread = {}
    for factor in (1.0, 2.0):
        share = share_of(v, d, weight=0.5, factor=factor, amounts=True)
        drawn = wp.clone(d)
        follow(drawn, v, weight=share, subtract=1.0)
        spread[factor] = drawn.numpy().std() / v.numpy().std()
    assert spread[1.0] < 0.75
    assert spread[2.0] > 0.95
    assert share_of(v, d, weight=0.5, factor=1.0, amounts=True) == 0.5
    assert share_of(v, d, weight=0.0, factor=2.0, amounts=True) == 0.0


def test_fine_eddies_do_not_tear_the_volume(device):
    """The way that matter has been carried is smooth where it counts: noise of two voxels leaves a volume whole."""
    rng = np.random.default_rng(7)
    away = tuple(wp.array(2 * rng.standard_normal(SHAPE).astype(np.float32), device=device) for _ in range(3))
    volume = gaussian_filter(rng.random(SHAPE), 2).astype(np.float32)
    moved = displaced(wp.array(volume, device=device), away).numpy()
    inside = (slice(4, -4),) * 3
    assert np.abs(np.diff(moved, axis=0))[inside].mean() < 1.3 * np.abs(np.diff(volume, axis=0))[inside].mean()


def test_faces_are_means_of_their_voxels(device):
    """The neighbours' mean, and the border's own value."""
    field = np.random.default_rng(3).random(SHAPE).astype(np.float32)
    for axis in range(3):
        out = wp.zeros(face_shape(SHAPE, axis), dtype=float, device=device)
        found = to_faces(wp.array(field, device=device), axis=axis, scale=2.0, out=out).numpy()
        padded = np.pad(field, [(int(k == axis),) * 2 for k in range(3)], mode="edge")
        low, high = (np.take(padded, range(n, n + out.shape[axis]), axis) for n in (0, 1))
        np.testing.assert_allclose(found, low + high, atol=1e-6)


def test_omega_of_a_moving_blob(device):
    """A blob that moves by (1, 2) voxels in x and y is found to, and nothing is seen of z from the front alone."""
    grid = np.indices((32, 32, 40))

    def blob(x, y):
        lumps = ((x + 3 * np.sin(k), 16, y + 3 * np.cos(2 * k)) for k in range(5))
        parts = (np.exp(-sum((g - m) ** 2 for g, m in zip(grid, lump, strict=True)) / 8) for lump in lumps)
        return wp.array(20 * sum(parts), dtype=float, device=device)

    footage = Footage((0.0,), (32, 32, 40), wp.get_device(device))
    x, z, y = footage.omega(blob(14, 16), blob(15, 18), method="tvl1", sigma=2.0)
    inside = blob(14, 16).numpy() > 5
    assert abs(x.numpy()[inside].mean() - 1) < 0.25
    assert abs(y.numpy()[inside].mean() - 2) < 0.25
    assert np.abs(z.numpy()).max() < 1e-6


def test_displacement_adds_up_and_moves_the_volume(device):
    """Fluid 24 voxels a second faster than asked gains one a frame of a 24th; half kept, it is one ahead in the end."""
    asked = Faces.zeros(SHAPE, wp.get_device(device))
    velocity = Faces(
        *(wp.full(part.shape, speed, dtype=float, device=device) for part, speed in zip(asked, (24, 0, 0), strict=True))
    )
    away = None
    sides = six_sides("wrap", "wrap", "wrap")
    for _ in range(3):
        away = advance_displacement(away, velocity, asked, sides, 1 / 24, keep=1.0)
    np.testing.assert_allclose(away[0].numpy(), 3, atol=1e-4)
    volume = np.pad(gaussian_filter(np.random.default_rng(4).random((12, 12, 18)), 1), 6).astype(np.float32)
    moved = displaced(wp.array(volume, device=device), away).numpy()
    np.testing.assert_allclose(moved[3:], volume[:-3], atol=1e-3)
    for _ in range(100):
        away = advance_displacement(away, velocity, asked, sides, 1 / 24, keep=0.5)
    np.testing.assert_allclose(away[0].numpy(), 1, atol=1e-4)
