"""The turntable of a run: it plays while the camera walks around."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from warpfluid.rendering.surfaces import Surface
from warpfluid.rendering.turntable import FILM_LINES, render_turntable
from warpfluid.run import Run
from warpfluid.simulation.outlines import Outlines

TURN_PICTURES = 120
COLORS = {"body": (0.95, 0.5, 0.15), "obstacle": (0.55, 0.56, 0.58)}
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
    """Yield at least so many pictures of a turn, with what stands in the run; frame i % n is in picture i."""
    frames = list(run.records())
    count = max(count, len(frames))
    angles = np.arange(count) * 360.0 / count
    outlines, white = Outlines(run), 255.0 / scale

    def shoot(frame: int, angles_deg: np.ndarray) -> np.ndarray:
        volume = run.volume(frame)
        surfaces = surfaces_in(outlines, frame, volume.shape)
        return render_turntable(volume, angles_deg, look, white=white, surfaces=surfaces, lines=FILM_LINES)

    if len(frames) == count:
        for frame, angle in zip(frames, angles, strict=True):
            yield shoot(frame, [angle])[0]
        return
    film = {}
    for first, frame in enumerate(frames):
        at = range(first, count, len(frames))
        film.update(zip(at, shoot(frame, angles[first :: len(frames)]), strict=True))
    for i in range(count):
        yield film[i]


def surfaces_in(outlines: Outlines, frame: int, shape: tuple[int, int, int]) -> list[Surface]:
    """Return what stands in a run at a frame, in colours that set bodies off from obstacles."""
    return [Surface(o.vertices, o.triangles, COLORS[o.kind]) for o in outlines.at(frame, shape)]
