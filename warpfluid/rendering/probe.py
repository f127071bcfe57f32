"""Light probes: a picture of the light all around becomes a few suns, and harmonics for the rest.

A probe is a latitude-longitude picture as OpenEXR defines it: its upper edge is straight above, its middle in the
direction z, towards the viewer of the front, and left of the middle is x.
"""

from pathlib import Path

import numpy as np

from warpfluid.device import one_blas_thread
from warpfluid.rendering.harmonics import harmonics
from warpfluid.rendering.lighting import Lighting, Sun

MOST_SUNS = 3
SUN_DEG = 10.0  # radius of what is one light; the ring to twice this tells how bright its surroundings are
FAINTEST_SUN = 0.03  # of all light; fainter ones stay in the harmonics
WIDE_ENOUGH = 512  # columns; a wider probe is reduced
HIGH_ENOUGH = 48  # rows; with fewer a light and its ring would have no pixel
SEARCH = (32, 64)  # rows and columns in which lights are looked for
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def read_probe(path: str | Path) -> np.ndarray:
    """Read a light probe.

    Args:
        path: A latitude-longitude picture, .exr or .hdr.

    Returns:
        Radiance, float32, shape (rows, columns, 3).

    Raises:
        OSError: If the file cannot be opened.
        ValueError: If it is no such picture, or a value is not finite or below 0.
    """
    from warpfluid.files.exr import read_exr
    from warpfluid.files.hdr import read_hdr

    readers = {".exr": read_exr, ".hdr": read_hdr, ".pic": read_hdr}
    ending = Path(path).suffix.lower()
    if ending not in readers:
        raise ValueError(f"{path} ends in {ending!r}; a light probe is one of {', '.join(readers)}")
    picture = readers[ending](path)
    try:
        _check(picture)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    return np.broadcast_to(picture, (*picture.shape[:2], 3))


@one_blas_thread()
def light_from_probe(
    picture: np.ndarray, *, suns: int = 1, rotation_deg: float = 0.0, exposure: float = 0.0
) -> Lighting:
    """Turn a probe into light for volumes and surfaces; none of its energy is lost.

    Args:
        picture: Radiance, latitude-longitude, shape (rows, columns, 3 or 1).
        suns: How many of its brightest lights become suns with shadows, 0 to 3; fewer if there are not as many.
        rotation_deg: Where a camera stands that has the probe's middle behind it.
        exposure: Stops by which all is made brighter.

    Returns:
        The suns, the strongest first, and the rest as harmonics.

    Raises:
        ValueError: If the picture is no probe, or there are more suns than that.
    """
    picture = np.asarray(picture)
    _check(picture)
    if not 0 <= suns <= MOST_SUNS:
        raise ValueError(f"suns is {suns}, expected 0 to {MOST_SUNS}")
    if not (np.isfinite(rotation_deg) and np.isfinite(exposure)):
        raise ValueError(f"rotation_deg is {rotation_deg} and exposure {exposure}, expected finite numbers")
    picture = np.broadcast_to(picture, (*picture.shape[:2], 3))
    picture = _enlarge(reduce_probe(picture, WIDE_ENOUGH).astype(np.float64)) * 2.0**exposure
    directions, solid_angles = sphere(picture.shape[:2])
    directions = directions @ turn(rotation_deg).T
    found = []
    while len(found) < suns and (sun := _take_brightest(picture, directions, solid_angles)):
        found.append(sun)
    light = picture * solid_angles[..., None]
    found.sort(key=lambda sun: -float(np.dot(sun.color, LUMINANCE)))
    return Lighting(tuple(found), project(light, directions))


def sphere(shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return the directions of a latitude-longitude picture's pixels, and their solid angles.

    Args:
        shape: Rows and columns.

    Returns:
        Unit vectors (x, y, z), shape (rows, columns, 3), and steradians, shape (rows, columns).
    """
    rows, columns = shape
    edges = np.pi / 2 - np.pi * np.arange(rows + 1) / rows
    latitude = (edges[:-1] + edges[1:])[:, None] / 2
    longitude = np.pi - 2 * np.pi * (np.arange(columns) + 0.5) / columns
    flat = np.cos(latitude)
    parts = (flat * np.sin(longitude), np.sin(latitude) + 0 * longitude, flat * np.cos(longitude))
    areas = (np.sin(edges[:-1]) - np.sin(edges[1:])) * 2 * np.pi / columns
    return np.stack(parts, axis=-1), np.broadcast_to(areas[:, None], shape)


def project(light: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return the harmonics (9, 3) of radiance times solid angle (rows, columns, 3)."""
    total = np.zeros((9, 3))
    for row, towards in zip(light, directions, strict=True):
        total += harmonics(towards).T @ row
    return total


def reduce_probe(picture: np.ndarray, wide_enough: int) -> np.ndarray:
    """Return a probe with fewer pixels if it has more columns than that; their light is the same."""
    rows, columns = picture.shape[:2]
    factor = max(n for n in range(1, max(columns // wide_enough, 1) + 1) if rows % n == 0)
    if factor == 1:
        return picture
    _, solid_angles = sphere((rows, 1))
    light = (picture * solid_angles[..., None].astype(np.float32)).reshape(rows // factor, factor, -1, factor, 3)
    _, reduced = sphere((rows // factor, 1))
    return light.sum(axis=(1, 3), dtype=np.float64) / (factor * reduced[..., None])


def _enlarge(picture: np.ndarray) -> np.ndarray:
    """Return a small probe with more pixels of the same radiance."""
    factor = -(-HIGH_ENOUGH // picture.shape[0])
    return picture.repeat(factor, axis=0).repeat(factor, axis=1) if factor > 1 else picture


def _take_brightest(picture: np.ndarray, directions: np.ndarray, solid_angles: np.ndarray) -> Sun | None:
    """Take the brightest small light out of a probe, in place; None if there is none worth it."""
    centre = _brightest(picture, directions, solid_angles)
    for _ in range(2):  # the light's own middle is nearer to the truth than the coarse cell's
        towards = directions @ centre
        near = towards > np.cos(np.deg2rad(SUN_DEG))
        ring = (towards > np.cos(np.deg2rad(2 * SUN_DEG))) & ~near
        excess = np.maximum(picture[near] - np.median(picture[ring], axis=0), 0)
        energy = excess * solid_angles[near][:, None]
        if not (energy @ LUMINANCE).sum() > FAINTEST_SUN * (picture @ LUMINANCE * solid_angles).sum():
            return None
        centre = (energy @ LUMINANCE) @ directions[near]
        centre /= np.linalg.norm(centre)
    picture[near] -= excess
    return Sun(tuple(centre), tuple(energy.sum(axis=0)))


def _brightest(picture: np.ndarray, directions: np.ndarray, solid_angles: np.ndarray) -> np.ndarray:
    """Return the direction around which most light is, over what comes from the surroundings."""
    rows, columns = (min(most, n) for most, n in zip(SEARCH, picture.shape, strict=False))
    light = _sum_blocks(picture @ LUMINANCE * solid_angles, rows, columns)
    areas = _sum_blocks(solid_angles, rows, columns)
    middles = np.stack([_sum_blocks(part, rows, columns) for part in np.moveaxis(directions, -1, 0)], axis=-1)
    middles = (middles / np.linalg.norm(middles, axis=-1, keepdims=True)).reshape(-1, 3)
    towards = middles @ middles.T
    near = towards > np.cos(np.deg2rad(SUN_DEG))
    ring = (towards > np.cos(np.deg2rad(2 * SUN_DEG))) & ~near
    light, areas = light.reshape(-1), areas.reshape(-1)
    around = ring @ light / np.maximum(ring @ areas, 1e-12)
    return middles[np.argmax(near @ light - around * (near @ areas))]


def _sum_blocks(values: np.ndarray, rows: int, columns: int) -> np.ndarray:
    """Add up the pixels of each of some blocks."""
    edges = [np.arange(n) * size // n for n, size in ((rows, values.shape[0]), (columns, values.shape[1]))]
    return np.add.reduceat(np.add.reduceat(values, edges[0], axis=0), edges[1], axis=1)


def turn(degrees: float) -> np.ndarray:
    """Return the rotation about y that brings z to where a camera at an angle stands."""
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    return np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])


def _check(picture: np.ndarray) -> None:
    """Refuse what is no latitude-longitude picture of light."""
    if picture.ndim != 3 or picture.shape[2] not in (1, 3):
        raise ValueError(f"a light probe has shape {picture.shape}, expected (rows, columns, 3)")
    rows, columns = picture.shape[:2]
    if columns != 2 * rows or rows < 4:
        raise ValueError(
            f"a light probe is {columns} x {rows}; convert it to latitude-longitude, twice as wide as high"
        )
    if not np.isfinite(picture).all() or picture.min() < 0:
        raise ValueError("a light probe has values that are not finite or below 0; clean it in an image editor")
