"""The same energy by a deterministic solver: what a random walk should reach (Chambolle and Pock 2011).

Squared differences of the views plus a weighted sum of absolute differences between neighbours is convex, and with
density of at least 0 inside the hull it still is. The primal-dual hybrid gradient method finds its minimum without
chance, with diagonal steps: 1 over the sums of the rows and columns of the operators (Pock and Chambolle 2011).
"""

from collections.abc import Callable

import numpy as np
import warp as wp

from warpfluid.kernels import vectors
from warpfluid.kernels.tomography import sad
from warpfluid.projector import Projector

STEPS_A_CHECK = 25
NEIGHBOURS = 6
Progress = Callable[[int, float], None]


class SadEnergy:
    """The energy of stochastic tomography (Gregson et al. 2012).

    Args:
        projector: B, with the visual hull.
        images: Measured views, shape (view, u, v).
        weight: Of the sum of absolute differences [grey level].
        weights: One factor for the squared error of every view; 1 when omitted.
    """

    def __init__(self, projector: Projector, images: wp.array, weight: float, *, weights: np.ndarray | None = None):
        self.projector, self.images, self.weight, self.weights = projector, images, weight, weights
        self.residual = wp.empty(projector.image_shape, dtype=float, device=projector.device)

    def __call__(self, volume: wp.array) -> float:
        """Return the energy of a volume; ``residual`` becomes rendered minus measured views."""
        self.projector.project(volume, out=self.residual)
        vectors.add_scaled(self.residual, -1.0, self.images, out=self.residual)
        squares = vectors.dot(self.residual, self.residual, weights=self.weights)
        return squares + self.weight * sad.sad(volume)


def minimise(energy: SadEnergy, volume: wp.array, *, steps: int, progress: Progress | None = None) -> np.ndarray:
    """Minimise the energy, in place.

    Args:
        energy: What to minimise; all its views weigh 1.
        volume: Where to start, shape (x, z, y).
        steps: Primal-dual steps.
        progress: Called with the number of the check and the energy.

    Returns:
        Energies before and after each ``STEPS_A_CHECK`` steps, shape (check, 2).

    Raises:
        ValueError: If the energy weighs its views.
    """
    if energy.weights is not None:
        raise ValueError("the views of the energy have weights, which this solver does not know: leave them out")
    projector = energy.projector
    dual_views = wp.full(projector.image_shape, 1.0, dtype=float, device=projector.device)
    primal_step = 1 / (float(projector.backproject(dual_views).numpy().max()) + NEIGHBOURS)
    views_step = 1 / max(float(projector.project(projector.hull).numpy().max()), 1)
    dual_views.zero_()
    dual = wp.zeros((3, *projector.shape), dtype=float, device=projector.device)
    rendered, gradient = wp.empty_like(dual_views), wp.empty_like(volume)
    ahead = wp.clone(volume)
    energies, before = [], energy(volume)
    for step in range(steps):
        projector.project(ahead, out=rendered)
        sad.raise_views(dual_views, rendered, energy.images, step=views_step)
        sad.raise_dual(ahead, dual, step=0.5, weight=energy.weight)
        projector.backproject(dual_views, out=gradient)
        sad.lower_primal(gradient, dual, projector.hull, volume, ahead, step=primal_step)
        if (step + 1) % STEPS_A_CHECK == 0 or step == steps - 1:
            after = energy(volume)
            energies.append((before, after))
            before = after
            if progress:
                progress(len(energies), after)
    return np.array(energies).reshape(-1, 2)
