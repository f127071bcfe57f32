"""
A paper-size frame, end to end
==============================

Seconds and peak memory of one frame of 271 x 144 x 271 voxels, 180 angles, 8 iterations, from a front and a side
view, and the share of each part. Two scenes made here: a fire, whose visual hull is a small part of the box, and a
cloud that fills the pictures, so that nothing can be skipped. Kernels are compiled before the clock starts. The parts
are timed in a run of their own, because the timers wait for the device.

    python examples/benchmarks/reconstruct.py [--quick] [--paper] [--device cpu|cuda:0]
"""

import argparse
import resource
from importlib.resources import files

import numpy as np
import warp as wp
from machine import describe, interleaved, seconds, timed_parts

import warpfluid as wf
from warpfluid.device import pick_device
from warpfluid.reconstruction import em, lsm
from warpfluid.reconstruction.appearance import AppearanceTransfer

PAPER_SIZE, QUICK_SIZE = (271, 144), (68, 36)

PARTS = (
    (wf.Projector, "project", "projections"),
    (wf.Projector, "backproject", "back-projections"),
    (AppearanceTransfer, "__init__", "M-step targets"),
    (AppearanceTransfer, "transfer", "M-step"),
    (em, "blur", "blurs"),
    (lsm, "blur", "blurs"),
)


def fire(size: tuple[int, int]) -> wf.Views:
    """Return the packaged fire, stretched to a size."""
    from scipy.ndimage import zoom

    samples = files("warpfluid") / "samples"
    small = wf.open_shot([(0, str(samples / "front.####.png")), (90, str(samples / "side.####.png"))]).views(8)
    factors = (1, size[0] / small.size[0], size[1] / small.size[1])
    return wf.Views(zoom(small.images, factors, order=1, grid_mode=True, mode="nearest"), (0, 90))


def cloud(size: tuple[int, int]) -> wf.Views:
    """Return a cloud that fills the pictures: smooth noise, the same light in each row of both views."""
    from scipy.ndimage import gaussian_filter

    rng = np.random.default_rng(0)
    images = np.stack([gaussian_filter(rng.random(size), 3) for _ in range(2)])
    images = 20 + 200 * (images - images.min()) / np.ptp(images)
    images *= images.sum(axis=1).mean(axis=0) / images.sum(axis=1, keepdims=True)
    return wf.Views(np.clip(images, 0, 255).astype(np.float32), (0, 90))


def peak_gigabytes() -> float:
    """Return the most memory this process has held so far [GB]; Linux counts in kB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9


def report(name: str, views: wf.Views, options: wf.ReconstructOptions, device: wp.Device) -> None:
    """Measure one scene and print it."""
    wf.reconstruct(views, options, device=device)
    whole = interleaved({"frame": lambda: wf.reconstruct(views, options, device=device)}, 3)["frame"]
    made = []
    with timed_parts(device, PARTS) as parts:
        total = seconds(lambda: made.append(wf.reconstruct(views, options, device=device)))
    width, height = views.size
    print(f"\n{name}: {width} x {height} x {width}, the hull fills {made[0].hull_share:.1%} of the box")
    print(f"{'one frame':18} {whole:7.2f} s   peak memory so far {peak_gigabytes():.2f} GB")
    parts["rest"] = total - sum(parts.values())
    for part, took in sorted(parts.items(), key=lambda item: -item[1]):
        print(f"  {part:16} {took:7.2f} s   {took / total:5.1%}")


def report_m_step(views: wf.Views, angles: int) -> None:
    """Measure the M-step of all views alone; it always runs on the host."""
    fan = tuple(np.arange(angles) * 180.0 / angles)
    transfer = AppearanceTransfer(views.images, views.angles_deg, fan)
    rendered = np.random.default_rng(0).random((angles, *views.size), np.float32) * views.images[0]
    mask = np.ones(rendered.shape, bool)
    taken = interleaved({"M-step": lambda: transfer.transfer(rendered, mask)}, 3)["M-step"]
    print(f"\nM-step of {angles} views of {views.size[0]} x {views.size[1]} alone: {taken:.2f} s")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--quick", action="store_true", help="a quarter of the size")
    parser.add_argument("--paper", action="store_true", help="the paper's choices")
    parser.add_argument("--device", default="cpu", help="where to compute")
    arguments = parser.parse_args()
    device, size = pick_device(arguments.device), QUICK_SIZE if arguments.quick else PAPER_SIZE
    options = wf.ReconstructOptions.paper() if arguments.paper else wf.ReconstructOptions(angles=180)
    print(describe(device))
    print(
        f"{options.iterations} iterations, {options.angles} angles, {'paper' if arguments.paper else 'default'} choices"
    )
    report("fire", fire(size), options, device)
    report("cloud, dense hull", cloud(size), options, device)
    report_m_step(fire(size), options.angles)


if __name__ == "__main__":
    main()
