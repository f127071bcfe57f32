"""
Light within a volume
=====================

Seconds of wall clock and of all cores for the parts of ``light_volume`` and for ground and bodies in a picture, with
the ratio to one projection of the same volume. Seconds of all cores say more where other work runs beside.

    python examples/benchmarks/light.py [--quick] [--size X Z Y] [--picture WIDTH HEIGHT] [--repeats N]
"""

import argparse
import resource
import time
from collections.abc import Callable
from statistics import median

import numpy as np
import warp as wp
from machine import describe
from scipy.ndimage import gaussian_filter

from warpfluid.device import pick_device
from warpfluid.projector import Projector
from warpfluid.rendering.camera import perspective
from warpfluid.rendering.harmonics import sky
from warpfluid.rendering.lighting import Lighting, Sun
from warpfluid.rendering.medium import Curve, Medium
from warpfluid.rendering.shadows import cast_shadows, extinction_of, gather_sky, light_volume
from warpfluid.rendering.surfaces import Ground, Surface, see
from warpfluid.simulation.triangles import turned_surface

SIZE, QUICK = (271, 271, 144), (64, 64, 48)
PICTURE, QUICK_PICTURE = (960, 540), (240, 135)


def cloud(shape: tuple[int, int, int]) -> np.ndarray:
    """Return ragged smoke in about a third of a box, at most 1."""
    noise = gaussian_filter(np.random.default_rng(0).standard_normal(shape, np.float32), max(shape) / 40)
    return np.clip(noise / noise.std() - 0.3, 0, 1).astype(np.float32)


def ball(radius: float, centre: tuple[float, float, float]) -> Surface:
    """Return a ball of some thousand triangles."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, 33)[1:-1]
    vertices, triangles = turned_surface(radius * np.cos(angles), radius * np.sin(angles), (-radius, radius))
    return Surface(vertices + np.asarray(centre), triangles)


def measure(job: Callable[[], object], repeats: int) -> tuple[float, float]:
    """Return the medians of wall seconds and of seconds of all cores."""
    job()
    times = []
    for _ in range(repeats):
        before, begin = resource.getrusage(resource.RUSAGE_SELF), time.perf_counter()
        job()
        after = resource.getrusage(resource.RUSAGE_SELF)
        cores = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
        times.append((time.perf_counter() - begin, cores))
    wall, cores = zip(*times, strict=True)
    return median(wall), median(cores)


def main() -> None:
    """Print a row a part."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--size", type=int, nargs=3)
    parser.add_argument("--picture", type=int, nargs=2)
    parser.add_argument("--repeats", type=int, default=3)
    asked = parser.parse_args()
    shape = tuple(asked.size or (QUICK if asked.quick else SIZE))
    picture = tuple(asked.picture or (QUICK_PICTURE if asked.quick else PICTURE))
    device = pick_device("cpu")
    print(describe(device))
    volume = wp.array(cloud(shape), device=device)
    smoke = {"fields": {"density": volume}, "extinction": Curve("density", 1.0, [0, 0.05])}
    medium = Medium(**smoke, albedo=Curve("density", 1.0, [0.8]))
    burning = Medium(**smoke, albedo=medium.albedo, emission=Curve("density", 1.0, [[0, 0, 0], [0.1, 0.03, 0.01]]))
    lighting = Lighting((Sun((1, 2, 1), (3, 3, 3)),), sky((1, 1, 1), (0.2, 0.2, 0.2)))
    extinction, inner = extinction_of(medium), light_volume(medium, lighting)
    camera = perspective(shape, 20, 12, distance=2.2 * max(shape), field_of_view_deg=35, size=picture)
    middle, radius = (shape[0] / 2, shape[2] / 6, shape[1] / 2), shape[2] / 6
    around = {"ground": Ground(shape), "inner": inner, "device": device}
    projector = Projector([30.0], shape)
    jobs = {
        "a projection": lambda: projector.project(volume),
        "shadows of a sun": lambda: cast_shadows(extinction, lighting.suns),
        "the same, half as fine": lambda: cast_shadows(extinction, lighting.suns, factor=2),
        "the sky": lambda: gather_sky(extinction, lighting.ambient, factor=2),
        "all: a sun, the sky, scattered": lambda: light_volume(medium, lighting),
        "the same of glowing smoke": lambda: light_volume(burning, lighting),
        "the ground": lambda: see([], camera, lighting, **around),
        "the ground and a ball": lambda: see([ball(radius, middle)], camera, lighting, **around),
    }
    times = {name: measure(job, asked.repeats) for name, job in jobs.items()}
    one = times["a projection"][1]
    print(f"{' x '.join(map(str, shape))} voxels (x, z, y), {picture[0]} x {picture[1]} pixels")
    for name, (wall, cores) in times.items():
        print(f"{name:32} {wall:8.3f} s   all cores {cores:8.3f} s   {cores / one:7.1f} projections")
    print(f"memory at most {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6:.2f} GB")


if __name__ == "__main__":
    main()
