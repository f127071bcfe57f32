"""
Optical flow against a known one
================================

Mean endpoint error [pixel] over a synthetic flame of 271 x 144 pixels: fractal texture in a flame's envelope, carried
by eddies and an upward draught. Columns give the mean displacement; under "change" the later picture is darker by 12
per cent and brighter by 0.02 all over, and both have noise of 2 grey levels, as footage of fire has. The last column is
the time of one pair.

    python examples/benchmarks/optical_flow.py [--quick] [--flows N] [--device cpu|cuda:0]
"""

import argparse

import numpy as np
from machine import describe, interleaved
from scipy import ndimage

from warpfluid.device import pick_device
from warpfluid.motion.optical_flow import METHODS, optical_flow

SIZE, QUICK_SIZE = (271, 144), (96, 64)
SPEEDS = (1.5, 4.0, 8.0)  # mean displacement over the flame [pixel]
NOISE = 2 / 255
LIT = 0.05  # light of a pixel that belongs to the flame
REACH = 24  # pixels of texture beyond the picture, so that what enters it is there


def smooth_noise(rng: np.random.Generator, shape: tuple[int, int], grain: float) -> np.ndarray:
    """Return noise of a grain [pixel], mean 0, standard deviation 1."""
    noise = ndimage.gaussian_filter(rng.standard_normal(shape), grain)
    return (noise - noise.mean()) / noise.std()


def flame(rng: np.random.Generator, size: tuple[int, int]) -> np.ndarray:
    """Return the light of a flame, 0 to 1, shape (u, v), with a margin of ``REACH``."""
    width, height = (length + 2 * REACH for length in size)
    texture = sum(grain**0.7 * smooth_noise(rng, (width, height), grain) for grain in (1.0, 2.0, 4.0, 8.0))
    u = (np.arange(width) - (width - 1) / 2)[:, None] / size[0]
    v = (np.arange(height) - REACH)[None] / size[1]
    edge = 0.06 * smooth_noise(rng, (width, height), 6.0)
    inside = 0.3 * np.clip(1.1 - v, 0, 1) ** 0.7 - np.abs(u) + edge
    envelope = 1 / (1 + np.exp(-inside / 0.025))
    return np.clip(0.5 + 0.22 * texture / texture.std(), 0, 1) * envelope


def true_flow(rng: np.random.Generator, size: tuple[int, int], speed: float) -> np.ndarray:
    """Return eddies and an upward draught [pixel], shape (2, u, v), with a mean displacement of ``speed``."""
    stream = smooth_noise(rng, size, size[1] / 8)
    eddies = np.stack([np.gradient(stream, axis=1), -np.gradient(stream, axis=0)])
    eddies /= np.hypot(*eddies).mean()
    flow = 0.7 * eddies + np.array([0.0, 0.7]).reshape(2, 1, 1)
    return flow * speed / np.hypot(*flow).mean()


def make_pair(
    seed: int, speed: float, *, change: bool, size: tuple[int, int] = SIZE
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Make two pictures and what moved.

    Args:
        seed: Another flame and flow for another seed.
        speed: Mean displacement [pixel].
        change: Change brightness and add noise.
        size: Width and height [pixel].

    Returns:
        The earlier and the later picture, light of white 1, shape (u, v); the flow (2, u, v); the flame's mask.
    """
    rng = np.random.default_rng(seed)
    wide = flame(rng, size)
    flow = true_flow(rng, size, speed)
    picture = (slice(REACH, -REACH),) * 2
    later = wide[picture]
    now = ndimage.map_coordinates(wide, np.indices(size) + REACH + flow, order=5)
    lit = now > LIT
    if change:
        later = 0.88 * later + 0.02 + NOISE * rng.standard_normal(size)
        now = now + NOISE * rng.standard_normal(size)
    return *(np.clip(image, 0, 1).astype(np.float32) for image in (now, later)), flow, lit


def endpoint_error(found: np.ndarray, flow: np.ndarray, lit: np.ndarray) -> float:
    """Return the mean distance of displacements where there is flame [pixel]."""
    return float(np.hypot(*(found - flow))[lit].mean())


def measure(method: str, speed: float, *, change: bool, flows: int, size: tuple[int, int], device) -> float:
    """Return the mean endpoint error of a method over some flows; of no motion for ``zero``."""
    errors = []
    for seed in range(flows):
        now, later, flow, lit = make_pair(seed, speed, change=change, size=size)
        still = method == "zero"
        found = np.zeros_like(flow) if still else optical_flow(now, later, method=method, white=1.0, device=device)
        errors.append(endpoint_error(found, flow, lit))
    return float(np.mean(errors))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--quick", action="store_true", help="a small size only")
    parser.add_argument("--flows", type=int, default=3, help="flows a column")
    parser.add_argument("--device", default="cpu", help="where nltv-ncc computes; the others use the CPU")
    arguments = parser.parse_args()
    device, size = pick_device(arguments.device), QUICK_SIZE if arguments.quick else SIZE
    print(describe(device))
    now, later, *_ = make_pair(0, SPEEDS[1], change=True, size=size)
    jobs = {name: lambda name=name: optical_flow(now, later, method=name, white=1.0, device=device) for name in METHODS}
    times = interleaved(jobs, 3)
    columns = [(speed, change) for speed in SPEEDS for change in (False, True)]
    names = (f"{speed:g} change" if change else f"{speed:g} px" for speed, change in columns)
    print(f"{'':10}" + "".join(f"{name:>11}" for name in (*names, "ms")))
    for method in (*METHODS, "zero"):
        errors = (
            measure(method, speed, change=change, flows=arguments.flows, size=size, device=device)
            for speed, change in columns
        )
        row = "".join(f"{error:11.2f}" for error in errors)
        print(f"{method:10}{row}{1000 * times.get(method, 0):11.0f}", flush=True)


if __name__ == "__main__":
    main()
