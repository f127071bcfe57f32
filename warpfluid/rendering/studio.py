"""A picture of a frame: fields, look and lamps put together, and what a screen shows of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import warp as wp

from warpfluid.options import RenderOptions
from warpfluid.options.keys import Keyed
from warpfluid.rendering.camera import Camera
from warpfluid.rendering.composing import render
from warpfluid.rendering.display import decode_srgb, develop, encode_srgb
from warpfluid.rendering.lamps import Lamps
from warpfluid.rendering.lighting import Lighting
from warpfluid.rendering.look_files import read_look
from warpfluid.rendering.looks import WHITE, Look
from warpfluid.rendering.marching import march
from warpfluid.rendering.medium import Curve, Medium
from warpfluid.rendering.motion_blur import mean_picture, moments
from warpfluid.rendering.picture import Picture
from warpfluid.rendering.ramps import RAMPS, apply_ramp
from warpfluid.rendering.shadows import InnerLight, light_volume
from warpfluid.rendering.surfaces import GREY, Ground, Surface

BRIGHTEST = 1e6  # grey level to which the sum is one straight line
Outline = tuple[np.ndarray, np.ndarray, str]


@dataclass(frozen=True)
class Lit:
    """A frame in its light.

    Attributes:
        medium: What fills the volume.
        lighting: What is around it.
        inner: What of that reaches each voxel; None where nothing is hidden.
        moments: The medium at moments while the shutter is open; one without motion blur.
    """

    medium: Medium
    lighting: Lighting
    inner: InnerLight | None
    moments: tuple[Medium, ...]


@dataclass(frozen=True, kw_only=True)
class Studio:
    """Takes pictures of one kind.

    Attributes:
        options: Of the picture.
        lamps: The light.
        look: What numbers look like; None for the mode ``sum``.
        ramp: Name of the colour ramp of that mode.
        rate: Frames a second, by which velocity becomes motion blur.
        device: Where pictures are made.
    """

    options: RenderOptions
    lamps: Lamps
    look: Look | None
    ramp: str
    rate: float = 24.0
    device: wp.Device | str = "cpu"
    _last: list = field(default_factory=list)

    @property
    def names(self) -> set[str]:
        """Fields that pictures are made of, if they are there."""
        inputs = {name for ramp in self.look.ramps.values() for name in ramp.inputs} if self.look else set()
        blur = {"velocity"} if self.options.motion_blur else set()
        return {"density"} | inputs - {"speed"} | ({"velocity"} if "speed" in inputs else blur)

    @property
    def _marching(self) -> dict:
        return {"error": self.options.error, "interpolation": self.options.interpolation}

    def light(self, fields: Mapping[str, np.ndarray], number: float) -> Lit:
        """Put a frame into the light that there is at a picture's number.

        Args:
            fields: By name, shape (x, z, y); velocity (x, z, y, 3). The last ones are known again.
            number: Of the picture, by which lights are keyed.
        """
        lighting = self.lamps.at(number) if self.options.mode == "lit" else Lighting()
        if self._last and self._last[0] is fields and _alike(self._last[1].lighting, lighting):
            return self._last[1]
        medium = self._medium(fields)
        inner = light_volume(medium, lighting) if self.options.mode == "lit" and medium.extinction else None
        lit = Lit(medium, lighting, inner, self._moments(medium, fields))
        self._last[:] = [fields, lit]
        return lit

    def shoot(self, lit: Lit, camera: Camera, number: float, outlines: Sequence[Outline] = ()) -> Picture:
        """Take a picture.

        Args:
            lit: The frame.
            camera: Where from.
            number: Of the picture, by which colours are keyed.
            outlines: Vertices (x, y, z), triangles and kind (body, obstacle) of what stands in the volume; the mode
                ``sum`` ignores it.
        """
        if self.look is None:
            picture = mean_picture(march(medium, camera, **self._marching) for medium in lit.moments)
            grey = (picture.density / WHITE)[..., None].repeat(3, axis=2)
            return replace(picture, color=grey, emission=grey)
        options = self.lamps.options
        color = tuple(Keyed(options.body_color, 3).at(number))
        colors = {"body": color, "obstacle": GREY}
        surfaces = [Surface(vertices, triangles, colors[kind]) for vertices, triangles, kind in outlines]
        ground = Ground(lit.medium.shape, tuple(Keyed(options.ground_color, 3).at(number))) if options.ground else None
        things = {"surfaces": surfaces, "ground": ground, **self._marching}
        shots = (render(medium, camera, lit.lighting, lit.inner, **things) for medium in lit.moments)
        picture = next(shots) if len(lit.moments) == 1 else mean_picture(shots)
        return replace(picture, sky=self.lamps.sky(camera, number))

    def screen(self, picture: Picture, number: float) -> np.ndarray:
        """Return the values of a screen, 0 to 1, shape (rows, columns, 3).

        Args:
            picture: Linear light.
            number: Of the picture, by which the exposure is keyed.
        """
        options = self.options
        exposure = Keyed(options.exposure).at(number)
        if self.look is None:
            return apply_ramp(picture.density, self.ramp, WHITE * 2.0**-exposure) / np.float32(WHITE)
        if picture.sky is not None:
            return develop(picture.over(picture.sky), exposure=exposure, rolloff=options.rolloff)
        light = decode_srgb(develop(picture.color, exposure=exposure, rolloff=options.rolloff))
        behind = decode_srgb(Keyed(options.backdrop, 3).at(number))
        return encode_srgb(light + (1 - picture.alpha[..., None]) * behind)

    def _medium(self, fields: Mapping[str, np.ndarray]) -> Medium:
        """Return a frame's medium on the device; speed is made of velocity."""
        grids = {name: grid for name, grid in fields.items() if grid.ndim == 3}
        if self.look is None:
            curve = Curve("density", BRIGHTEST, np.array([0, BRIGHTEST / WHITE], np.float32))
            density = {"density": _array(grids["density"], self.device)}
            return Medium(fields=density, emission=curve, edge_fade=self.options.edge_fade)
        if "velocity" in fields and any("speed" in ramp.inputs for ramp in self.look.ramps.values()):
            grids["speed"] = np.linalg.norm(fields["velocity"], axis=3)
        arrays = {name: _array(grid, self.device) for name, grid in grids.items()}
        return self.look.medium(arrays, edge_fade=self.options.edge_fade)

    def _moments(self, medium: Medium, fields: Mapping[str, np.ndarray]) -> tuple[Medium, ...]:
        """Return the medium as it moves while the shutter is open; the light within it stays that of the frame."""
        shutter = self.options.motion_blur
        if not shutter:
            return (medium,)
        velocity = np.moveaxis(fields["velocity"], 3, 0) / np.float32(self.rate)
        parts = tuple(_array(part, self.device) for part in velocity)
        carried = moments(medium.fields, parts, shutter=shutter, samples=self.options.blur_samples)
        return tuple(replace(medium, fields=moment) for moment in carried)


def make_studio(
    options: RenderOptions, lamps: Lamps, usual_look: str, device: wp.Device | str, *, rate: float = 24.0
) -> Studio:
    """Return a studio for options.

    Args:
        options: Of the picture.
        lamps: The light.
        usual_look: Where none is asked for.
        device: Where pictures are made.
        rate: Frames a second of the velocity.

    Raises:
        ValueError: If there is no such look, or its file is wrong.
        OSError: If its file cannot be read.
    """
    name = options.look or usual_look
    if options.mode == "sum":
        if name not in RAMPS:
            raise ValueError(f"look is {name!r}, but the mode sum knows {', '.join(RAMPS)}")
        return Studio(options=options, lamps=lamps, look=None, ramp=name, rate=rate, device=device)
    look = read_look(name).with_bias(options.bias).scaled(opacity=options.thickness, emission=options.glow)
    if options.anisotropy is not None:
        look = replace(look, anisotropy=options.anisotropy)
    return Studio(options=options, lamps=lamps, look=look, ramp="gray", rate=rate, device=device)


def stand_ins(look: Look, there: Sequence[str]) -> list[str]:
    """Return sentences about ramps whose own field is not there."""
    there = [*there, *(["speed"] if "velocity" in there else [])]
    lines = []
    for name, chosen in look.fields(there).items():
        wanted = next(iter(look.ramps[name].inputs))
        if wanted != chosen:
            lines.append(f"the {name} of {look.name} wants {wanted}, which is not there: {chosen} stands in for it")
    return lines


def _alike(one: Lighting, other: Lighting) -> bool:
    """Tell whether two lights are the same."""
    suns = [[(*sun.direction, *sun.color) for sun in light.suns] for light in (one, other)]
    return suns[0] == suns[1] and np.array_equal(one.ambient, other.ambient)


def _array(grid: np.ndarray, device) -> wp.array:
    return wp.array(np.ascontiguousarray(grid, np.float32), dtype=float, device=device)
