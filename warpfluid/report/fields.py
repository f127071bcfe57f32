"""The other fields of a simulation, cut open: heat, flame, fuel and speed."""

import numpy as np

from warpfluid.rendering.ramps import apply_ramp
from warpfluid.volumes import VolumeSequence

SHOWN = ("temperature", "flame", "fuel")
LIT = 0.01  # of the greatest density: what is fainter has no say in the speed
FULL = 0.999  # quantile that is the last colour
FAST = 99


def field_pictures(volumes: VolumeSequence, frame: int, fps: float) -> dict[str, np.ndarray]:
    """Return an upright cut from left to right where there is most fluid, in the colours of the slices.

    Args:
        volumes: A simulated run.
        frame: One of its frames.
        fps: Frames a second.

    Returns:
        Pictures, uint8, shape (rows, columns, 3), by what they show, with the value of the last colour; fields that
        are 0 everywhere are left out.
    """
    found = volumes.fields(frame, ("density", *SHOWN, "velocity"))
    at = int(found.pop("density").sum(axis=(0, 2)).argmax())
    if "velocity" in found:
        found["speed"] = np.linalg.norm(found.pop("velocity"), axis=3) / fps
    pictures = {}
    for name, values in found.items():
        if values.max() > 0:
            end = float(np.quantile(values[values > 0], FULL))
            unit = " voxel/frame" if name == "speed" else ""
            pictures[f"{name}, 0 to {end:.3g}{unit}"] = apply_ramp(values[:, at].T[::-1], "jet", end)
    return pictures


def speed_of(volumes: VolumeSequence, frame: int, fps: float) -> tuple[float, float] | None:
    """Return the mean speed of the fluid, weighted by density, and that of its fastest voxels [voxel/frame].

    Args:
        volumes: A simulated run.
        frame: One of its frames.
        fps: Frames a second.

    Returns:
        Both; None if there is no velocity, or no fluid.
    """
    found = volumes.fields(frame, ("density", "velocity"))
    if "velocity" not in found or not found["density"].any():
        return None
    density = found["density"]
    lit = density > LIT * density.max()
    speed = np.linalg.norm(found["velocity"][lit], axis=1) / fps
    return float(np.average(speed, weights=density[lit])), float(np.percentile(speed, FAST))
