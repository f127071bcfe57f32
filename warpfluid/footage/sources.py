"""The footage of one view, and how its pictures become images."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from warpfluid.footage.matting import LIT, Matting, parse_crop, parse_resolution
from warpfluid.options import InputOptions

SMALLEST = 8  # pixels; below this there is no pyramid to speak of
SAMPLED_FRAMES = 15  # for the median background and the white of float footage
CHECKED_FRAMES = 5  # looked at before a run starts
MEDIAN_FRAMES = 3
ALL_WHITE = 0.99  # share of saturated pixels that no picture of a fluid has
STRETCH = 0.02  # change of proportions that is worth a note
HASHED_BYTES = 1 << 20


@dataclass(frozen=True, kw_only=True)
class Source:
    """The footage of one view.

    Attributes:
        angle_deg: Angle of the view.
        footage: What ``open_footage`` returned.
        offset: Frame of the shot less frame of the footage: videos count from 1, sequences as their files do.
        matting: How its pictures become images.
    """

    angle_deg: float
    footage: object
    offset: int = 0
    matting: Matting | None = None

    @property
    def name(self) -> str:
        """The view as the command line names it, ANGLE=PATH."""
        return f"{self.angle_deg:g}={self.footage.source}"

    @property
    def frames(self) -> tuple[int, ...]:
        """The frames that the footage has, in the shot's numbers."""
        return tuple(frame + self.offset for frame in self.footage.frames)

    def light(self, frame: int) -> np.ndarray:
        """Return the light of a frame, shape (rows, columns), before it is scaled."""
        return self.matting.light(self.footage.read(frame - self.offset))

    def image(self, frame: int) -> np.ndarray:
        """Return the image of a frame, shape (u, v), 255 for white."""
        return self.matting.image(self.footage.read(frame - self.offset))

    def with_matting(self, **changes) -> "Source":
        """Return the source with another preparation."""
        return replace(self, matting=replace(self.matting, **changes))


def parse_view(view: str | tuple[float, str]) -> tuple[float, str]:
    """Return angle and path of ``ANGLE=PATH`` or a pair."""
    angle, equals, path = view.partition("=") if isinstance(view, str) else (view[0], "=", str(view[1]))
    try:
        angle_deg = float(angle)
    except ValueError:
        equals = ""
    if not equals or not path.strip():
        raise ValueError(f"view {view!r} is not ANGLE=PATH with an angle in degrees, such as 0=front.mp4")
    return angle_deg, path.strip()


def image_size(source: Source, options: InputOptions, notes: list[str]) -> tuple[int, int]:
    """Return width and height of a view's images [pixel]: its footage, cropped and reduced.

    Raises:
        ValueError: If the crop does not fit, or the resolution would enlarge the picture or leave too little.
    """
    width, height = source.footage.size
    if options.crop:
        crop_width, crop_height, left, top = parse_crop(options.crop)
        if left + crop_width > width or top + crop_height > height:
            raise ValueError(f"--crop {options.crop} does not fit into {source.name}, {width} x {height} pixels")
        width, height = crop_width, crop_height
    size = width, height
    if options.resolution:
        new_width, new_height = parse_resolution(options.resolution)
        size = new_width, new_height or max(1, round(new_width * height / width))
        if size[0] > width or size[1] > height:
            raise ValueError(
                f"--resolution {options.resolution} is larger than {source.name}, {width} x {height} pixels: "
                "pictures are only ever reduced"
            )
        if abs(size[0] * height / (size[1] * width) - 1) > STRETCH and new_height:
            notes.append(f"{source.name} changes its proportions, {width} x {height} to {size[0]} x {size[1]}")
    if min(size) < SMALLEST:
        raise ValueError(f"{source.name} has {size[0]} x {size[1]} pixels: at least {SMALLEST} x {SMALLEST} are needed")
    return size


def prepare(source: Source, frames: Sequence[int], size: tuple[int, int], options: InputOptions) -> Source:
    """Return a source with its preparation, all but the white of float footage.

    Args:
        source: Footage of one view.
        frames: Frames of the shot, for the median background.
        size: Width and height of the images [pixel].
        options: How pictures become images.

    Raises:
        ValueError: If there is no background picture of the footage's size, or too few frames for a median.
    """
    prepared = Matting(
        size=size,
        crop=parse_crop(options.crop) if options.crop else None,
        decode="none" if source.footage.linear else options.decode,
        white=options.white or 1.0,
        black_level=options.black_level,
        largest_component=options.largest_component,
    )
    source = replace(source, matting=prepared)
    if options.white and options.white > 1 and is_integer(source):
        raise ValueError(
            f"--white {options.white:g} is above 1, but {source.name} holds integers, which count as 0 to 1: "
            "give a value up to 1, such as 0.8"
        )
    if not options.background:
        return source
    return source.with_matting(background=_background(source, frames, options.background))


def is_integer(source: Source) -> bool:
    """Whether the footage holds integers, whose full range is known."""
    return source.footage.depth != "float"


def check_light(source: Source, frames: Sequence[int]) -> None:
    """Look at a few frames, and refuse a view that is black or white in all of them.

    Raises:
        ValueError: If there is nothing to reconstruct.
    """
    greys = [source.image(frame) for frame in spread(frames, CHECKED_FRAMES)]
    if all(grey.max() <= LIT for grey in greys):
        raise ValueError(
            f"{source.name} is black in every frame looked at: "
            "check the footage, --black-level, --background and --white"
        )
    if all((grey >= 254.5).mean() >= ALL_WHITE for grey in greys):
        raise ValueError(
            f"{source.name} is white all over: "
            "take the background off with --background or --black-level, or raise --white"
        )


def spread(frames: Sequence[int], count: int) -> list[int]:
    """Return at most ``count`` of the frames, evenly spread, the first and last among them."""
    places = np.unique(np.linspace(0, len(frames) - 1, min(count, len(frames))).round().astype(int))
    return [frames[place] for place in places]


def file_hash(paths: Sequence[str | Path]) -> str:
    """Return a SHA-256 over the name, size, first and last megabyte of every file, quick on long footage."""
    digest = hashlib.sha256()
    for path in map(Path, paths):
        size = path.stat().st_size
        digest.update(f"{path.name}\0{size}\0".encode())
        with path.open("rb") as file:
            digest.update(file.read(HASHED_BYTES))
            file.seek(max(size - HASHED_BYTES, HASHED_BYTES if size > HASHED_BYTES else size))
            digest.update(file.read())
    return digest.hexdigest()


def _background(source: Source, frames: Sequence[int], background: str) -> np.ndarray:
    """Return the light of the empty set: of a picture, or the median over the frames."""
    if background == "median":
        if len(frames) < MEDIAN_FRAMES:
            raise ValueError(
                f"--background median needs at least {MEDIAN_FRAMES} frames, {source.name} has "
                f"{len(frames)}: give a picture of the empty set"
            )
        lights = [source.light(frame) for frame in spread(frames, SAMPLED_FRAMES)]
        return np.median(lights, axis=0).astype(np.float32)
    from warpfluid.files.images import read_image

    plate = read_image(background)
    if plate.shape[1::-1] != tuple(source.footage.size):
        (columns, rows), (width, height) = plate.shape[1::-1], source.footage.size
        raise ValueError(
            f"--background {background} has {columns} x {rows} pixels, {source.name} {width} x {height}: "
            "give a picture of the same size"
        )
    return source.matting.light(plate)
