"""Two eyes: a camera becomes a left and a right one."""

import math
from dataclasses import replace

import numpy as np

from warpfluid.rendering.camera import Camera


def stereo_pair(camera: Camera, eye_distance: float, convergence: float) -> tuple[Camera, Camera]:
    """Return the cameras of the left and the right eye.

    What lies at the convergence is seen at the same place by both: it appears in the plane of the screen. Perspective
    cameras stay parallel and shift their pictures, so nothing is displaced vertically; orthographic ones turn.

    Args:
        camera: Between the eyes.
        eye_distance: Between the eyes [voxel].
        convergence: Depth of the screen along the line of sight [voxel].
    """
    if not (convergence > 0 and np.isfinite(convergence) and np.isfinite(eye_distance)):
        raise ValueError(f"eye_distance is {eye_distance} and convergence {convergence}; finite and positive is needed")
    return _eye(camera, -0.5 * eye_distance, convergence), _eye(camera, 0.5 * eye_distance, convergence)


def _eye(camera: Camera, aside: float, convergence: float) -> Camera:
    """Return a camera moved sideways that sees the same point in its middle."""
    if camera.perspective:
        shift = (camera.shift[0] - aside / (convergence * camera.pixel), camera.shift[1])
        return replace(camera, eye=camera.eye + aside * camera.right, shift=shift)
    turn = math.atan2(aside, convergence)
    forward = math.cos(turn) * camera.forward - math.sin(turn) * camera.right
    right = math.cos(turn) * camera.right + math.sin(turn) * camera.forward
    eye = camera.eye + convergence * (camera.forward - forward)
    return replace(camera, eye=eye, right=right, forward=forward)
