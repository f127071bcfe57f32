"""Looks: what a volume's numbers mean as colour, glow and thickness.

A look is three ramps, as in the shaders of the usual animation programs: ``color`` (what part of the light that meets
the fluid goes on), ``emission`` (light that it gives a unit of length) and ``opacity`` (optical depth a unit of it).
A unit is a tenth of the box's height, so a look is the same at every resolution. The ready-made ones are files in
``warpfluid/looks``; ``look_files`` reads them.
"""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import warp as wp

from warpfluid.rendering.blackbody import blackbody_color
from warpfluid.rendering.medium import Curve, Medium

FIELDS = ("density", "temperature", "flame", "speed")
RAMPS = ("color", "emission", "opacity")
ENTRIES = 1001  # of a curve: stops at thousandths are among them
UNITS = 10.0  # a tenth of the box's height is one
FULL_RAY = 4.0  # a box's height of full density has this many times the ray sum of white
WHITE = 255.0


@dataclass(frozen=True, kw_only=True)
class Ramp:
    """Values over the amount of a field.

    Attributes:
        inputs: Fields, the best first, and the amount of each at the end of the ramp: full densities, temperatures,
            flames, or units a second.
        positions: Of the stops, 0 to 1, shape (n,).
        values: At the stops, shape (n, 3).
        bias: -1 to 1: above 0 the ramp's end comes sooner, below 0 later; half way is then at (1 + bias) / 2.
        scale: Factor of all values.
        times: Field whose amount multiplies the values, so that a colour by temperature glows by density; or None.
        kelvin: Temperatures of the begin and the end of the ramp, whose black-body colours the values tint [K]; None
            for values that are colours already.
    """

    inputs: Mapping[str, float]
    positions: np.ndarray
    values: np.ndarray
    bias: float = 0.0
    scale: float = 1.0
    times: str | None = None
    kelvin: tuple[float, float] | None = None

    def at(self, amounts: np.ndarray, name: str) -> np.ndarray:
        """Return the values at amounts of the field ``name``, shape (n, 3)."""
        place = np.clip(np.asarray(amounts, np.float64) / self.inputs[name], 0, 1)
        place = place ** (math.log(0.5 + self.bias / 2) / math.log(0.5))
        found = np.stack([np.interp(place, self.positions, column) for column in self.values.T], axis=1)
        if self.kelvin:
            low, high = self.kelvin
            found = found * blackbody_color(low + (high - low) * place)
        return self.scale * found

    def chosen(self, there: Collection[str]) -> str:
        """Return the best of its inputs that is there; density always is."""
        return next((name for name in self.inputs if name in there), "density")

    def curve(self, name: str, height: int, *, a_unit: bool = True, gray: bool = False) -> Curve:
        """Return the ramp over a field as it is stored.

        Args:
            name: One of its inputs.
            height: Of the box [voxel].
            a_unit: The values are those of a unit of length, and become those of a voxel.
            gray: The values are numbers, no colours.
        """
        values = self.at(np.linspace(0, self.inputs[name], ENTRIES), name)
        values = values * (UNITS / height if a_unit else 1) / (amount_of_one(self.times, height) if self.times else 1)
        values = values[:, 0] if gray else values
        top = self.inputs[name] * amount_of_one(name, height)
        return Curve(field=name, top=top, values=values.astype(np.float32), times=self.times)


@dataclass(frozen=True, kw_only=True)
class Look:
    """How a fluid looks.

    Attributes:
        name: What it is called.
        about: A line on what it is for.
        ramps: By name; ``color``, ``emission`` or ``opacity``.
        anisotropy: Of the scattered light: 0 goes everywhere, towards 1 on, towards -1 back.
    """

    name: str
    about: str = ""
    ramps: Mapping[str, Ramp] = field(default_factory=dict)
    anisotropy: float = 0.0

    def medium(self, fields: Mapping[str, wp.array], *, edge_fade: float = 0.0) -> Medium:
        """Return what light meets in fields.

        Args:
            fields: Volumes by name, shape (x, z, y): density in grey levels, speed in voxels a second.
            edge_fade: Width over which it fades at the box's sides [voxel].
        """
        height = next(iter(fields.values())).shape[2]
        curves = {
            name: ramp.curve(ramp.chosen(fields), height, a_unit=name != "color", gray=name == "opacity")
            for name, ramp in self.ramps.items()
        }
        return Medium(
            fields=fields,
            emission=curves.get("emission"),
            extinction=curves.get("opacity"),
            albedo=curves.get("color"),
            anisotropy=self.anisotropy,
            edge_fade=edge_fade,
        )

    def fields(self, there: Collection[str]) -> dict[str, str]:
        """Return the field that each ramp takes of those that are there."""
        return {name: ramp.chosen(there) for name, ramp in self.ramps.items()}

    def with_bias(self, bias: float) -> "Look":
        """Return the look with its ramps' begin and end nearer to one side, on top of what they say themselves."""
        ramps = {name: replace(r, bias=float(np.clip(r.bias + bias, -0.99, 0.99))) for name, r in self.ramps.items()}
        return replace(self, ramps=ramps)

    def scaled(self, **factors: float) -> "Look":
        """Return the look with ramps multiplied, such as ``opacity=2``."""
        ramps = {name: replace(r, scale=r.scale * factors.get(name, 1.0)) for name, r in self.ramps.items()}
        return replace(self, ramps=ramps)


def amount_of_one(name: str, height: int) -> float:
    """Return what 1 on a ramp is in the unit of a stored field.

    Args:
        name: The field. Full density is such that a quarter of the box's height of it is white; the unit of speed is a
            tenth of that height a second.
        height: Of the box [voxel].
    """
    return {"density": FULL_RAY * WHITE / height, "speed": height / UNITS}.get(name, 1.0)
