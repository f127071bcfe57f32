"""What a preview shows at first."""

from dataclasses import dataclass
from typing import Annotated, Literal

from warpfluid.options.checks import check_options

PARTS = ("volume", "slices", "arrows", "streamlines", "pictures", "bodies", "box")


@dataclass(frozen=True, kw_only=True)
class PreviewOptions:
    """How volumes are looked at: in a window, in a page, or in a picture."""

    frames: Annotated[str | None, "Frames to show, such as 1001-1024 or 1-100x2; all by default"] = None
    look: Annotated[
        Literal["fire", "smoke", "explosion", "blackbody", "water", "gray", "jet"] | None,
        "Colours; those of the run by default, fire for volumes of other programs",
    ] = None
    exposure: Annotated[float, "Stops brighter than the footage"] = 0.0
    angle: Annotated[float | None, "Where the camera stands at first [degree]; at the first view by default"] = None
    elevation: Annotated[
        float | None, "How high it stands above the floor's plane [degree]; 0 in a page, 15 in a window by default"
    ] = None
    show: Annotated[
        str, "Parts of the window, with commas: volume, slices, arrows, streamlines, pictures, bodies, box"
    ] = "volume,pictures,bodies,box"
    window: Annotated[str, "Width and height of the window and the screenshot [pixel]"] = "1280x800"
    html_size: Annotated[float, "How large a page may get [MB]; volumes are stored coarser to fit"] = 24.0

    def __post_init__(self):
        problems = []
        unknown = sorted(set(self.parts) - set(PARTS)) if isinstance(self.show, str) else ()
        if unknown:
            problems.append(f"show is {self.show!r}, there is no {unknown[0]!r}: choose from {', '.join(PARTS)}")
        sides = self.window.split("x") if isinstance(self.window, str) else ()
        if isinstance(self.window, str) and (len(sides) != 2 or not all(map(_is_side, sides))):
            problems.append(f"window is {self.window!r}, expected WIDTHxHEIGHT of 16 to 8192 pixels, such as 1280x800")
        check_options(self, problems)

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of what is shown."""
        return tuple(part.strip() for part in self.show.split(",") if part.strip())

    @property
    def window_size(self) -> tuple[int, int]:
        """Width and height [pixel]."""
        width, height = self.window.split("x")
        return int(width), int(height)


def _is_side(text: str) -> bool:
    """Return whether a text is a number of pixels that a window may have."""
    return text.isascii() and text.isdigit() and 16 <= int(text) <= 8192
