"""The projector pair: exact transpose, closed forms, and the projectors of others."""

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st

from warpfluid.projector import Projector

FOOTPRINTS = ["box", "joseph"]
ANY_ANGLES = st.lists(st.floats(-400, 400), min_size=1, max_size=5)
ODD_ANGLES = [0, 0.5, 20, 44.9, 45, 70, 90, 130, 179.3, 251]


def centred(n):
    """Distance of the voxels or pixels from the middle of the box."""
    return np.arange(n) - (n - 1) / 2


def inside_circle(n, margin=1):
    """Voxels (x, z) that no view loses at its edge."""
    return np.hypot(centred(n)[:, None], centred(n)) <= n / 2 - margin


def random_volume(n, heights, seed=0):
    rng = np.random.default_rng(seed)
    return (rng.random((n, n, heights)) * inside_circle(n)[..., None]).astype(np.float32)


def matrix(angle_deg, n, footprint):
    """B of one view and one height, shape (u, x, z), in float64: how far a voxel's footprint covers a pixel."""
    angle = np.deg2rad(angle_deg)
    m = max(abs(np.cos(angle)), abs(np.sin(angle)))
    u = centred(n)[:, None, None]
    q = centred(n)[:, None] * np.cos(angle) + centred(n) * np.sin(angle)
    if footprint == "box":
        return np.maximum(np.minimum(q + m / 2, u + 0.5) - np.maximum(q - m / 2, u - 0.5), 0) / m
    return np.maximum(1 - np.abs(q - u) / m, 0) / m


def relative(found, expected):
    return np.abs(found - expected).max() / np.abs(expected).max()


@given(
    n=st.integers(1, 40),
    heights=st.integers(1, 110),
    angles=ANY_ANGLES,
    footprint=st.sampled_from(FOOTPRINTS),
    masked=st.booleans(),
    seed=st.integers(0, 99),
)
@settings(max_examples=60)
def test_back_projection_is_the_exact_transpose(device, n, heights, angles, footprint, masked, seed):
    """<B x, y> = <x, B' y> for data of zero mean, relative to the size that this product itself has."""
    rng = np.random.default_rng(seed)
    hull = (rng.random((n, n, heights)) < 0.3).astype(np.float32) if masked else None
    projector = Projector(angles, (n, n, heights), hull=hull, footprint=footprint, device=device)
    x = rng.standard_normal(projector.shape).astype(np.float32) * (1 if hull is None else hull)
    y = rng.standard_normal(projector.image_shape).astype(np.float32)
    forward, back = projector.project(x).astype(np.float64), projector.backproject(y).astype(np.float64)
    size = np.linalg.norm(forward) * np.linalg.norm(y.astype(np.float64)) / np.sqrt(y.size)
    assert abs((forward * y).sum() - (x * back).sum()) <= 1e-5 * size


@given(
    n=st.integers(1, 24),
    heights=st.integers(1, 51),
    angles=ANY_ANGLES,
    footprint=st.sampled_from(FOOTPRINTS),
    seed=st.integers(0, 99),
)
@settings(max_examples=40)
def test_agrees_with_a_dense_matrix(device, n, heights, angles, footprint, seed):
    """Both directions, up to the edges of box and detector; the matrix is made of overlaps of intervals."""
    rng = np.random.default_rng(seed)
    volume, images = rng.random((n, n, heights)), rng.random((len(angles), n, heights))
    dense = np.stack([matrix(angle, n, footprint) for angle in angles])
    projector = Projector(angles, volume.shape, footprint=footprint, device=device)
    found = projector.project(volume.astype(np.float32))
    np.testing.assert_allclose(found, np.einsum("auxz,xzy->auy", dense, volume), atol=1e-5 * n)
    found = projector.backproject(images.astype(np.float32))
    np.testing.assert_allclose(found, np.einsum("auxz,auy->xzy", dense, images), atol=1e-5 * len(angles))


@given(
    n=st.integers(4, 30),
    part=st.tuples(*[st.floats(0, 1)] * 4),
    angles=ANY_ANGLES,
    footprint=st.sampled_from(FOOTPRINTS),
    seed=st.integers(0, 99),
)
@settings(max_examples=40)
def test_a_part_of_the_box_is_seen_as_in_the_box(device, n, part, angles, footprint, seed):
    """A volume that begins at a corner projects as the whole, and back-projection is cut out of the whole's."""
    rng = np.random.default_rng(seed)
    corner = [int(share * (n - 1)) for share in part[:2]]
    shape = [1 + int(share * (n - 1 - low)) for low, share in zip(corner, part[2:], strict=True)]
    cut = tuple(slice(low, low + length) for low, length in zip(corner, shape, strict=True))
    volume = np.zeros((n, n, 50), np.float32)
    volume[cut] = rng.random((*shape, 50))
    whole = Projector(angles, volume.shape, footprint=footprint, device=device)
    small = Projector(angles, (*shape, 50), footprint=footprint, device=device, corner=corner, width=n)
    assert small.image_shape == whole.image_shape
    np.testing.assert_allclose(small.project(volume[cut]), whole.project(volume), atol=1e-5 * n)
    images = rng.random(whole.image_shape).astype(np.float32)
    np.testing.assert_allclose(small.backproject(images), whole.backproject(images)[cut], atol=1e-5 * len(angles))


@pytest.mark.parametrize("footprint", FOOTPRINTS)
def test_a_hull_changes_nothing_inside_it(footprint, device):
    """Rays that skip what lies outside still see all of the inside; back-projection is 0 outside."""
    rng = np.random.default_rng(4)
    n, heights = 33, 101
    blobs = [(8, 9, 20), (24, 20, 60), (16, 27, 95)]
    at = np.stack(np.meshgrid(np.arange(n), np.arange(n), np.arange(heights), indexing="ij"), axis=-1)
    hull = np.min([np.linalg.norm(at - blob, axis=-1) for blob in blobs], axis=0) < 5
    volume = (rng.random(hull.shape) * hull).astype(np.float32)
    masked = Projector(ODD_ANGLES, hull.shape, hull=hull.astype(np.float32), footprint=footprint, device=device)
    free = Projector(ODD_ANGLES, hull.shape, footprint=footprint, device=device)
    np.testing.assert_array_equal(masked.project(volume), free.project(volume))
    images = rng.random(free.image_shape).astype(np.float32)
    np.testing.assert_array_equal(masked.backproject(images), free.backproject(images) * hull)


@pytest.mark.parametrize("footprint", FOOTPRINTS)
def test_a_gaussian_blob_has_its_closed_form(footprint, device):
    """Every view of an isotropic Gaussian is one, too."""
    assert blob_error(72, 48, ODD_ANGLES, footprint, device) < 2e-3


@pytest.mark.slow
@pytest.mark.parametrize("footprint", FOOTPRINTS)
def test_a_gaussian_blob_at_the_size_of_the_paper(footprint, device):
    """The error falls as the square of the resolution."""
    assert blob_error(271, 24, np.arange(0, 180, 10), footprint, device) < 2e-4


def blob_error(n, heights, angles_deg, footprint, device):
    """Relative L2 error of the views of a blob whose deviation is a tenth of the box."""
    sigma, (x, z) = n / 10, (n * 0.07, -n * 0.05)
    along_y = np.exp(-0.5 * (centred(heights) / sigma) ** 2)
    from_centre = np.hypot(centred(n)[:, None] - x, centred(n) - z)
    volume = np.exp(-0.5 * (from_centre / sigma) ** 2)[..., None] * along_y
    radians = np.deg2rad(angles_deg)
    at = (x * np.cos(radians) + z * np.sin(radians))[:, None]
    views = np.sqrt(2 * np.pi) * sigma * np.exp(-0.5 * ((centred(n) - at) / sigma) ** 2)[..., None] * along_y
    found = Projector(angles_deg, volume.shape, footprint=footprint, device=device).project(volume)
    return np.linalg.norm(found - views) / np.linalg.norm(views)


@pytest.mark.parametrize("footprint", FOOTPRINTS)
def test_a_disc_shows_its_chords(footprint, device):
    """A ray through a disc of density 1 measures the chord, 2 sqrt(R^2 - u^2)."""
    n, radius, fine = 64, 25.3, 8
    at = centred(n * fine) / fine
    covered = (np.hypot(at[:, None], at) < radius).reshape(n, fine, n, fine).mean(axis=(1, 3))
    found = Projector(ODD_ANGLES, (n, n, 1), footprint=footprint, device=device).project(covered[..., None])
    within = np.abs(centred(n)) < radius - 2
    chords = 2 * np.sqrt(radius**2 - centred(n)[within] ** 2)
    np.testing.assert_allclose(found[:, within, 0], np.tile(chords, (len(ODD_ANGLES), 1)), rtol=0.01)


def test_the_box_keeps_a_voxels_light_in_every_view(device):
    """A voxel is as bright from every side: what the default footprint is for."""
    angles = np.arange(0, 360, 1.0)
    seen = one_voxel_totals("box", angles, device)
    np.testing.assert_allclose(seen, 1, atol=3e-7)


def test_joseph_does_not(device):
    """Interpolation along rows lets a voxel's brightness swing between 0.83 and 1.41."""
    seen = one_voxel_totals("joseph", np.arange(0, 180, 1.0), device)
    assert seen.min() < 0.85
    assert seen.max() > 1.4


def one_voxel_totals(footprint, angles_deg, device):
    """The totals of voxels here and there, each on a height of its own, shape (angle, voxel)."""
    volume = np.zeros((21, 21, 3), np.float32)
    for height, (x, z) in enumerate([(10, 10), (13, 6), (5, 9)]):
        volume[x, z, height] = 1
    return Projector(angles_deg, volume.shape, footprint=footprint, device=device).project(volume).sum(axis=1)


def test_all_views_have_the_same_row_sums(device):
    """The check of footage rests on it."""
    volume = random_volume(35, 50)
    sums = Projector(ODD_ANGLES, volume.shape, device=device).project(volume).sum(axis=1, dtype=np.float64)
    expected = volume.sum(axis=(0, 1), dtype=np.float64)
    np.testing.assert_allclose(sums, np.tile(expected, (len(ODD_ANGLES), 1)), rtol=1e-6)


@pytest.mark.parametrize("footprint", FOOTPRINTS)
def test_front_and_side_are_sums_along_the_axes(footprint, device):
    """x to the right and z towards the viewer at 0 degrees; z to the right at 90."""
    volume = np.random.default_rng(0).integers(0, 99, (20, 20, 50)).astype(np.float32)
    found = Projector([0, 90, 180, 270], volume.shape, footprint=footprint, device=device).project(volume)
    front, side = volume.sum(axis=1), volume.sum(axis=0)
    np.testing.assert_array_equal(found, [front, side, front[::-1], side[::-1]])


@pytest.mark.parametrize("footprint", FOOTPRINTS)
@pytest.mark.parametrize("angle", [0, 10, 20, 30, 40])
def test_exchanging_x_and_z_exchanges_the_angles(angle, footprint, device):
    """Bit by bit: t sees of a volume what 90 - t sees of the transposed one."""
    volume = random_volume(31, 50)
    transposed = np.ascontiguousarray(volume.transpose(1, 0, 2))
    here = Projector([angle], volume.shape, footprint=footprint, device=device).project(volume)
    there = Projector([90 - angle], volume.shape, footprint=footprint, device=device).project(transposed)
    np.testing.assert_array_equal(here, there)


@pytest.mark.parametrize("footprint", FOOTPRINTS)
def test_a_quarter_turn_of_the_volume_is_a_quarter_turn_of_the_camera(footprint, device):
    """x becomes z, z becomes -x."""
    volume = random_volume(30, 50)
    turned = np.ascontiguousarray(volume[::-1].transpose(1, 0, 2))
    angles = np.array(ODD_ANGLES)
    here = Projector(angles + 90, volume.shape, footprint=footprint, device=device).project(volume)
    there = Projector(angles, volume.shape, footprint=footprint, device=device).project(turned)
    assert relative(here, there) < 2e-6


@pytest.mark.parametrize("footprint", FOOTPRINTS)
def test_half_a_turn_shows_the_mirror_image(footprint, device):
    """The view at t + 180 is the view at t, flipped."""
    volume = random_volume(29, 50)
    angles = np.array(ODD_ANGLES)
    here = Projector(angles, volume.shape, footprint=footprint, device=device).project(volume)
    there = Projector(angles + 180, volume.shape, footprint=footprint, device=device).project(volume)
    assert relative(there[:, ::-1], here) < 2e-6


def test_joseph_agrees_with_astra(device):
    """ASTRA's ``linear`` projector on a small grid; its rows go down and its rays along -y."""
    astra = pytest.importorskip("astra")
    n, angles = 21, [0, 20, 45, 70, 90, 130]
    volume = random_volume(n, 1)
    geometry = astra.create_proj_geom("parallel", 1.0, n, -np.deg2rad(angles))
    projector = astra.create_projector("linear", geometry, astra.create_vol_geom(n, n))
    number, expected = astra.create_sino(np.ascontiguousarray(volume[..., 0].T), projector)
    astra.data2d.delete(number)
    astra.projector.delete(projector)
    found = Projector(angles, volume.shape, footprint="joseph", device=device).project(volume)[..., 0]
    assert relative(found, expected) < 1e-5


def test_resembles_the_radon_transform_of_scikit_image(device):
    """Which turns the picture and adds up its columns."""
    radon = pytest.importorskip("skimage.transform").radon
    n, angles = 41, [0, 15, 45, 80, 90, 135]
    x = centred(n)
    volume = np.exp(-((x[:, None] - 6) ** 2 + 2 * (x + 4) ** 2) / 60) + 0.5 * np.exp(
        -((x[:, None] + 7) ** 2 + (x - 5) ** 2) / 12
    )
    volume *= inside_circle(n)
    expected = radon(volume.T, theta=-np.array(angles), circle=True).T
    found = Projector(angles, (n, n, 1), device=device).project(volume[..., None])[..., 0]
    assert np.corrcoef(found.ravel(), expected.ravel())[0, 1] > 0.999


def test_weights_count_views(device):
    """A factor a view in back-projection."""
    images = np.random.default_rng(0).random((3, 12, 7)).astype(np.float32)
    projector = Projector([0, 33, 90], (12, 12, 7), device=device)
    expected = projector.backproject(images * np.array([2, 0, 5], np.float32)[:, None, None])
    np.testing.assert_allclose(projector.backproject(images, weights=[2, 0, 5]), expected, rtol=1e-6)


def test_operators_and_kinds_of_arrays(device):
    """``B @ v`` and ``B.T @ o``; NumPy gives NumPy, Warp gives Warp, ``out`` is used."""
    volume = random_volume(12, 9)
    projector = Projector([10, 100], volume.shape, device=device)
    images = projector @ volume
    assert isinstance(images, np.ndarray)
    np.testing.assert_array_equal(projector(volume), images)
    back = projector.T @ images
    np.testing.assert_array_equal(projector.T(images), back)
    np.testing.assert_array_equal(projector.T.T @ volume, images)
    array = wp.array(volume, dtype=float, device=device)
    out = wp.empty(projector.image_shape, dtype=float, device=device)
    assert projector.project(array, out=out) is out
    np.testing.assert_array_equal(out.numpy(), images)
    assert isinstance(projector.T @ out, wp.array)


def test_any_number_of_threads_gives_the_same_bits(monkeypatch):
    """One thread or three."""
    volume = random_volume(40, 70)
    results = []
    for threads in ("1", "3"):
        monkeypatch.setenv("WARPFLUID_THREADS", threads)
        projector = Projector(ODD_ANGLES, volume.shape, device="cpu")
        images = projector.project(volume)
        results.append((images, projector.backproject(images)))
    for one, three in zip(*results, strict=True):
        np.testing.assert_array_equal(one, three)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"angles_deg": []}, "angles_deg"),
        ({"angles_deg": [0, np.nan]}, "angles_deg"),
        ({"shape": (8, 9, 5)}, "shape"),
        ({"shape": (8, 8)}, "shape"),
        ({"shape": (8, 8, 0)}, "shape"),
        ({"hull": np.ones((8, 8, 6), np.float32)}, "hull"),
        ({"footprint": "splat"}, "footprint"),
        ({"corner": (1, 0)}, "corner"),
        ({"corner": (-1, 0)}, "corner"),
        ({"device": "cuda:77"}, "device"),
    ],
)
def test_refuses_what_makes_no_sense(change, word):
    """The message names the argument."""
    with pytest.raises(ValueError, match=word):
        Projector(**{"angles_deg": [0], "shape": (8, 8, 5), "device": "cpu", **change})


@pytest.mark.parametrize("shape", [(8, 8, 6), (8, 8), (1, 8, 5)])
def test_refuses_arrays_of_another_shape(shape, device):
    """Volume and images, before a kernel reads beyond them."""
    projector = Projector([0], (8, 8, 5), device=device)
    with pytest.raises(ValueError, match="volume"):
        projector.project(np.zeros(shape, np.float32))
    if shape != (1, 8, 5):
        with pytest.raises(ValueError, match="images"):
            projector.backproject(np.zeros(shape, np.float32))
