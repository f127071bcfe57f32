"""Volumes carried along the footage's flow to the next frame (Eqs. 5-7 and the blur G of Eq. 9)."""

import numpy as np
import warp as wp

from warpfluid.device import pick_device
from warpfluid.kernels import vectors
from warpfluid.kernels.advection import advect
from warpfluid.kernels.blur import blur
from warpfluid.kernels.flow.flow_lift import lift
from warpfluid.motion.optical_flow import optical_flow
from warpfluid.projector import directions
from warpfluid.views import Views

SMOOTHING = 2.0  # of the lifted flow, weighted by density [voxel]
FAINT = 1e-3  # part of the greatest density that still has a say in the smoothed flow
MARGIN = 2  # voxels around what moves


def carry(volume: np.ndarray, now: Views, later: Views, *, method: str = "ilk", device=None) -> np.ndarray:
    """Move a volume to the next frame.

    Args:
        volume: Density of the frame, shape (x, z, y).
        now: Its views.
        later: The views of the next frame, at the same angles.
        method: Optical flow, see ``optical_flow``.
        device: Where to compute.

    Returns:
        The moved density, shape of ``volume``.
    """
    device = pick_device(device)
    flows = [
        optical_flow(a, b, method=method, white=now.white, device=device)
        for a, b in zip(now.images, later.images, strict=True)
    ]
    out = np.zeros_like(volume)
    part = _part(volume, reach=int(np.ceil(max(np.abs(flow).max() for flow in flows))) + MARGIN)
    if part is None:
        return out
    density = wp.array(np.ascontiguousarray(volume[part]), dtype=float, device=device)
    flow_u, flow_v = (wp.array(np.stack([f[i] for f in flows]), dtype=float, device=device) for i in (0, 1))
    corner = (part[0].start, part[1].start)
    omega = lift(flow_u, flow_v, directions(np.asarray(now.angles_deg), device), density.shape, corner=corner)
    out[part] = advect(density, *smooth(omega, density)).numpy()
    return out


def smooth(omega: tuple[wp.array, ...], density: wp.array, sigma: float = SMOOTHING) -> tuple[wp.array, ...]:
    """Blur a lifted flow, weighted by density so that empty space does not slow the rim, in place."""
    scratch, cover = wp.empty_like(density), wp.empty_like(density)
    blur(density, sigma, scratch=scratch, out=cover)
    floor = FAINT * float(density.numpy().max())
    for component in omega:
        vectors.multiply(component, density, out=component)
        blur(component, sigma, scratch=scratch, out=component)
        vectors.divide(component, cover, floor=floor, out=component)
    return omega


def _part(volume: np.ndarray, reach: int) -> tuple[slice, slice, slice] | None:
    """Return the part of a volume that what is in it can reach, all heights; None if it is empty."""
    occupied = volume.max(axis=2) > 0
    if not occupied.any():
        return None
    ranges = []
    for axis in (1, 0):
        lit = np.flatnonzero(occupied.any(axis=axis))
        ranges.append(slice(max(lit[0] - reach, 0), min(lit[-1] + 1 + reach, len(volume))))
    return (*ranges, slice(None))
