"""Pictures of a volume all around: stills, a turning film, horizontal slices.

Light is summed along the rays of the reconstruction's own projector, so a picture at an input's angle is what
the input is compared with; no graphics library takes part. Every picture of a set has the same exposure.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from pathlib import Path

import numpy as np

from warpfluid.rendering.ramps import apply_ramp

SMALL = 256  # pictures narrower than this are shown at twice their size
FILM_LINES = 480  # of a film, at least
LARGEST = 8  # pixels a voxel; beyond, there is nothing more to see
GAP = 4  # black columns between pictures in a row


def turntable_angles(count: int) -> np.ndarray:
    """Return ``count`` angles of a full turn [degree], the first at the front, none repeated."""
    if count < 1:
        raise ValueError(f"count is {count}; a turn needs at least one picture")
    return np.arange(count) * (360.0 / count)


def render_turntable(
    volume,
    angles_deg: Sequence[float],
    ramp: str = "fire",
    *,
    white: float | None = 255.0,
    surfaces: Sequence = (),
    lines: int = 0,
) -> np.ndarray:
    """Render a volume from every angle, at one exposure.

    Args:
        volume: Density, NumPy or Warp, shape (x, z, y).
        angles_deg: Where the camera stands; 0 is the front, 90 the left of it, looking along x.
        ramp: Name of a colour ramp.
        white: Ray sum that is the brightest colour; 255 shows a reconstruction as its footage; None takes
            nearly the brightest of all pictures.
        surfaces: Bodies that stand in it, each a ``Surface``.
        lines: Height that pictures have at least, unless a voxel would be wider than 8 pixels.

    Returns:
        Pictures, uint8, shape (angle, rows, columns, 3): a pixel a voxel, or enlarged smoothly by a whole number, which
        is 2 at least if the volume is narrower than 256.

    Raises:
        ValueError: If the volume is not 3D, an angle or the ramp is not known, or ``white`` is not positive.
    """
    images = _project(volume, angles_deg)
    white = _exposure(images) if white is None else white
    if not surfaces:
        return apply_ramp(_enlarge(images, lines), ramp, white)
    from warpfluid.rendering.laid_in import lay_in

    shots = zip(_enlarge(images, lines), angles_deg, strict=True)
    return np.stack([lay_in(light, _checked(volume), surfaces, angle, ramp, white) for light, angle in shots])


def strip(volume, angles_deg: Sequence[float], ramp: str = "fire", *, white: float | None = 255.0) -> np.ndarray:
    """Return the stills of ``render_turntable`` side by side, uint8, shape (rows, columns, 3)."""
    return in_a_row(render_turntable(volume, angles_deg, ramp, white=white))


def slices_picture(
    volume: np.ndarray, heights: Sequence[int], ramp: str = "jet", *, white: float | None = None
) -> np.ndarray:
    """Show horizontal slices side by side, seen from above: x right, the front at the bottom.

    Args:
        volume: Density, shape (x, z, y).
        heights: Indices of the slices, 0 at the ground.
        ramp: Name of a colour ramp.
        white: Density that is the last colour; nearly the greatest of these slices by default.

    Returns:
        One picture, uint8, shape (rows, columns, 3), a pixel a voxel.

    Raises:
        ValueError: If the volume is not 3D, or a height lies outside of it.
    """
    volume = _checked(volume)
    heights = np.atleast_1d(heights)
    if heights.size == 0 or heights.min() < 0 or heights.max() >= volume.shape[2]:
        raise ValueError(f"heights are {heights.tolist()}; the volume has heights 0 to {volume.shape[2] - 1}")
    slices = volume[:, :, heights].transpose(2, 1, 0)
    return in_a_row(apply_ramp(slices, ramp, _exposure(slices) if white is None else white))


def write_turntable(
    path: str | Path,
    volumes,
    *,
    ramp: str = "fire",
    white: float | None = 255.0,
    rate: float = 24.0,
    pictures: int = 120,
    turn_deg: float = 3.0,
) -> None:
    """Film a turning volume, or a sequence that plays while the camera walks around it, 480 lines high or more.

    Args:
        path: The film: .mp4, or .webp or .gif for a page.
        volumes: One volume of shape (x, z, y), or an iterable of them, one a picture.
        ramp: Name of a colour ramp.
        white: Ray sum that is the brightest colour; None takes it from the first volume.
        rate: Pictures a second.
        pictures: Length of one volume's full turn.
        turn_deg: How far the camera walks between two frames of a sequence.

    Raises:
        ValueError: If there is no volume, or it or the path's ending will not do.
        OSError: If the film cannot be written.
    """
    from warpfluid.files.video import write_animation, write_video

    writers = {".mp4": write_video, ".webp": write_animation, ".gif": write_animation}
    ending = Path(path).suffix.lower()
    if ending not in writers:
        raise ValueError(f"path ends in {ending!r}; a turntable is written as one of {', '.join(writers)}")
    if hasattr(volumes, "shape"):
        shots = ((volumes, angle) for angle in turntable_angles(pictures))
    else:
        shots = ((volume, i * turn_deg % 360) for i, volume in enumerate(volumes))
    writers[ending](path, _film(shots, ramp, white), rate)


def in_a_row(pictures: Iterable[np.ndarray]) -> np.ndarray:
    """Set colour pictures of one height side by side, with a black gap."""
    pictures = list(pictures)
    gap = np.zeros((pictures[0].shape[0], GAP, 3), np.uint8)
    return np.concatenate(list(chain.from_iterable((gap, picture) for picture in pictures))[1:], axis=1)


def _film(shots: Iterable[tuple], ramp: str, white: float | None) -> Iterator[np.ndarray]:
    """Yield the picture of every (volume, angle), all at the first one's exposure."""
    for volume, angle in shots:
        image = _project(volume, [angle])
        white = _exposure(image) if white is None else white
        yield apply_ramp(_enlarge(image, FILM_LINES), ramp, white)[0]


def _project(volume, angles_deg: Sequence[float]) -> np.ndarray:
    """Return pictures (angle, rows, columns), top row first, by summing along rays."""
    from warpfluid.projector import Projector

    volume = _checked(volume)
    images = Projector(list(angles_deg), volume.shape).project(volume)
    images = images.numpy() if hasattr(images, "numpy") else images
    return images.transpose(0, 2, 1)[:, ::-1]


def _checked(volume) -> np.ndarray:
    """Return the volume as a NumPy array, or say what it is instead."""
    volume = np.asarray(volume.numpy() if hasattr(volume, "numpy") else volume, np.float32)
    if volume.ndim != 3:
        raise ValueError(f"volume has shape {volume.shape}; one 3D array (x, z, y) is needed")
    return volume


def _exposure(values: np.ndarray) -> float:
    """Return the white that leaves only a thousandth of what is lit above it."""
    lit = values[values > 0]
    return float(np.quantile(lit, 0.999)) if lit.size else 1.0


def _enlarge(images: np.ndarray, lines: int) -> np.ndarray:
    """Enlarge small pictures smoothly, before they are coloured."""
    _, rows, columns = images.shape
    factor = max(2 if columns < SMALL else 1, min(-(-lines // rows), LARGEST))
    if factor == 1:
        return images
    from scipy.ndimage import zoom

    # Cubic splines dip below black around bright edges; colouring clips that.
    return zoom(images, (1, factor, factor), order=3, mode="nearest", grid_mode=True)
