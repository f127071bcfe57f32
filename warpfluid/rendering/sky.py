"""A light probe as the background of a picture: what rays see that meet nothing."""

import numpy as np
from scipy.ndimage import map_coordinates

from warpfluid.rendering.camera import Camera
from warpfluid.rendering.probe import reduce_probe, turn


def see_sky(probe: np.ndarray, camera: Camera, *, rotation_deg: float = 0.0) -> np.ndarray:
    """Return the light of a probe behind everything.

    Args:
        probe: Radiance, latitude-longitude, shape (rows, columns, 3); what is finer than the picture is averaged.
        camera: Where it is seen from; parallel rays all see one point.
        rotation_deg: As for ``light_from_probe``.

    Returns:
        Radiance, float32, shape (rows, columns, 3), the top row first.
    """
    x, y, z = np.moveaxis(camera.rays()[1] @ turn(rotation_deg), -1, 0)
    if camera.perspective:
        probe = reduce_probe(probe, max(1, int(2 * np.pi / camera.pixel)))
    rows, columns = probe.shape[:2]
    row = (0.5 - np.arctan2(y, np.hypot(x, z)) / np.pi) * rows - 0.5
    column = (0.5 - np.arctan2(x, z) / (2 * np.pi)) * columns - 0.5
    above, below = (np.roll(end, columns // 2, axis=1) for end in (probe[:1], probe[-1:]))  # past the poles
    around = np.pad(np.concatenate([above, probe, below]), [(0, 0), (1, 1), (0, 0)], mode="wrap")
    places = np.stack([row + 1, column + 1])
    channels = (map_coordinates(around[..., c], places, np.float32, order=1) for c in range(3))
    return np.stack(list(channels), axis=-1)
