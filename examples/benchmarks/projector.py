"""
Projector against its peers
===========================

Seconds of one projection and one back-projection of 180 views, in one process, the candidates taking turns. Peers
that are not installed get a row that says so. ASTRA (CPU) and scikit-image work slice by slice: a few slices are
timed and scaled. Their footprints differ, so only the sparse matrix is compared in value too.

    python examples/benchmarks/projector.py [--quick] [--repeats N] [--device cpu|cuda:0]
"""

import argparse
import importlib.util
from collections.abc import Callable

import numpy as np
import warp as wp
from machine import describe, interleaved

import warpfluid as wf
from warpfluid.device import pick_device

VIEWS = 180
ANGLES_DEG = np.arange(VIEWS) * (180.0 / VIEWS)
FEW = 3  # slices of the peers that work slice by slice

Pair = tuple[Callable[[], object], Callable[[], object], float, str]  # project, back-project, scale, note


def warpfluid_pair(volume: np.ndarray, images: np.ndarray, device: wp.Device) -> Pair:
    """Return the product's own pair, without a hull: every voxel counts."""
    projector = wf.Projector(ANGLES_DEG, volume.shape, device=device)
    v, o = wp.array(volume, dtype=float, device=device), wp.array(images, dtype=float, device=device)
    rendered, smeared = wp.empty_like(o), wp.empty_like(v)

    def project():
        projector.project(v, out=rendered)
        wp.synchronize_device(device)

    def backproject():
        projector.backproject(o, out=smeared)
        wp.synchronize_device(device)

    return project, backproject, 1.0, "all slices"


def sparse_pair(volume: np.ndarray, images: np.ndarray) -> Pair:
    """Return a scipy CSR matrix and its transpose, slices innermost: the strongest peer on a CPU."""
    matrix = box_matrix(volume.shape[0])
    transposed = matrix.T.tocsr()
    v = volume.reshape(-1, volume.shape[2])
    o = images.reshape(-1, images.shape[2])
    difference = (matrix @ v).reshape(images.shape) - wf.Projector(ANGLES_DEG, volume.shape, device="cpu").project(
        volume
    )
    return (
        lambda: matrix @ v,
        lambda: transposed @ o,
        1.0,
        f"all slices; {matrix.nnz / 1e6:.1f} M weights, differs by at most {np.abs(difference).max():.1e}",
    )


def box_matrix(width: int):
    """Return B of one slice with the same box footprint, float32, shape (angle and u, x and z)."""
    from scipy import sparse

    middle = (width - 1) / 2
    x, z = np.meshgrid(np.arange(width) - middle, np.arange(width) - middle, indexing="ij")
    blocks = []
    for radians in np.deg2rad(ANGLES_DEG):
        c, s = np.round([np.cos(radians), np.sin(radians)], 15)
        m = max(abs(c), abs(s))
        low = (x * c + z * s + middle + 0.5 * (1 - m)).ravel()
        first = np.floor(low).astype(np.int32)
        near = np.minimum((first + 1 - low) / m, 1)
        rows = np.concatenate([first, first + 1])
        columns = np.tile(np.arange(width * width, dtype=np.int32), 2)
        weights = np.concatenate([near, 1 - near]).astype(np.float32)
        seen = (weights > 1e-12) & (rows >= 0) & (rows < width)
        entries = weights[seen], (rows[seen], columns[seen])
        blocks.append(sparse.csr_matrix(entries, shape=(width, width * width)))
    return sparse.vstack(blocks, format="csr")


def astra_pair(volume: np.ndarray, images: np.ndarray) -> Pair:
    """Return ASTRA's CPU projector with linear interpolation, a few slices."""
    import astra

    width, _, heights = volume.shape
    detector = astra.create_proj_geom("parallel", 1.0, width, np.deg2rad(ANGLES_DEG))
    operator = astra.OpTomo(astra.create_projector("linear", detector, astra.create_vol_geom(width, width)))
    slices = [np.ascontiguousarray(volume[:, :, y]) for y in range(FEW)]
    sinograms = [np.ascontiguousarray(images[:, :, y]) for y in range(FEW)]
    return (
        lambda: [operator.FP(level) for level in slices],
        lambda: [operator.BP(sinogram) for sinogram in sinograms],
        heights / FEW,
        f"{FEW} of {heights} slices, scaled",
    )


def skimage_pair(volume: np.ndarray, images: np.ndarray) -> Pair:
    """Return scikit-image's radon and unfiltered iradon, one slice; not transposes of each other."""
    from skimage.transform import iradon, radon

    heights = volume.shape[2]
    across = np.arange(len(volume)) - (len(volume) - 1) / 2
    inside = np.hypot(across[:, None], across) < len(volume) / 2 - 1
    level = np.where(inside, volume[:, :, 0], 0)
    sinogram = np.ascontiguousarray(images[:, :, 0].T)
    return (
        lambda: radon(level, ANGLES_DEG),
        lambda: iradon(sinogram, ANGLES_DEG, filter_name=None),
        float(heights),
        f"1 of {heights} slices, scaled",
    )


def measure(width: int, heights: int, repeats: int, device: wp.Device) -> list[str]:
    """Return the lines of the table for one size."""
    rng = np.random.default_rng(0)
    volume = rng.random((width, width, heights), np.float32)
    images = rng.random((VIEWS, width, heights), np.float32)
    peers = {"scipy CSR": ("scipy", sparse_pair), "ASTRA CPU linear": ("astra", astra_pair)}
    peers["scikit-image"] = ("skimage", skimage_pair)
    pairs = {"warpfluid": warpfluid_pair(volume, images, device)}
    missing = []
    for name, (module, make) in peers.items():
        if importlib.util.find_spec(module):
            pairs[name] = make(volume, images)
        else:
            missing.append(f"{name:18}  not installed")
    jobs = {(name, way): pair[way] for name, pair in pairs.items() for way in (0, 1)}
    times = interleaved(jobs, repeats)
    ours = times["warpfluid", 0] + times["warpfluid", 1]
    lines = [f"{'':18} project [s]  back [s]   pair over ours"]
    for name, (_, _, scale, note) in pairs.items():
        forward, back = (times[name, way] * scale for way in (0, 1))
        lines.append(f"{name:18}  {forward:10.4f}  {back:8.4f}   {(forward + back) / ours:7.1f} x       {note}")
    return lines + missing


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--quick", action="store_true", help="a small size only")
    parser.add_argument("--repeats", type=int, default=5, help="medians of so many")
    parser.add_argument("--device", default="cpu", help="where warpfluid computes; the peers use the CPU")
    arguments = parser.parse_args()
    device = pick_device(arguments.device)
    print(describe(device))
    sizes = [(64, 36)] if arguments.quick else [(64, 36), (271, 144)]
    for width, heights in sizes:
        print(f"\n{VIEWS} views of {width} x {heights} x {width} voxels, median of {arguments.repeats}")
        print("\n".join(measure(width, heights, arguments.repeats, device)))


if __name__ == "__main__":
    main()
