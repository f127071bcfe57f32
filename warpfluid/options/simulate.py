"""The choices of Section 4: how the simulator follows the volumes, and what the artist adds.

Lengths are in tenths of the box's height, as Maya's container is ten units tall unless told otherwise, and times in
seconds, so a number means the same at every resolution. A ``float | str`` may be keyed over frames, and swirl and blend
may depend on a field of the fluid (``keys.py``).
"""

from dataclasses import dataclass
from typing import Annotated, Literal

from warpfluid.options.checks import check_options

USUAL_SIZE = (96, 144)  # width and height of an empty box [voxel]
Side = Literal["open", "closed", "closed-low", "closed-high", "wrap"]


@dataclass(frozen=True, kw_only=True)
class SimulateOptions:
    """The simulation of Section 4."""

    # time
    frames: Annotated[
        str | None,
        "Frames to write, such as 1-48; the source's by default. Beyond its last the fluid is left to itself",
    ] = None
    fps: Annotated[float, "Frames a second"] = 24.0
    time_scale: Annotated[float | str, "How fast time passes; a sequence is followed at 1 only"] = 1.0
    substeps: Annotated[int | None, "Solver steps a frame; as many as cfl asks for by default"] = None
    cfl: Annotated[float, "Farthest that the fluid moves in one solver step [voxel]"] = 4.0
    max_substeps: Annotated[int, "Most solver steps a frame"] = 8
    preroll: Annotated[int, "Frames simulated before the first one that is written"] = 0
    resolution_scale: Annotated[float, "Voxels of the simulation for one of the source, along each axis"] = 1.0
    # following the volumes
    order: Annotated[
        Literal["step-first", "blend-first"], "Correct towards the volume after the step, or before it (the paper)"
    ] = "step-first"
    blend: Annotated[
        float | str,
        "Share of the volume in the density where the density is lower (lambda of Eq. 10); may depend on a field",
    ] = 0.5
    blend_apart: Annotated[
        float | str, "Factor of blend where fluid and volume have come apart: half of each is haze; 1 is off"
    ] = 2.0
    subtract: Annotated[float | str, "The same where it is higher, as a part of blend; 0 only adds (the paper)"] = 1.0
    fidelity: Annotated[
        float | str | None,
        "Pull towards the footage, 0-1: of the balancing against its views and of guide-weight; below 1 the volumes "
        "are followed to where the edit has carried them. By default 1, 0.3 once anything is added, 0.1 with obstacles "
        "or bodies",
    ] = None
    guide_weight: Annotated[float | str, "Share of the footage in the slow motion (Eqs. 8-9); 0 ignores its flow"] = 1.0
    guide_radius: Annotated[float | str, "Standard deviation of the blur G of Eqs. 8-9 [voxel]"] = 2.0
    guide_mode: Annotated[
        Literal["replace", "project"], "replace low frequencies, or find a divergence-free velocity that has them"
    ] = "replace"
    flow: Annotated[Literal["nltv-ncc", "ilk", "tvl1"], "Optical flow of the views"] = "ilk"
    density_dissipation: Annotated[
        float | str, "Rate at which density vanishes [1/s]; auto: as much as keeps the source's total"
    ] = "auto"
    # forces
    gravity: Annotated[str, "x,y,z; buoyancy acts against it, in parts of 9.8"] = "0,-9.8,0"
    density_buoyancy: Annotated[float | str, "Lift of full density; below zero it sinks"] = 0.0
    temperature_buoyancy: Annotated[float | str, "Lift of temperature 1"] = 0.0
    liquid_weight: Annotated[
        float | str, "Mass of full density against the air's, less one: 20 falls as a liquid does; 0 is a gas"
    ] = 0.0
    liquid_surface: Annotated[
        float | str, "How firmly a liquid is drawn together at its surface, 0-1; 0 lets it fade into mist"
    ] = 1.0
    swirl: Annotated[
        float | str, "Vorticity confinement: makes curls stronger, where there is fluid; may depend on a field"
    ] = 0.0
    turbulence_strength: Annotated[
        float | str, "Force of moving noise; 1 accelerates by a box height a second squared"
    ] = 0.0
    turbulence_frequency: Annotated[float | str, "Eddies a unit of length; lower is larger"] = 0.5
    turbulence_speed: Annotated[float | str, "How fast the pattern changes [1/s]"] = 0.5
    turbulence_octaves: Annotated[int, "Octaves of ever finer eddies"] = 2
    turbulence_mask: Annotated[Literal["density", "temperature", "none"], "Where the turbulence acts"] = "density"
    turbulence_seed: Annotated[int, "Another seed, another pattern"] = 0
    wind: Annotated[str, "Velocity x,y,z that the fluid is blown towards"] = "0,0,0"
    wind_drag: Annotated[float | str, "Rate at which it takes the wind's velocity [1/s]"] = 2.0
    velocity_damp: Annotated[float | str, "Rate at which motion dies [1/s]"] = 0.0
    viscosity: Annotated[float | str, "Kinematic viscosity [voxel^2/s]"] = 0.0
    # density and heat
    density_diffusion: Annotated[float | str, "Diffusion of density [voxel^2/s]"] = 0.0
    temperature_dissipation: Annotated[float | str, "Rate at which heat vanishes [1/s]"] = 0.5
    temperature_diffusion: Annotated[float | str, "Diffusion of heat [voxel^2/s]"] = 0.0
    # combustion
    combustion: Annotated[bool, "Burn fuel: new density of the volumes counts as fuel, too"] = False
    ignition: Annotated[float | str, "Temperature above which fuel burns"] = 0.3
    burn_rate: Annotated[float | str, "Rate at which the hottest fuel burns [1/s]"] = 4.0
    heat: Annotated[float | str, "Temperature that burning a full density of fuel gives"] = 2.0
    smoke: Annotated[float | str, "Density that burnt fuel leaves, as a part of it"] = 0.5
    expansion: Annotated[float | str, "Volume that burning a full density of fuel makes, as a multiple of its own"] = (
        1.0
    )
    cooling: Annotated[float | str, "Rate at which the hottest gas cools by radiation [1/s]"] = 1.0
    max_temperature: Annotated[float | str, "Temperature that fire does not exceed"] = 2.0
    flame_fade: Annotated[float | str, "Rate at which a flame goes out where nothing burns [1/s]"] = 6.0
    # detail
    detail: Annotated[
        int, "Voxels of the files for one of the simulation, along each axis, with finer eddies; 1 is off"
    ] = 1
    detail_strength: Annotated[float | str, "How far the finer eddies carry; 0 only interpolates"] = 1.0
    # solver
    advection: Annotated[
        Literal["maccormack", "semi-lagrangian", "bfecc", "cubic"], "How density and heat are carried"
    ] = "cubic"
    velocity_advection: Annotated[
        Literal["maccormack", "semi-lagrangian", "bfecc", "cubic"], "How velocity is carried"
    ] = "maccormack"
    pressure: Annotated[
        Literal["auto", "direct", "multigrid"], "Pressure solver; direct: a box without obstacles or liquid"
    ] = "auto"
    boundary_x: Annotated[Side, "Left and right side of the box"] = "open"
    boundary_y: Annotated[Side, "Floor and top"] = "closed-low"
    boundary_z: Annotated[Side, "Back and front"] = "open"

    def __post_init__(self):
        check_options(self)


# Eq. 10 before the step, adding only, and a constant dissipation: 0.05 a frame at 24 frames a second.
SIMULATE_PAPER = {
    "order": "blend-first",
    "blend": 0.2,
    "blend_apart": 1.0,
    "subtract": 0.0,
    "fidelity": 0.0,
    "guide_mode": "project",
    "density_dissipation": 1.2,
    "flow": "nltv-ncc",
    "advection": "semi-lagrangian",
    "velocity_advection": "semi-lagrangian",
}
