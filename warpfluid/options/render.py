"""The choices of a picture: where the camera stands, what lights the fluid, how it looks and what is written.

Lengths are in tenths of the box's height from the middle of its floor, x right, y up, z to the viewer at angle 0, as in
a simulation. A ``float | str``, a place and a colour may be keyed over frames (``keys.py``).
"""

import re
from dataclasses import dataclass
from typing import Annotated, Literal

from warpfluid.options.checks import check_options

LONGEST_SIDE = 16384  # of a picture [pixel]


@dataclass(frozen=True, kw_only=True)
class CameraOptions:
    """Where the camera stands."""

    projection: Annotated[
        Literal["auto", "orthographic", "perspective"],
        "Rays that are parallel, as the reconstruction's, or meet in an eye; auto: parallel for the mode sum only",
    ] = "auto"
    angle: Annotated[
        float | str, "Where the camera stands around the box [degree]: 0 in front, 90 to the left of it"
    ] = 0.0
    elevation: Annotated[float | str, "How far above the level it stands, looking down [degree]"] = 0.0
    distance: Annotated[float | str, "From the eye to the target; auto: the box fills the picture at the zoom 1"] = (
        "auto"
    )
    field_of_view: Annotated[float | str, "Angle between the upper and the lower side of the picture [degree]"] = 30.0
    zoom: Annotated[float | str, "Factor by which everything is larger"] = 1.0
    target: Annotated[str | None, "Point x,y,z in the middle of the picture; the middle of the box by default"] = None
    turntable: Annotated[
        int | None, "Pictures of one full turn around the box; the sequence plays meanwhile, again and again"
    ] = None
    camera: Annotated[str | None, "File .json with keys of these numbers, which count instead"] = None
    stereo: Annotated[
        Literal["none", "side-by-side", "separate"], "Two eyes: in one picture, or in files NAME.left and NAME.right"
    ] = "none"
    eye_distance: Annotated[float | str, "Between the two eyes"] = 0.6
    convergence: Annotated[float | str, "Distance that both eyes see at one place; auto: the target's"] = "auto"

    def __post_init__(self):
        check_options(self)


@dataclass(frozen=True, kw_only=True)
class LightOptions:
    """What lights the fluid and what stands in it."""

    key_light: Annotated[str, "Direction x,y,z to the key light"] = "-1,1,0.4"
    key_strength: Annotated[
        float | str | None,
        "Light of the key light: 1 lights a white wall fully; 1.5 by default, 0 with a probe, or fire on the ground",
    ] = None
    key_color: Annotated[str, "Its colour: red,green,blue"] = "1,0.95,0.88"
    ambient: Annotated[
        float | str | None,
        "Light of the sky, which comes from everywhere, not with a probe; 0.12 by default, 0.03 for fire on the ground",
    ] = None
    ambient_color: Annotated[str, "Its colour: red,green,blue"] = "0.75,0.88,1"
    probe: Annotated[
        str | None, "Picture of all surroundings whose light counts instead: latitude and longitude, .exr or .hdr"
    ] = None
    probe_rotation: Annotated[float | str, "Turns the probe around the vertical [degree]"] = 0.0
    probe_strength: Annotated[float | str, "Factor of its light"] = 1.0
    sky: Annotated[bool, "Show the probe behind everything, in place of the backdrop"] = False
    ground: Annotated[bool, "Draw a floor, which takes shadows"] = False
    ground_color: Annotated[str, "Its colour: red,green,blue"] = "0.25,0.25,0.26"
    bodies: Annotated[bool, "Draw the rigid bodies of a simulation"] = True
    body_color: Annotated[str, "Their colour: red,green,blue"] = "0.5,0.5,0.52"

    def __post_init__(self):
        no_probe = self.sky is True and self.probe is None
        check_options(self, ["sky shows the probe, and there is none: name one with --probe"] if no_probe else [])


@dataclass(frozen=True, kw_only=True)
class RenderOptions:
    """The look of a fluid, and the picture."""

    look: Annotated[
        str | None,
        "fire, blackbody, smoke, explosion, water, jet, gray, or a file .json of one's own; the run's own by default",
    ] = None
    mode: Annotated[
        Literal["lit", "emission", "sum"],
        "Everything; without any lamp; or the sum of density along rays, as the footage's grey levels",
    ] = "lit"
    bias: Annotated[float, "Where in a look's ramps amounts fall: above 0 nearer to their end, below to the begin"] = (
        0.0
    )
    thickness: Annotated[float, "Factor of the look's opacity"] = 1.0
    glow: Annotated[float, "Factor of the look's emission"] = 1.0
    anisotropy: Annotated[
        float | None, "Scattering goes on (towards 1), everywhere (0) or back (towards -1); the look's by default"
    ] = None
    edge_fade: Annotated[float, "Width over which the fluid fades at the box's sides [voxel]"] = 0.0
    frames: Annotated[str | None, "Frames to show, such as 1001-1048; all by default"] = None
    grid: Annotated[
        str | None, "Grid of other programs' files to take as density; density, or the only one, by default"
    ] = None
    source_up: Annotated[Literal["y", "z"], "Axis that points up in other programs' files that do not tell"] = "y"
    resolution: Annotated[str | None, "Picture's WIDTHxHEIGHT; the box at 720 lines by default"] = None
    exposure: Annotated[float | str, "Stops by which the picture is made brighter"] = 0.0
    rolloff: Annotated[float, "Light above which brightness is bent so that it stays below white; 1 cuts it off"] = 0.6
    backdrop: Annotated[str, "Colour red,green,blue behind everything, as the screen shows it"] = "0,0,0"
    motion_blur: Annotated[float, "Part of a frame that the shutter is open; velocity is needed"] = 0.0
    blur_samples: Annotated[int, "Moments that a blurred picture is the mean of"] = 8
    error: Annotated[float, "Largest error of a pixel that a step along a ray may make, of white"] = 0.002
    interpolation: Annotated[
        Literal["linear", "cubic"], "Between voxels; cubic shows none of them close up, and takes longer"
    ] = "linear"
    fps: Annotated[float | None, "Frames a second of a film; the run's by default, or 24"] = None
    deep: Annotated[bool, "16 bits a channel in .png"] = False
    half: Annotated[bool, "Half precision in .exr"] = False

    def __post_init__(self):
        try:
            self.size()
        except (ValueError, TypeError) as error:
            check_options(self, [str(error)] if isinstance(self.resolution, str) else ())
        check_options(self)

    def size(self) -> tuple[int, int] | None:
        """Return the picture's width and height [pixel], None for those of the box.

        Raises:
            ValueError: If it is no size.
        """
        if self.resolution is None:
            return None
        match = re.fullmatch(r"(\d{1,5})x(\d{1,5})", self.resolution)
        size = (int(match[1]), int(match[2])) if match else (0, 0)
        if min(size) < 1 or max(size) > LONGEST_SIDE:
            raise ValueError(
                f"resolution is {self.resolution!r}, expected WIDTHxHEIGHT of 1 to {LONGEST_SIDE}, such as 960x540"
            )
        return size
