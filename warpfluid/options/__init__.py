"""Every choice that a run can make, explained."""

from warpfluid.options.checks import RANGES, check_options
from warpfluid.options.compare import CompareOptions
from warpfluid.options.export import ExportOptions
from warpfluid.options.machine import MachineOptions
from warpfluid.options.preview import PreviewOptions
from warpfluid.options.reconstruct import (
    BRIGHT_FLAME,
    MUTATIONS_A_VOXEL,
    MUTATIONS_A_VOXEL_AND_E_STEP,
    PAPER,
    InputOptions,
    OutputOptions,
    ReconstructOptions,
    default_angles,
)
from warpfluid.options.render import CameraOptions, LightOptions, RenderOptions
from warpfluid.options.scene import (
    THINGS,
    BodyOptions,
    EmitterOptions,
    ForceOptions,
    ObstacleOptions,
    Scene,
)
from warpfluid.options.simulate import SIMULATE_PAPER, USUAL_SIZE, SimulateOptions

__all__ = [
    "BRIGHT_FLAME",
    "MUTATIONS_A_VOXEL",
    "MUTATIONS_A_VOXEL_AND_E_STEP",
    "PAPER",
    "RANGES",
    "SIMULATE_PAPER",
    "THINGS",
    "USUAL_SIZE",
    "BodyOptions",
    "CameraOptions",
    "CompareOptions",
    "EmitterOptions",
    "ExportOptions",
    "ForceOptions",
    "InputOptions",
    "LightOptions",
    "MachineOptions",
    "ObstacleOptions",
    "OutputOptions",
    "PreviewOptions",
    "ReconstructOptions",
    "RenderOptions",
    "Scene",
    "SimulateOptions",
    "check_options",
    "default_angles",
]
