"""Why a simulation went out of bounds: the setting that drives it most, and the way out."""

import numpy as np

from warpfluid.kernels import vectors
from warpfluid.options import Scene
from warpfluid.options.keys import Keyed
from warpfluid.simulation.forces import STANDARD_GRAVITY
from warpfluid.simulation.physics import Physics
from warpfluid.simulation.state import FluidState, Solids


def name_cause(physics: Physics, scene: Scene, state: FluidState, solids: Solids | None, frame: int) -> str:
    """Return which setting drives the fluid most at a frame, and what to do."""
    drives = _drives(physics, scene, state, solids, frame)
    name = max(drives, key=drives.get)
    more = "--substeps" if physics.options.substeps else "--max-substeps"
    if drives[name] == 0:
        return f"raise {more}, or lower --guide-weight"
    return f"lower {name if ' ' in name else f'--{name}'}, or raise {more}"


def _drives(physics: Physics, scene: Scene, state: FluidState, solids: Solids | None, frame: int) -> dict[str, float]:
    """Return how strongly each setting drives the fluid, in units a second or a second squared."""
    number, options = physics.number, physics.options
    gravity = np.linalg.norm(Keyed(options.gravity, 3).at(frame)) / STANDARD_GRAVITY
    hottest = vectors.largest(state.temperature)
    fastest = max(vectors.largest(part) for part in solids.velocity) / physics.placing.unit if solids else 0.0
    return {
        "temperature-buoyancy": abs(number("temperature_buoyancy", frame))
        * gravity
        * (hottest if np.isfinite(hottest) else 1.0),
        "density-buoyancy": abs(number("density_buoyancy", frame)) * gravity,
        "turbulence-strength": number("turbulence_strength", frame) * 10,
        "swirl": number("swirl", frame),
        "expansion": number("expansion", frame) * options.combustion * 10,
        "the velocity of the emitters": max(
            (np.abs(Keyed(e.velocity, 3).at(frame)).max() for e in scene.emitter if e.drive), default=0
        ),
        "the strength of the forces": max((abs(Keyed(f.strength).at(frame)) for f in scene.force), default=0),
        "the speed of the obstacles": fastest,
    }
