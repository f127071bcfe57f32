"""Fire as a light: what glows in a volume stands for a few lamps that light the ground and bodies."""

from dataclasses import dataclass

import numpy as np
import warp as wp

from warpfluid.kernels.coarsen import coarsen
from warpfluid.kernels.light.curves import look_up
from warpfluid.rendering.medium import Curve, Medium

CELLS = 5  # lamps along the longest side of a box, at most
MOST = 24  # lamps
FAINTEST = 0.005  # of all light; lamps below, or beyond the most, give theirs to the others


@dataclass(frozen=True)
class Fires:
    """Lamps in a volume.

    Attributes:
        places: Where they are (x, y, z), and half the width of what each stands for [voxel], shape (n, 4).
        colors: Radiant intensities where their light leaves what they stand for [radiance voxel^2], shape (n, 3).
        escaping: The same where it leaves the volume, shape (n, 3).
    """

    places: np.ndarray
    colors: np.ndarray
    escaping: np.ndarray

    @classmethod
    def none(cls) -> "Fires":
        """Return no lamps."""
        return cls(np.zeros((0, 4)), np.zeros((0, 3)), np.zeros((0, 3)))


def find_fires(
    medium: Medium, *, extinction: np.ndarray | None = None, open: np.ndarray | None = None, factor: int = 2
) -> Fires:
    """Gather the light that a medium gives off into lamps.

    Args:
        medium: What fills the volume.
        extinction: Its extinction on a coarse lattice, shape (x, z, y) [1/voxel]; none when omitted.
        open: Share of directions that are open, on that lattice; all when omitted.
        factor: Voxels along an edge of one of that lattice.
    """
    if medium.emission is None:
        return Fires.none()
    glow = _glow(medium, medium.emission, factor) * factor**3
    step = -(-max(glow.shape[1:]) // CELLS)
    lamps, means = _gather(glow, step, [np.zeros(1) if extinction is None else extinction, 1 if open is None else open])
    brightness = lamps.sum(axis=1)
    kept = np.argsort(-brightness, kind="stable")[:MOST]
    kept = kept[brightness[kept] > FAINTEST * brightness.sum()]
    if not kept.size:
        return Fires.none()
    colors = lamps[kept] * (lamps.sum(axis=0) / np.maximum(lamps[kept].sum(axis=0), 1e-30))
    (x, z, y), radius = factor * (means[kept, :3].T + 0.5) - 0.5, factor * step / 2
    places = np.stack([x, y, z, np.full(len(x), radius)], axis=1)
    return Fires(places, colors * ball_escape(means[kept, 3:4] * radius), colors * means[kept, 4:5])


def ball_escape(depth: np.ndarray) -> np.ndarray:
    """Return the share of light that leaves a ball which glows evenly (Osterbrock and Ferland, Appendix 2).

    Args:
        depth: Optical depth from its middle to its surface.
    """
    thick = np.maximum(depth, 0.05)
    exact = 3 / (4 * thick) * (1 - 1 / (2 * thick**2) + (1 / thick + 1 / (2 * thick**2)) * np.exp(-2 * thick))
    return np.where(depth < 0.05, 1 - 0.75 * depth, exact)


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


def _gather(glow: np.ndarray, step: int, fields: list) -> tuple[np.ndarray, np.ndarray]:
    """Return the total light (n, 3) in cubes of a lattice, and the means of x, z, y and some fields by light (n, m)."""
    total, places = glow.sum(axis=0), np.indices(glow.shape[1:], np.float32)
    sums = [_add_cubes(part, step) for part in (*glow, total, *(field * total for field in (*places, *fields)))]
    weight = np.maximum(sums[3], 1e-30)
    return np.stack(sums[:3], axis=-1), np.stack([part / weight for part in sums[4:]], axis=-1)


def _add_cubes(values: np.ndarray, step: int) -> np.ndarray:
    """Add up cubes of a lattice, one number each."""
    padded = np.pad(values, [(0, -n % step) for n in values.shape])
    split = [part for n in padded.shape for part in (n // step, step)]
    return padded.reshape(split).sum(axis=(1, 3, 5), dtype=np.float64).reshape(-1)
