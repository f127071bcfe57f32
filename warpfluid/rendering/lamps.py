"""The lights that options ask for: a key light and a sky, or a light probe."""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from warpfluid.options import LightOptions
from warpfluid.options.keys import Keyed
from warpfluid.rendering.camera import Camera
from warpfluid.rendering.harmonics import sky
from warpfluid.rendering.lighting import Lighting, Sun
from warpfluid.rendering.probe import light_from_probe, read_probe

ABOVE, BELOW = 1.4, 0.6  # of the sky's light, straight above and straight below
PROBE_SUNS = 2
KEY, AMBIENT = 1.5, 0.12  # where there is no probe
NIGHT = 0.03  # ambient light in which the ground shows what a fire gives off, and no horizon
SELF_LIT = ("fire", "blackbody")  # looks that scatter hardly anything
FAINTEST = 1e-6


@dataclass(frozen=True)
class Lamps:
    """All lights, over the frames.

    Attributes:
        options: What is asked for.
        night: What is not asked for is dark.
    """

    options: LightOptions
    night: bool = False

    @cached_property
    def probe(self) -> np.ndarray | None:
        """The light probe, shape (rows, columns, 3), if there is one.

        Raises:
            OSError: If its file cannot be opened.
            ValueError: If it is no probe.
        """
        return read_probe(self.options.probe) if self.options.probe else None

    def usual_for(self, look: str) -> "Lamps":
        """Return the lamps for the name of a look: fire on the ground is the light itself, unless a light is chosen."""
        chosen = self.options.key_strength is not None or self.options.probe is not None
        return replace(self, night=True) if self.options.ground and not chosen and look in SELF_LIT else self

    def at(self, frame: float) -> Lighting:
        """Return the light at a frame."""
        options = self.options
        if self.probe is None:
            lighting = Lighting(ambient=self._around(frame))
        else:
            strength, rotation = self._probe_at(frame)
            exposure = math.log2(max(strength, FAINTEST))
            lighting = light_from_probe(self.probe, suns=PROBE_SUNS, rotation_deg=rotation, exposure=exposure)
        usual = 0.0 if options.probe or self.night else KEY
        strength = Keyed(usual if options.key_strength is None else options.key_strength).at(frame)
        if strength < FAINTEST:
            return lighting
        # A surface that reflects all of an irradiance of pi has the radiance 1.
        color = math.pi * strength * Keyed(options.key_color, 3).at(frame)
        key = Sun(Keyed(options.key_light, 3).at(frame), color)
        return Lighting((key, *lighting.suns), lighting.ambient)

    def sky(self, camera: Camera, frame: float) -> np.ndarray | None:
        """Return what a camera sees behind everything, shape (rows, columns, 3); None if the probe is not shown."""
        if not self.options.sky or self.probe is None:
            return None
        from warpfluid.rendering.sky import see_sky

        strength, rotation = self._probe_at(frame)
        return np.float32(strength) * see_sky(self.probe, camera, rotation_deg=rotation)

    def _probe_at(self, frame: float) -> tuple[float, float]:
        """Return the strength and the rotation of the probe [degree]."""
        return Keyed(self.options.probe_strength).at(frame), Keyed(self.options.probe_rotation).at(frame)

    def _around(self, frame: float) -> np.ndarray:
        """Return the harmonics of a sky that is brighter above."""
        options = self.options
        usual = NIGHT if self.night else AMBIENT
        color = Keyed(usual if options.ambient is None else options.ambient).at(frame)
        color = color * Keyed(options.ambient_color, 3).at(frame)
        return sky(tuple(ABOVE * color), tuple(BELOW * color))
