"""What stands in the fluid or is carried by it: the obstacles and rigid bodies of a scene."""

import numpy as np
import warp as wp

from warpfluid.options import Scene
from warpfluid.simulation.drag import flow_around
from warpfluid.simulation.placing import Placing
from warpfluid.simulation.rigid_motion import advance
from warpfluid.simulation.solids import build_solids
from warpfluid.simulation.state import SIX, FluidState, Solids

SHORTEST = 1e-9  # s; a standstill has no speed


class Scenery:
    """The obstacles and bodies of a scene.

    Args:
        scene: It.
        placing: Where its lengths lie in the box.
        sides: What the sides of the box are.
        device: Where to compute.
        frame: At which it begins.

    Attributes:
        bodies: The rigid bodies as they are now.
    """

    def __init__(self, scene: Scene, placing: Placing, sides: SIX, device: wp.Device, frame: int):
        self._scene, self._placing, self._sides, self._device = scene, placing, sides, device
        self.bodies = [placing.body(body, frame) for body in scene.body]
        self._built: tuple[tuple, Solids | None] = ((), None)

    def solids(self, frame: int, later: int, seconds: float) -> Solids | None:
        """Return what stands in the fluid; the same object as long as nothing moves, for it keeps its grids."""
        placed = [self._placing.solid(o, frame, later, max(seconds, SHORTEST)) for o in self._scene.obstacle]
        bodies = zip(self.bodies, self._scene.body, strict=True)
        placed += [body.placed() for body, options in bodies if options.obstacle]
        if not placed:
            return None
        key = tuple(np.concatenate([p.centre, p.rotation.ravel(), p.velocity, p.spin]).tobytes() for p in placed)
        if key != self._built[0]:
            self._built = (key, build_solids(placed, self._placing.shape, self._device, sides=self._sides))
        return self._built[1]

    def move(self, state: FluidState, seconds: float, *, gravity: float) -> None:
        """Let the fluid carry the bodies, and gravity pull them down [voxel/s^2]."""
        if not self.bodies or seconds <= 0:
            return
        flow = flow_around(state, self._placing.reference)
        for body in self.bodies:
            advance(body, seconds, gravity=gravity, flow=flow)
