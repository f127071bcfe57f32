"""The turntable of a run: it plays while the camera walks around."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from warpfluid.rendering.turntable import render_turntable
from warpfluid.run import Run

TURN_PICTURES = 120
RATE = 24.0  # of a turn of so many pictures a second


def write_film(run: Run, look: str, path: Path, *, scale: float = 1.0) -> None:
    """Film a run while the camera walks around it; a short one is repeated until the turn is full.

    Args:
        run: A run with at least one frame.
        look: Name of a colour ramp.
        path: The film, .mp4 or .webp.
        scale: What brings its densities to grey levels.
    """
    from warpfluid.files.video import write_animation, write_video

    write = write_video if path.suffix == ".mp4" else write_animation
    write(path, film_pictures(run, look, TURN_PICTURES, scale), RATE)


def film_pictures(run: Run, look: str, count: int, scale: float = 1.0) -> Iterator[np.ndarray]:
    """Yield at least so many pictures of a turn; frame i % n is seen in picture i."""
    frames = list(run.records())
    count = max(count, len(frames))
    angles = np.arange(count) * 360.0 / count
    white = 255.0 / scale
    if len(frames) == count:
        for frame, angle in zip(frames, angles, strict=True):
            yield render_turntable(run.volume(frame), [angle], look, white=white)[0]
        return
    film = {}
    for first, frame in enumerate(frames):
        at = range(first, count, len(frames))
        pictures = render_turntable(run.volume(frame), angles[first :: len(frames)], look, white=white)
        film.update(zip(at, pictures, strict=True))
    for i in range(count):
        yield film[i]
