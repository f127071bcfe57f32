"""What is to be simulated, and how far the footage decides."""

from dataclasses import dataclass

import warp as wp

from warpfluid.options import OutputOptions, Scene, SimulateOptions
from warpfluid.options.keys import Keyed
from warpfluid.simulation.source import Source

EDITED_FIDELITY = 0.3  # how strongly the footage pulls once the artist adds something
OBSTRUCTED_FIDELITY = 0.1  # the same where something stands in the way; more makes anew what it stops
EDITS = (
    "density_buoyancy",
    "temperature_buoyancy",
    "liquid_weight",
    "swirl",
    "turbulence_strength",
    "wind",
    "velocity_damp",
    "viscosity",
    "density_diffusion",
    "combustion",
)


@dataclass(frozen=True, kw_only=True)
class Animation:
    """A simulation over frames.

    Attributes:
        source: What it starts from and follows.
        options: Its choices.
        scene: What the artist put into the box.
        output: How files are stored.
        device: Where to compute.
    """

    source: Source
    options: SimulateOptions
    scene: Scene
    output: OutputOptions
    device: wp.Device

    def fidelity(self, frame: float) -> float:
        """Return how strongly the footage pulls at a frame."""
        return fidelity_at(self.options, self.scene, frame)


def fidelity_at(options: SimulateOptions, scene: Scene, frame: float) -> float:
    """Return how strongly the footage pulls at a frame: all the way, unless the artist adds something."""
    if options.fidelity is not None:
        return Keyed(options.fidelity).at(frame)
    if is_obstructed(scene):
        return OBSTRUCTED_FIDELITY
    return EDITED_FIDELITY if is_edited(options, scene) else 1.0


def is_edited(options: SimulateOptions, scene: Scene) -> bool:
    """Return whether an artist adds anything to what the footage asks for."""
    usual = SimulateOptions()
    changed = any(getattr(options, name) != getattr(usual, name) for name in EDITS)
    return changed or bool(scene.emitter or scene.force) or is_obstructed(scene)


def is_obstructed(scene: Scene) -> bool:
    """Return whether an artist puts something in the way of matter."""
    return bool(scene.obstacle) or any(body.obstacle for body in scene.body)
