"""The cameras that options ask for, over the pictures."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from warpfluid.options import CameraOptions, RenderOptions
from warpfluid.options.keys import Keyed
from warpfluid.rendering.camera import Camera, middle, orthographic, perspective
from warpfluid.rendering.camera_path import read_camera_path
from warpfluid.rendering.looks import UNITS
from warpfluid.rendering.stereo import stereo_pair

LINES = 720  # of a picture whose size is not asked for
FULL_TURN = 360.0


def decided(camera: CameraOptions, options: RenderOptions) -> CameraOptions:
    """Return camera options with the keys of their file, and the projection chosen.

    Raises:
        ValueError: If the file or a key is wrong.
        OSError: If the file cannot be read.
    """
    keys = read_camera_path(camera.camera) if camera.camera else {}
    usual = "orthographic" if options.mode == "sum" else "perspective"
    return replace(camera, **keys, projection=usual if camera.projection == "auto" else camera.projection)


def picture_size(shape: Sequence[int], asked: tuple[int, int] | None) -> tuple[int, int]:
    """Return a picture's width and height: what is asked for, or those of the box with 720 lines, both even."""
    if asked:
        return asked
    return max(2, 2 * round(LINES / 2 * max(shape[:2]) / shape[2])), LINES


def cameras(
    options: CameraOptions, shape: Sequence[int], size: tuple[int, int], number: float, turned: float = 0.0
) -> list[Camera]:
    """Return the camera of a picture, or that of the left and the right eye.

    Args:
        options: What is asked for; ``projection`` is decided.
        shape: Of the volume (x, z, y).
        size: Width and height of the picture [pixel]; half of the width for each eye if they are side by side.
        number: Of the picture, by which numbers are keyed.
        turned: Part of a full turn that is added to the angle.
    """
    unit = shape[2] / UNITS
    angle = Keyed(options.angle).at(number) + FULL_TURN * turned
    elevation, zoom = Keyed(options.elevation).at(number), Keyed(options.zoom).at(number)
    target = middle(shape)
    if options.target is not None:
        floor = np.array([target[0], -0.5, target[2]])
        target = floor + unit * Keyed(options.target, 3).at(number)
    if options.stereo == "side-by-side":
        size = (max(1, size[0] // 2), size[1])
    field_of_view = Keyed(options.field_of_view).at(number)
    distance = _distance(options, shape, size, field_of_view, number)
    if options.projection == "orthographic":
        camera = orthographic(shape, angle, elevation, size=size, zoom=zoom, target=target)
        camera = replace(camera, eye=target - max(distance, np.linalg.norm(camera.eye - target)) * camera.forward)
    else:
        where = {"distance": distance, "field_of_view_deg": field_of_view, "size": size, "target": target}
        camera = perspective(shape, angle, elevation, **where)
        camera = replace(camera, pixel=camera.pixel / zoom)
    if options.stereo == "none":
        return [camera]
    apart = unit * Keyed(options.eye_distance).at(number)
    screen = distance if options.convergence == "auto" else unit * Keyed(options.convergence).at(number)
    return list(stereo_pair(camera, apart, screen))


def _distance(options: CameraOptions, shape, size, field_of_view_deg: float, number: float) -> float:
    """Return how far the eye is from the target [voxel]; by itself, the box fits into the picture."""
    if options.distance != "auto":
        return shape[2] / UNITS * Keyed(options.distance).at(number)
    radius, high = max(shape[:2]) / 2, shape[2] / 2
    up = math.tan(math.radians(field_of_view_deg) / 2)
    across = up * size[0] / size[1]
    return max(high / up + radius / 2, radius * math.hypot(1, 1 / across))
