"""Scenes whose truth is known: the presets of our own solver, volumes of a folder, and random fields."""

import numpy as np
from common import arguments, cached, pick

KINDS = {"fire": 8, "smoke": 44, "explosion": 14, "splash": 14}  # and a frame at which each is in full flow
GRAINS = {  # random fields: grain across and along the height [part of the width], radius at floor and top, sharpness
    "fire": (0.02, 0.05, 0.8, 0.3, 2.0),
    "smoke": (0.04, 0.04, 0.35, 0.9, 1.2),
    "explosion": (0.03, 0.03, 0.8, 0.8, 1.5),
    "splash": (0.012, 0.06, 0.5, 0.9, 3.0),
}


def size() -> tuple[int, int]:
    """Return width and height of the scenes [voxel]."""
    return pick((28, 40), (48, 72), (128, 192))


def truth(kind: str = "fire", frame: int | None = None) -> np.ndarray:
    """Return a volume (x, z, y) whose brightest ray from the front is 255.

    Args:
        kind: One of ``KINDS``; read from ``--data`` if there is a file of that name: ``volume``, (x, y, z) or
            (frame, x, y, z).
        frame: Which one; that of ``KINDS`` by default.
    """
    frame = KINDS[kind] if frame is None else frame
    return sequence(kind, (frame,))[0]


def sequence(kind: str, frames: tuple[int, ...]) -> np.ndarray:
    """Return volumes (frame, x, z, y); the brightest ray of all from the front is 255."""
    data = arguments().data
    path = data / f"{kind}.npz" if data else None
    volumes = _read(path, frames) if path and path.exists() else _played(kind, frames)
    return volumes * np.float32(255 / max(volumes.sum(axis=2).max(), 1e-6))


def play(kind: str, frames: tuple[int, ...], size: tuple[int, int], *, seed: int = 0) -> np.ndarray:
    """Simulate a preset in an empty box; return its frames (frame, x, z, y)."""
    import warp as wp

    from warpfluid.settings import make_simulate_settings
    from warpfluid.simulation.animate import Animator
    from warpfluid.simulation.animation import Animation
    from warpfluid.simulation.source import empty_box

    settings = make_simulate_settings(None, None, None, {}, size=size, preset=kind)
    options = type(settings.simulate)(**vars(settings.simulate) | {"turbulence_seed": seed})
    box = empty_box(size)
    animator = Animator(
        Animation(
            source=box, options=options, scene=settings.scene, output=settings.output, device=wp.get_device("cpu")
        ),
        (1,),
    )
    made = {1: animator.state.density.numpy().copy()}
    for frame in range(2 - options.preroll, max(frames) + 1):
        animator.advance(frame - 1, frame)
        if frame in frames:
            made[frame] = animator.state.density.numpy().copy()
    return np.stack([made[frame] for frame in frames])


def random_field(kind: str, width: int, height: int, seed: int) -> np.ndarray:
    """Return noise cut into the outline of a kind of fluid, (x, z, y), brightest ray from the front 255."""
    from scipy.ndimage import gaussian_filter

    across, along, low, high, sharpness = GRAINS[kind]
    noise = np.random.default_rng(seed).standard_normal((width, width, height))
    octaves = (gaussian_filter(noise, (s * across * width, s * across * width, s * along * width)) for s in (1, 2, 4))
    field = sum(octave / octave.std() * weight for octave, weight in zip(octaves, (0.5, 0.8, 1), strict=True))
    x = np.arange(width) - (width - 1) / 2
    radius = np.hypot(x[:, None], x)[..., None] / (0.5 * width * np.linspace(low, high, height))
    rising = np.minimum(1, np.minimum(np.arange(height), np.arange(height)[::-1]) / (0.15 * height))
    volume = np.maximum(field / field.std() + 0.8 - 3 * radius**2, 0) ** sharpness * rising
    return (volume * (255 / volume.sum(axis=1).max())).astype(np.float32)


def _played(kind: str, frames: tuple[int, ...]) -> np.ndarray:
    width, height = size()
    name = f"{kind}-{width}x{height}-{frames[0]}-{frames[-1]}-{len(frames)}"
    return cached(name, lambda: {"volume": play(kind, frames, size())})["volume"]


def _read(path, frames: tuple[int, ...]) -> np.ndarray:
    with np.load(path) as found:
        volume = found["volume"].astype(np.float32)
    volume = volume[None] if volume.ndim == 3 else volume[list(frames)]
    return np.ascontiguousarray(volume.transpose(0, 1, 3, 2))
