"""The least squares method: volumes from images (Section 3.1; Ihrke and Magnor 2004).

Conjugate gradients on the normal equations of sum |B v - o|^2, inside the visual hull, stopped early: the number of
steps is the regularisation. The back-projection of a full fan damps a slice's frequency f like 1 / f, so a few plain
steps never reach fine horizontal detail, while nothing damps detail along the height; volumes then look combed. The
ramp preconditioner undoes it. Two Gaussians stand in for |f|: 1 - 0.6 G(0.8) - 0.35 G(3), without a transform.
"""

import numpy as np
import warp as wp

from warpfluid.kernels import vectors
from warpfluid.kernels.blur import blur
from warpfluid.projector import Projector

FINE, FINE_WEIGHT = (0.8, 0.8, 0.0), 0.6
COARSE, COARSE_WEIGHT = (3.0, 3.0, 0.0), 0.35


class LeastSquares:
    """A conjugate gradient solver with its memory, for one projector.

    Args:
        projector: B; its hull limits the volume.
        weights: One factor for the squared error of every view; 1 when omitted.
        ramp: Precondition with a ramp.
    """

    def __init__(self, projector: Projector, *, weights: np.ndarray | None = None, ramp: bool = False):
        self._projector, self._weights, self._ramp = projector, weights, ramp
        volumes = [wp.empty(projector.shape, dtype=float, device=projector.device) for _ in range(5 if ramp else 2)]
        self._gradient, self._direction, *self._blurred = volumes
        self._rendered = wp.empty(projector.image_shape, dtype=float, device=projector.device)

    def improve(self, volume: wp.array, residual: wp.array, steps: int) -> None:
        """Take conjugate gradient steps from a volume, in place.

        Args:
            volume: Where to start, zero outside the hull, shape (x, z, y).
            residual: Targets minus the rendered volume, shape (angle, u, v); that of the new volume on return.
            steps: Number of steps.
        """
        step = self._descent(residual)
        wp.copy(self._direction, step)
        squared = vectors.dot(self._gradient, step)
        for _ in range(steps):
            rendered = self._projector.project(self._direction, out=self._rendered)
            curvature = vectors.dot(rendered, rendered, weights=self._weights)
            if squared <= 0 or curvature <= 0:  # solved to rounding
                return
            vectors.add_scaled(volume, squared / curvature, self._direction, out=volume)
            vectors.add_scaled(residual, -squared / curvature, rendered, out=residual)
            step = self._descent(residual)
            previous, squared = squared, vectors.dot(self._gradient, step)
            vectors.add_scaled(step, squared / previous, self._direction, out=self._direction)

    def _descent(self, residual: wp.array) -> wp.array:
        """Back-project the residual and precondition it."""
        self._projector.backproject(residual, weights=self._weights, out=self._gradient)
        if not self._ramp:
            return self._gradient
        fine, coarse, scratch = self._blurred
        blur(self._gradient, FINE, scratch=scratch, out=fine)
        blur(self._gradient, COARSE, scratch=scratch, out=coarse)
        return vectors.sharpen(
            self._gradient,
            fine,
            coarse,
            fine_weight=FINE_WEIGHT,
            coarse_weight=COARSE_WEIGHT,
            mask=self._projector.hull,
            out=fine,
        )


def initial_volume(projector: Projector, images: wp.array, *, steps: int, non_negative: bool = True) -> wp.array:
    """Model a volume from the input images alone (Eq. 3).

    Args:
        projector: B at the input angles, with the visual hull.
        images: Input images, shape (view, u, v).
        steps: Conjugate gradient steps from an empty volume.
        non_negative: Clip negative density.

    Returns:
        The volume, shape (x, z, y).
    """
    volume = wp.zeros(projector.shape, dtype=float, device=projector.device)
    LeastSquares(projector).improve(volume, wp.clone(images), steps)
    return vectors.clip(volume) if non_negative else volume
