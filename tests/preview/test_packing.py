"""Volumes for a page: nothing lit is lost, ray sums stay, and the budget holds."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from warpfluid.files.npz import write_npz
from warpfluid.preview import packing
from warpfluid.volumes import VolumeSequence, open_volumes


def sequence(folder, volumes) -> VolumeSequence:
    """Write volumes (x, z, y) as files of another program, whose grey levels are their own."""
    for frame, volume in enumerate(volumes, 1):
        write_npz(folder / f"v.{frame:04d}.npz", volume.swapaxes(1, 2), frame=frame)
    found = open_volumes(folder)
    return VolumeSequence(name="v", files=found.files)


def blob(shape, centre, radius):
    places = np.indices(shape) - np.array(centre).reshape(3, 1, 1, 1)
    return (40 * np.maximum(1 - (places**2).sum(axis=0) / radius**2, 0)).astype(np.float32)


@pytest.fixture
def moving(tmp_path):
    """A ball that rises in a box of odd sizes."""
    return [blob((21, 19, 33), (9, 8, y), 4.6) for y in (8, 14, 20)], tmp_path


def test_what_is_lit_is_found(moving):
    """The extent holds every lit voxel of every frame and one empty voxel about them; sums and peak are NumPy's."""
    volumes, folder = moving
    extent = packing.measure(sequence(folder, volumes), (1, 2, 3))
    lit = np.argwhere(np.sum(volumes, axis=0) > 0)
    assert extent.box == (21, 19, 33)
    assert extent.low == tuple(lit.min(axis=0) - 1)
    assert extent.high == tuple(lit.max(axis=0) + 2)
    assert extent.peak == np.max(volumes)
    np.testing.assert_allclose(extent.lights, [volume.sum() for volume in volumes], rtol=1e-6)


def test_light_at_the_edges_stays(tmp_path):
    """Where there is no room about the lit voxels, the extent ends with the box."""
    volume = np.ones((5, 5, 7), np.float32)
    extent = packing.measure(sequence(tmp_path, [volume]), (1,))
    assert (extent.low, extent.high) == ((0, 0, 0), (5, 5, 7))


def test_an_empty_volume_is_a_volume(tmp_path):
    """One without light packs and comes back empty."""
    volumes = sequence(tmp_path, [np.zeros((6, 6, 9), np.float32)])
    extent = packing.measure(volumes, (1,))
    (text,) = packing.pack(volumes, (1,), extent, extent.size)
    assert not packing.unpack(text, extent.size, extent.peak).any()


def test_frames_of_unlike_sizes_are_refused(tmp_path):
    """They could not be played in one box."""
    volumes = sequence(tmp_path, [np.ones((5, 5, 7), np.float32), np.ones((5, 5, 8), np.float32)])
    with pytest.raises(ValueError, match=r"frame 2 has \(5, 5, 8\)"):
        packing.measure(volumes, (1, 2))


@given(st.integers(0, 2**31), st.floats(1e-3, 1e3))
def test_a_byte_a_voxel_is_enough(seed, peak):
    """Density comes back within half a step of its root; ray sums are off by far less than a grey level in 255."""
    rng = np.random.default_rng(seed)
    volume = (peak * rng.random((9, 8, 7)) ** 4).astype(np.float32)
    volumes = FakeVolumes([volume])
    extent = packing.measure(volumes, (0,))
    (text,) = packing.pack(volumes, (0,), extent, extent.size)
    back = packing.unpack(text, extent.size, extent.peak)
    np.testing.assert_allclose(np.sqrt(back / peak), np.sqrt(volume / peak), atol=0.51 / packing.LEVELS)
    white = volume.sum(axis=1).max()
    assert np.abs(back.sum(axis=1) - volume.sum(axis=1)).max() < white * 4 / 255


class FakeVolumes:
    """Volumes in memory."""

    name = "memory"

    def __init__(self, volumes):
        self.volumes = volumes

    def density(self, frame):
        return self.volumes[frame]


@given(st.integers(1, 12), st.integers(1, 12), st.integers(0, 99))
def test_coarse_voxels_are_means(fine, coarse, seed):
    """Means stay, constants stay, and whole ratios are block means."""
    volume = np.random.default_rng(seed).random((fine, 3, 2)).astype(np.float32)
    small = packing.coarsen(volume, (coarse, 3, 2))
    np.testing.assert_allclose(small.mean(axis=0), volume.mean(axis=0), rtol=1e-5)
    np.testing.assert_allclose(packing.coarsen(np.ones((fine, 3, 2)), (coarse, 1, 2)), 1, rtol=1e-6)
    if fine % coarse == 0:
        blocks = volume.reshape(coarse, fine // coarse, 3, 2).mean(axis=1)
        np.testing.assert_allclose(small, blocks, rtol=1e-5)


@pytest.mark.parametrize("share", [2.0, 0.7, 0.3, 0.1])
def test_budgets_hold(share):
    """What fits stays as it is; the rest gets coarser by no more than it must."""
    rng = np.random.default_rng(1)
    volumes = FakeVolumes([rng.random((24, 24, 36)).astype(np.float32) * (rng.random() + 0.5) for _ in range(6)])
    frames = tuple(range(6))
    extent = packing.measure(volumes, frames)
    whole = sum(map(len, packing.pack(volumes, frames, extent, extent.size)))
    size, packed = packing.pack_within(volumes, frames, extent, share * whole)
    used = sum(map(len, packed)) / (share * whole)
    assert used <= 1
    assert (size == extent.size) == (share >= 1)
    assert share > 1 or used > 0.6


def test_hopeless_budgets_are_refused():
    """Rather than a page without anything to see; the ways out are named."""
    volumes = FakeVolumes([np.random.default_rng(2).random((24, 24, 24)).astype(np.float32)] * 3)
    extent = packing.measure(volumes, (0, 1, 2))
    with pytest.raises(ValueError, match=r"--frames, or a larger --html-size"):
        packing.pack_within(volumes, (0, 1, 2), extent, 300)
