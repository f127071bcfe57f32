"""Options against their types and ranges."""

import math
from collections.abc import Iterable
from dataclasses import fields
from typing import get_args, get_type_hints

import numpy as np

from warpfluid.options.keys import FIELDS, Keyed, Ramp, is_ramp

RANGES = {
    "iterations": (0, 1000),
    "coherent_iterations": (0, 1000),
    "angles": (2, 7200),
    "piece": (1, 10**6),
    "overlap": (0, 1000),
    "cg_steps": (1, 1000),
    "lsm_steps": (1, 1000),
    "blur": (0, 20),
    "input_weight": (0, 1e6),
    "sad_weight": (0, 1e4),
    "mutations": (1, 10**10),
    "chains": (1, 10**6),
    "quantum": (1e-3, 255),
    "convex_steps": (1, 10**5),
    "balance": (0, 100),
    "balance_power": (0, 1),
    "fade": (0, 1),
    "fade_blur": (0, 20),
    "threshold": (0, 254),
    "hull_radius": (0.5, 10),
    "start_noise": (0, 5),
    "noise_grain": (0.1, 100),
    "noise_grain_y": (0.1, 100),
    "seed": (0, 2**32 - 1),
    "patch": (4, 64),
    "sweeps": (1, 100),
    "scales": (1, 10),
    "shoulder": (0, 10),
    "black_level": (0, 254),
    "voxel_size": (1e-9, 1e9),
    "drop_below": (0, 1),
    "density_scale": (1e-12, 1e12),
    # compare
    "measured_frames": (1, 1000),
    "start_angle": (-360, 360),
    "turn_step": (-90, 90),
    # simulate
    "fps": (0.1, 1000),
    "time_scale": (0, 10),
    "substeps": (1, 64),
    "cfl": (0.1, 20),
    "max_substeps": (1, 64),
    "preroll": (0, 10000),
    "resolution_scale": (0.25, 4),
    "blend": (0, 1),
    "blend_apart": (1, 100),
    "subtract": (0, 1),
    "fidelity": (0, 1),
    "guide_weight": (0, 1),
    "guide_radius": (0.5, 64),
    "density_dissipation": (0, 10),
    "density_diffusion": (0, 10),
    "temperature_dissipation": (0, 10),
    "temperature_diffusion": (0, 10),
    "viscosity": (0, 10),
    "velocity_damp": (0, 10),
    "density_buoyancy": (-25, 25),
    "temperature_buoyancy": (-150, 150),
    "liquid_weight": (0, 1000),
    "liquid_surface": (0, 1),
    "swirl": (0, 10),
    "detail": (1, 4),
    "detail_strength": (0, 4),
    "turbulence_strength": (0, 5),
    "turbulence_frequency": (0.01, 10),
    "turbulence_speed": (0, 10),
    "turbulence_octaves": (1, 6),
    "turbulence_seed": (0, 2**31 - 1),
    "wind_drag": (0, 100),
    "ignition": (0, 10),
    "burn_rate": (0, 100),
    "heat": (0, 100),
    "smoke": (0, 10),
    "expansion": (0, 1000),
    "cooling": (0, 100),
    "max_temperature": (0.1, 100),
    "flame_fade": (0, 100),
    # what stands in the box
    "radius": (1e-3, 1000),
    "size": (1e-3, 1000),
    "soft_edge": (0, 100),
    "density": (0, 1e6),
    "temperature": (-100, 100),
    "fuel": (0, 1e6),
    "drive": (0, 1000),
    "noise": (0, 1),
    "noise_frequency": (0, 10),
    "noise_speed": (0, 100),
    "strength": (-1000, 1000),
    "weight": (1e-3, 1e6),
    "carry": (0, 100),
    "restitution": (0, 1),
    "friction": (0, 10),
    # render
    "angle": (-1e6, 1e6),
    "elevation": (-90, 90),
    "distance": (0.01, 1e5),
    "field_of_view": (1, 150),
    "zoom": (1e-3, 1000),
    "turntable": (2, 7200),
    "eye_distance": (0, 100),
    "convergence": (0.01, 1e5),
    "key_strength": (0, 1e4),
    "key_color": (0, 1e3),
    "ambient": (0, 1e4),
    "ambient_color": (0, 1e3),
    "probe_rotation": (-1e6, 1e6),
    "probe_strength": (0, 1e4),
    "ground_color": (0, 1),
    "body_color": (0, 1),
    "bias": (-0.99, 0.99),
    "thickness": (0, 1e4),
    "glow": (0, 1e6),
    "anisotropy": (-0.95, 0.95),
    "edge_fade": (0, 1000),
    "exposure": (-20, 20),
    "rolloff": (0, 1),
    "backdrop": (0, 1),
    "motion_blur": (0, 1),
    "blur_samples": (2, 64),
    "error": (1e-5, 0.1),
    # preview
    "html_size": (0.2, 2000),
}

LARGEST = 1e300  # number that any option may be

# Options of three numbers, x,y,z.
VECTORS = {"gravity", "wind", "center", "size", "rotation", "velocity", "spin", "direction"}
VECTORS |= {"target", "key_light", "key_color", "ambient_color", "ground_color", "body_color", "backdrop"}

# Numbers that may depend on a field of the fluid.
RAMPED = {"blend", "swirl"}

# Words that a number's place may take.
WORDS = {"density_dissipation": ("auto",), "distance": ("auto",), "convergence": ("auto",)}


def check_options(options, more: Iterable[str] = ()) -> None:
    """Check every option against its type and range.

    Args:
        options: Of any class.
        more: What else is wrong with them, in lines.

    Raises:
        ValueError: If any is wrong; one line each.
    """
    problems = []
    hints = get_type_hints(type(options))
    for field in fields(options):
        value, name = getattr(options, field.name), field.name.replace("_", "-")
        kinds = get_args(hints[field.name]) or (hints[field.name],)
        if value is None and type(None) in kinds:
            continue
        choices = [kind for kind in kinds if isinstance(kind, str)]
        if choices and value not in choices:
            problems.append(f"{name} is {value!r}, expected one of {', '.join(choices)}")
        elif bool in kinds:
            if not isinstance(value, bool):
                problems.append(f"{name} is {value!r}, expected true or false")
        elif float in kinds and str in kinds:
            problems += check_keyed(field.name, value, words=WORDS.get(field.name, ()))
        elif field.name in VECTORS:
            problems += check_keyed(field.name, value, size=3)
        elif str in kinds and int in kinds and isinstance(value, int | str):
            continue  # the class itself knows which
        elif str in kinds and not isinstance(value, str):
            problems.append(f"{name} is {value!r}, expected text")
        elif (int in kinds or float in kinds) and not _is_number(value, whole=int in kinds):
            problems.append(f"{name} is {value!r}, expected a {'whole ' if int in kinds else ''}number")
        elif bool not in kinds and not _in_range(field.name, value):
            low, high = RANGES[field.name]
            problems.append(f"{name} is {value:.10g}, expected {low:.10g} to {high:.10g}")
    problems += more
    if problems:
        raise ValueError("\n".join(problems))


def check_keyed(field: str, value, *, size: int = 1, words: tuple[str, ...] = ()) -> list[str]:
    """Return what is wrong with a number or vector that may be keyed over frames, in lines; nothing if all is right.

    Args:
        field: Name of the option.
        value: Its value.
        size: 1 for a number, 3 for a vector.
        words: What it may be instead.
    """
    name, low, high = field.replace("_", "-"), *RANGES.get(field, (-math.inf, math.inf))
    if value in words:
        return []
    form = "three numbers such as 0,1,0" if size == 3 else "a number"
    expected = "".join(f"{word}, " for word in words) + f"{form}, or keys such as "
    expected += "1:0,0,0;24:0,1,0" if size == 3 else "1:0.5;24:2"
    if field in RAMPED:
        expected += f", or a field ({', '.join(FIELDS)}) and its keys such as density 0:0;1:2"
    try:
        values = _values(value, size, ramped=field in RAMPED)
    except ValueError:
        values = None
    if values is None:
        return [f"{name} is {value!r}, expected {expected}"]
    wrong = values[(values < low) | (values > high)]
    return [f"{name} is {number:.10g}, expected {low:.10g} to {high:.10g}" for number in wrong[:1]]


def _values(value, size: int, *, ramped: bool) -> np.ndarray | None:
    """Return the values of what is keyed or a ramp, None for what cannot be either."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return None
    return Ramp(value).values if ramped and is_ramp(value) else Keyed(value, size).values


def _in_range(field: str, value) -> bool:
    low, high = RANGES.get(field, (-math.inf, math.inf))
    return isinstance(value, str) or low <= value <= high


def _is_number(value, *, whole: bool) -> bool:
    allowed = int if whole else int | float
    sound = isinstance(value, allowed) and not isinstance(value, bool)
    return sound and abs(value) <= LARGEST  # which leaves out what is not finite
