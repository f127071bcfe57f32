"""What the footage asks of the simulation: motion (Eqs. 5-9) and density (Eq. 10), from the reconstructed volumes.

A volume of a reconstruction shows the footage at the angles of its views, to more than 60 dB. So the views are taken
from the volumes: no footage needs to be there, and volumes of other programs are followed the same way.
"""

import numpy as np
import warp as wp

from warpfluid.balance import Balancing
from warpfluid.kernels.blur import blur
from warpfluid.kernels.flow.flow_lift import lift
from warpfluid.kernels.fluid.disagreement import quicken
from warpfluid.kernels.fluid.guidance import blend, guide, mix, to_faces
from warpfluid.kernels.sides import SIX
from warpfluid.motion.carry import smooth
from warpfluid.motion.optical_flow import optical_flow
from warpfluid.projector import Projector, directions
from warpfluid.simulation.pressure import hold, make_incompressible
from warpfluid.simulation.state import Faces, Solids

SWEEPS = 4  # of balancing; they make the views exact
PASSES = 4  # of guided projection


class Motion:
    """The slow motion that footage asks for, and how a velocity takes it on.

    Args:
        target: G(omega) on the faces [voxel/s].
        sigma: Standard deviation of G [voxel].
        weight: Share of the footage in the slow motion.
        sides: What the sides of the box are.
        project: Make the guided velocity divergence-free.
    """

    def __init__(self, target: Faces, sigma: float, weight: float, sides: SIX, project: bool):
        self.target, self.sigma, self.weight = target, sigma, weight
        self._sides, self._project = sides, project

    def guided(self, velocity: Faces, solids: Solids | None = None) -> Faces:
        """Return the velocity psi' of Eqs. 8-9; around solids, or if wanted, one that is divergence-free, too.

        Low frequencies and divergence are put right in turns, the divergence last (guided projection, as alternating
        projections; Thuerey et al. 2006, Gregson et al. 2014).
        """
        out = Faces(*(wp.clone(part) for part in velocity))
        passes = 0 if self.weight == 0 else PASSES if self._project else 1
        for _ in range(passes):
            for part, target in zip(out, self.target, strict=True):
                guide(part, blur(part, self.sigma), target, weight=self.weight)
            if self._project or solids:
                make_incompressible(out, self._sides, solids=solids)
        hold(out, self._sides, solids)
        return out


class Footage:
    """The views of a sequence of volumes.

    Args:
        angles_deg: Where they are seen from.
        shape: Of the volumes (x, z, y).
        device: Where to compute.
    """

    def __init__(self, angles_deg: tuple[float, ...], shape: tuple[int, int, int], device: wp.Device):
        self._projectors = [Projector((angle,), shape, device=device) for angle in angles_deg]
        self._directions = directions(np.asarray(angles_deg, float), device)

    def images(self, volume: wp.array) -> np.ndarray:
        """Return how a volume looks, shape (view, u, v)."""
        return np.concatenate([view.project(volume).numpy() for view in self._projectors])

    def omega(self, now: wp.array, later: wp.array, *, method: str, sigma: float) -> tuple[wp.array, ...]:
        """Return omega, the motion from one volume to the next (x, z, y) [voxel/frame].

        The mean is one over the fluid: empty space must not slow its rim.
        """
        pairs = zip(self.images(now), self.images(later), strict=True)
        flows = [optical_flow(a, b, method=method, device=now.device) for a, b in pairs]
        flow_u, flow_v = (wp.array(np.stack([f[i] for f in flows]), dtype=float, device=now.device) for i in (0, 1))
        return smooth(lift(flow_u, flow_v, self._directions, now.shape), now, sigma)

    def balance(self, density: wp.array, volume: wp.array, *, power: float) -> None:
        """Balance a density against the views of a volume, in place."""
        if power > 0:
            Balancing(self.images(volume), self._projectors).apply(density, SWEEPS, power=power)


def on_faces(omega: tuple[wp.array, ...], seconds: float, sigma: float) -> Faces:
    """Return G(omega) on the faces [voxel/s].

    It must hold no frequency that G takes out of the velocity, or each step of Eqs. 8-9 would add it once more.

    Args:
        omega: Along x, z and y [voxel/frame], in the voxels.
        seconds: From frame to frame.
        sigma: Standard deviation of G [voxel].
    """
    out = Faces.zeros(omega[0].shape, omega[0].device)
    for axis, (part, face) in enumerate(zip(omega, out, strict=True)):
        blur(to_faces(part, axis=axis, scale=1 / seconds, out=face), sigma, out=face)
    return out


def share_of(
    volume: wp.array, density: wp.array, *, weight: float | wp.array, factor: float, amounts: bool
) -> float | wp.array:
    """Return how much of a volume a density takes: more where they have come apart, for half of each is haze.

    Args:
        volume: v, shape (x, z, y).
        density: d, the same shape.
        weight: lambda where they agree; or one a voxel.
        factor: Of lambda where they disagree; 1 changes nothing.
        amounts: Count that one of them has more light than the other; not where an edit makes or takes matter.
    """
    if factor == 1 or (not isinstance(weight, wp.array) and weight == 0):
        return weight
    share = wp.clone(weight) if isinstance(weight, wp.array) else wp.full_like(volume, weight)
    return quicken(share, density, volume, factor=factor, amounts=amounts)


def follow(density: wp.array, volume: wp.array, *, weight: float | wp.array, subtract: float) -> None:
    """Move a density towards a volume, in place: Eq. 10, and with ``subtract`` above 0 its other half.

    Args:
        density: d, shape (x, z, y).
        volume: v, the same shape.
        weight: lambda; or one a voxel, the same shape.
        subtract: The weight where the density is higher, as a part of the other one.
    """
    if isinstance(weight, wp.array):
        mix(density, blend(wp.clone(density), volume, add=1.0, subtract=subtract), share=weight)
    else:
        blend(density, volume, add=weight, subtract=weight * subtract)
