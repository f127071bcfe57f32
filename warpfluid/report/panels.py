"""The panels of Fig. 3: what every iteration of appearance transfer sees, makes and models."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from warpfluid.reconstruction.result import Observer, Step
from warpfluid.rendering.ramps import apply_ramp
from warpfluid.rendering.turntable import in_a_row, slices_picture

SHOWN_DEG = (0, 30, 60, 90, 120, 150)
SLICES = 2  # on the right of the third row


def panel_writer(folder: Path, look: str) -> Callable[[int], Observer]:
    """Return what writes the panels of frames into a folder.

    Args:
        folder: It must exist.
        look: Name of a colour ramp.

    Returns:
        For the number of a frame an observer that writes ``FRAME.ITERATION.png`` after every iteration.
    """
    return partial(_observer, folder, look)  # which can be sent to another process


def _observer(folder: Path, look: str, frame: int) -> Observer:
    from warpfluid.files.images import write_png

    return lambda step: write_png(folder / f"{frame:04d}.{step.iteration:02d}.png", panels(step, look))


def panels(step: Step, look: str = "fire", shown_deg: Sequence[float] = SHOWN_DEG) -> np.ndarray:
    """Return the panels of an iteration: rendered views, above what the M-step made of them, above the new volume.

    Args:
        step: The iteration.
        look: Name of a colour ramp.
        shown_deg: Angles; the nearest ones of the fan are shown [degree].

    Returns:
        Picture, uint8 (rows, columns, 3): an angle a column, then horizontal slices of the new volume from above.
    """
    from warpfluid.projector import Projector

    fan = np.asarray(step.angles_deg)
    at = [int(np.abs((fan - angle + 90) % 180 - 90).argmin()) for angle in shown_deg]
    modelled = Projector(tuple(fan[at].tolist()), step.volume.shape, device="cpu").project(step.volume)
    rows = [_row(images, look) for images in (step.rendered[at], step.made[at], modelled)]
    heights = np.linspace(0, step.volume.shape[2] - 1, SLICES + 2).astype(int)[1:-1]
    above = slices_picture(step.volume, heights)
    whole = np.zeros((sum(row.shape[0] for row in rows), rows[0].shape[1] + above.shape[1], 3), np.uint8)
    whole[:, : rows[0].shape[1]] = np.concatenate(rows)
    shown = above[: whole.shape[0]]
    whole[-shown.shape[0] :, -above.shape[1] :] = shown
    return whole


def _row(images: np.ndarray, look: str) -> np.ndarray:
    """Return views (angle, u, v) side by side."""
    return in_a_row(apply_ramp(images.transpose(0, 2, 1)[:, ::-1], look, 255.0))
