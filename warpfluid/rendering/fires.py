"""Fire as a light: what glows in a volume stands for a few lamps that light the ground and bodies."""

from dataclasses import dataclass

import numpy as np
import warp as wp

from warpfluid.kernels.coarsen import coarsen
from warpfluid.kernels.curves import look_up
from warpfluid.rendering.medium import Curve, Medium

CELLS = 5  # lamps along the longest side of a box, at most
FAINTEST = 0.005  # of all light; lamps below give theirs to the others


@dataclass(frozen=True)
class Fires:
    """Lamps in a volume.

    Attributes:
        places: Where they are (x, y, z), and half the width of what each stands for [voxel], shape (n, 4).
        colors: Radiance times the volume that glows [radiance voxel^2], shape (n, 3).
    """

    places: np.ndarray
    colors: np.ndarray

    @classmethod
    def none(cls) -> "Fires":
        """Return no lamps."""
        return cls(np.zeros((0, 4)), np.zeros((0, 3)))


def find_fires(medium: Medium, open: np.ndarray | None = None, factor: int = 2) -> Fires:
    """Gather the light that a medium gives off into lamps.

    Args:
        medium: What fills the volume.
        open: How much of the glow gets out, on a coarse lattice, shape (x, z, y); all of it when omitted.
        factor: Voxels along an edge of one of that lattice.
    """
    if medium.emission is None:
        return Fires.none()
    glow = _glow(medium, medium.emission, factor) * factor**3
    if open is not None:
        glow *= open
    step = -(-max(glow.shape[1:]) // CELLS)
    lamps, middles = _gather(glow, step)
    brightness = lamps.sum(axis=1)
    kept = brightness > FAINTEST * brightness.sum()
    if not kept.any():
        return Fires.none()
    colors = lamps[kept] * (brightness.sum() / brightness[kept].sum())
    x, z, y = (factor * (middles[kept] + 0.5) - 0.5).T
    return Fires(np.stack([x, y, z, np.full(len(x), factor * step / 2)], axis=1), colors)


def _glow(medium: Medium, curve: Curve, factor: int) -> np.ndarray:
    """Return the mean emission of coarse voxels, shape (3, x, z, y)."""
    field = medium.fields[curve.field]
    columns = curve.values.reshape(len(curve.values), -1).T
    options = {"top": curve.top, "times": medium.fields.get(curve.times), "edge_fade": medium.edge_fade}
    out = wp.empty_like(field)
    parts = []
    for column in columns:
        values = wp.array(np.ascontiguousarray(column), dtype=float, device=field.device)
        parts.append(coarsen(look_up(field, values, **options, out=out), factor=factor).numpy())
    return np.stack(parts if len(parts) == 3 else parts * 3)


def _gather(glow: np.ndarray, step: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the total (n, 3) and the middle (n, 3) of the light in cubes of a lattice."""
    padded = np.pad(glow, [(0, 0), *((0, -n % step) for n in glow.shape[1:])])
    places = np.indices(padded.shape[1:], np.float32)
    total = padded.sum(axis=0)
    sums = [_add_cubes(part, step) for part in (*padded, total, *(places * total))]
    weight = np.maximum(sums[3], 1e-30)
    return np.stack(sums[:3], axis=-1).reshape(-1, 3), np.stack([s / weight for s in sums[4:]], axis=-1).reshape(-1, 3)


def _add_cubes(values: np.ndarray, step: int) -> np.ndarray:
    """Add up cubes of a lattice."""
    split = [part for n in values.shape for part in (n // step, step)]
    return values.reshape(split).sum(axis=(1, 3, 5), dtype=np.float64)
