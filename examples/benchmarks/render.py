"""
The ray marcher against a projection
====================================

Seconds of one picture of a volume of puffs, from three cameras, in one process, the candidates taking turns: the ray
sum, light that is given off and absorbed, and light of a sun that is scattered as well. Next to them one projection of
the same volume, a pixel a voxel, whose cost is the measure; the error against a march sixteen times as careful; and
how much memory was asked for at most.

    python examples/benchmarks/render.py [--quick] [--repeats N] [--device cpu|cuda:0]
"""

import argparse
import resource

import numpy as np
import warp as wp
from machine import describe, interleaved
from scipy.ndimage import gaussian_filter, zoom

import warpfluid as wf
from warpfluid.device import pick_device
from warpfluid.rendering.camera import Camera, orthographic, perspective
from warpfluid.rendering.lighting import Lighting, Sun
from warpfluid.rendering.marching import march
from warpfluid.rendering.medium import Curve, Medium
from warpfluid.rendering.shadows import light_volume

LINE = np.array([0.0, 1.0])
GLOW = np.linspace(0, 1, 64)[:, None] ** 2 * [1.0, 0.5, 0.2]
SUN = Sun(np.array([-1.0, 1.0, 0.4]), np.full(3, 3.0))


def puffs(width: int, height: int) -> np.ndarray:
    """Return a plume of smooth noise in empty air, shape (x, z, y), its brightest ray sum 255."""
    coarse = np.random.default_rng(0).standard_normal((width // 3 + 1, width // 3 + 1, height // 3 + 1))
    noise = zoom(gaussian_filter(coarse, 1.5), 3, order=1)[:width, :width, :height]
    x = np.arange(width) - 0.5 * (width - 1)
    radius = np.hypot(x[:, None], x)[..., None] / (0.3 * width * np.linspace(0.5, 1, height))
    volume = np.maximum(0.5 * noise / noise.std() + 1 - radius**2, 0)
    return (volume * 255 / volume.sum(axis=1).max()).astype(np.float32)


def cameras(shape: tuple[int, int, int], size: tuple[int, int]) -> dict[str, Camera]:
    """Return what the volume is seen from."""
    away = {"distance": 1.6 * shape[0], "field_of_view_deg": 30.0}
    return {
        "level": orthographic(shape, 0, size=size),
        "from above": orthographic(shape, 35, 15, size=size),
        "perspective": perspective(shape, 35, 10, size=size, **away),
    }


def media(density: wp.array, top: float) -> dict[str, tuple[Medium, dict]]:
    """Return what is rendered, and the light for it."""
    fields = {"density": density}
    extinction = Curve("density", top, 0.2 * LINE)
    smoke = Medium(fields=fields, extinction=extinction, albedo=Curve("density", top, np.full(2, 0.9)), anisotropy=0.3)
    lighting = Lighting((SUN,))
    lit = {"lighting": lighting, **light_volume(smoke, lighting).for_march()}
    return {
        "ray sum": (Medium(fields=fields, emission=Curve("density", 1, LINE)), {}),
        "glow and absorption": (Medium(fields=fields, extinction=extinction, emission=Curve("density", top, GLOW)), {}),
        "scattered sunlight": (smoke, lit),
    }


def measure(width: int, height: int, size: tuple[int, int], repeats: int, device: wp.Device) -> list[str]:
    """Return the lines of the table for one size."""
    volume = puffs(width, height)
    density = wp.array(volume, dtype=float, device=device)
    projector = wf.Projector([35.0], volume.shape, device=device)
    image = wp.empty(projector.image_shape, dtype=float, device=device)

    def project():
        projector.project(density, out=image)
        wp.synchronize_device(device)

    jobs, errors = {("projection", ""): project}, {}
    for kind, (medium, light) in media(density, float(volume.max())).items():
        for view, camera in cameras(volume.shape, size).items():
            arguments = {"medium": medium, "camera": camera, "density": False, **light}
            jobs[kind, view] = lambda arguments=arguments: march(**arguments)
            few = march(**arguments).color - march(**arguments, error=1 / 8192).color
            errors[kind, view] = f"{np.abs(few).max():.4f}, {np.abs(few).mean():.5f}"
    times = interleaved(jobs, repeats)
    unit = times["projection", ""]
    lines = [f"{'':34} seconds   over a projection   largest error, mean"]
    for (kind, view), taken in times.items():
        lines.append(
            f"{kind:20} {view:12}  {taken:8.4f}   {taken / unit:8.1f} x           {errors.get((kind, view), '')}"
        )
    return lines


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--quick", action="store_true", help="a small size only")
    parser.add_argument("--repeats", type=int, default=3, help="medians of so many")
    parser.add_argument("--device", default="cpu", help="where to compute")
    arguments = parser.parse_args()
    device = pick_device(arguments.device)
    print(describe(device))
    width, height, size = (64, 36, (160, 90)) if arguments.quick else (271, 144, (960, 540))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(f"\n{width} x {height} x {width} voxels at {size[0]} x {size[1]}, median of {arguments.repeats}")
    print("\n".join(measure(width, height, size, arguments.repeats, device)))
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    print(
        f"memory: {grown / 1024:.0f} MiB more than before, of which a volume is {4 * width * width * height >> 20} MiB"
    )


if __name__ == "__main__":
    main()
