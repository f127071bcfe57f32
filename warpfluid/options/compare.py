"""What ``warpfluid compare`` measures and shows."""

from dataclasses import dataclass
from typing import Annotated, Literal

from warpfluid.options.checks import check_options


@dataclass(frozen=True, kw_only=True)
class CompareOptions:
    """The frames and angles that are measured, and how the film is made."""

    frames: Annotated[str | None, "Frames to compare, such as 1-24; by default all that are in all of them"] = None
    measured_frames: Annotated[int, "Frames whose pictures are measured, spread over all"] = 5
    scored_angles: Annotated[
        str | None,
        "Angles of unseen views, such as 30,45,60 [degree]; by default every 15 but those near a given view",
    ] = None
    look: Annotated[
        Literal["fire", "smoke", "explosion", "blackbody", "water", "gray", "jet"] | None,
        "Colours of film and sheet; by default those of the first",
    ] = None
    fps: Annotated[float, "Pictures a second of the film"] = 24.0
    start_angle: Annotated[float, "Where the camera begins [degree]"] = 0.0
    turn_step: Annotated[float, "How far the camera walks between two pictures [degree]; 0 stands still"] = 3.0

    def __post_init__(self):
        check_options(self)
