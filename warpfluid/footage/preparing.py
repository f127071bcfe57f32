"""Sources made ready: background, white, and a look at whether there is light."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from warpfluid.footage.matting import LIT, Matting, parse_crop
from warpfluid.footage.sources import Source, spread
from warpfluid.options import InputOptions

SAMPLED_FRAMES = 15  # for the median background and the white of float footage
CHECKED_FRAMES = 5  # looked at before a run starts
MEDIAN_FRAMES = 3
ALL_WHITE = 0.99  # share of saturated pixels that no picture of a fluid has


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
        shift=source.alignment.shift,
        scale=source.alignment.scale,
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


def expose(sources: list[Source], frames: Sequence[int]) -> list[Source]:
    """Give float footage one white: the brightest pixel of a sample of frames, over all views."""
    floats = [source for source in sources if not is_integer(source)]
    sample = spread(frames, SAMPLED_FRAMES)
    white = max((float(source.light(frame).max()) for source in floats for frame in sample), default=0.0)
    return [source if is_integer(source) else source.with_matting(white=white or 1.0) for source in sources]


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
