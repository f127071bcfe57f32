"""A shot: the footage of one or more views, checked, paired by frame and prepared."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from warpfluid.errors import Problems
from warpfluid.files.sequences import format_frames, parse_frames
from warpfluid.footage import matting
from warpfluid.footage.sources import (
    SAMPLED_FRAMES,
    Source,
    check_light,
    file_hash,
    image_size,
    is_integer,
    parse_view,
    prepare,
    spread,
)
from warpfluid.options import InputOptions
from warpfluid.views import Views, angle_problems


@dataclass(frozen=True, kw_only=True)
class Shot:
    """Views over time.

    Attributes:
        sources: The footage of each view.
        frames: Frames to reconstruct, which every view has.
        equalize_rows: Whether ``views`` gives every view the same total in each row.
        notes: Sentences on what was decided for the user.
    """

    sources: tuple[Source, ...]
    frames: tuple[int, ...]
    equalize_rows: bool = True
    notes: tuple[str, ...] = ()

    @property
    def angles_deg(self) -> tuple[float, ...]:
        """Angle of each view."""
        return tuple(source.angle_deg for source in self.sources)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of an image (u, v) [pixel]."""
        return self.sources[0].matting.size

    @property
    def rate(self) -> float | None:
        """Frames a second, where a view's footage says so."""
        return next((source.footage.rate for source in self.sources if source.footage.rate), None)

    @property
    def white(self) -> float | None:
        """Pixel value that counts as white, if all footage is float; integers have their own."""
        return None if any(map(is_integer, self.sources)) else self.sources[0].matting.white

    @property
    def step(self) -> int:
        """Frames from one picture of the footage to the next: 2 for a sequence on twos."""
        return min((b - a for a, b in pairwise(self.sources[0].frames)), default=1)

    def views(self, frame: int, *, equalize_rows: bool | None = None) -> Views:
        """Return the images of a frame; they may be black all over.

        Args:
            frame: One of ``frames``, or another one that every view has.
            equalize_rows: Instead of the shot's own choice.

        Raises:
            ValueError: If the shot has no such frame.
        """
        lacking = [source.name for source in self.sources if frame not in source.frames]
        if lacking:
            raise ValueError(f"{' and '.join(lacking)} has no frame {frame}")
        images = np.stack([source.image(frame) for source in self.sources])
        if self.equalize_rows if equalize_rows is None else equalize_rows:
            images = matting.equalize_rows(images)
        return Views(images, self.angles_deg)

    def hashes(self) -> dict[str, str]:
        """Return a SHA-256 of the footage of each view, by its angle.

        It covers name, size, first and last megabyte of every file, to stay quick on long footage.
        """
        return {f"{source.angle_deg:.15g}": file_hash(source.footage.paths) for source in self.sources}


def open_shot(views: Sequence[str | tuple[float, str]], options: InputOptions | None = None) -> Shot:
    """Open the footage of every view and check all of it.

    Image sequences are paired by the numbers of their files; a video starts where the sequences start, and
    at 1 among videos.

    Args:
        views: ``ANGLE=PATH``, or pairs of angle and path.
        options: How pictures become images.

    Raises:
        ValueError: If anything is wrong with any view or option; one line each.
    """
    options = options or InputOptions()
    problems, notes = Problems(), []
    asked = _check_options(options, problems)
    sources = _open_sources(views, problems)
    if not sources:
        problems.raise_if_any()
    sources = _align(sources, notes)
    frames = _common_frames(sources, asked, problems, notes)
    sizes = [problems.attempt(image_size, source, options, notes) for source in sources]
    if None not in sizes and len(set(sizes)) > 1:
        found = ", ".join(f"{s.name} {w} x {h}" for s, (w, h) in zip(sources, sizes, strict=True))
        problems.append(f"the views have unlike sizes ({found}): make them equal with --resolution or --crop")
    for source in sources:
        # a damaged picture must not come up in the middle of a long run
        for frame in sorted(set(frames) & set(source.frames)):
            problems.attempt(source.footage.read, frame - source.offset)
    problems.raise_if_any()
    sources = [problems.attempt(prepare, source, frames, sizes[0], options) for source in sources]
    problems.raise_if_any()
    if options.white is None:
        sources = _expose(sources, frames)
    for source in sources:
        problems.attempt(check_light, source, frames)
    problems.raise_if_any()
    equalize = options.equalize_rows
    return Shot(sources=tuple(sources), frames=frames, equalize_rows=equalize, notes=tuple(notes))


def _check_options(options: InputOptions, problems: Problems) -> list[int] | None:
    """Return the frames asked for; note what is wrong with any option."""
    asked = problems.attempt(parse_frames, options.frames) if options.frames else None
    if options.crop:
        problems.attempt(matting.parse_crop, options.crop)
    if options.resolution:
        problems.attempt(matting.parse_resolution, options.resolution)
    if options.white is not None and not (math.isfinite(options.white) and options.white > 0):
        problems.append(f"--white {options.white:g} is not a pixel value above 0")
    return asked


def _open_sources(views, problems: Problems) -> list[Source]:
    """Return the sources of the views that can be opened."""
    from warpfluid.files.footage import open_footage

    pairs = [problems.attempt(parse_view, view) for view in views]
    pairs = [pair for pair in pairs if pair]
    if not views:
        problems.append("there is no view: give one or more with --view ANGLE=PATH")
    problems.extend(angle_problems([angle for angle, _ in pairs]))
    footages = [problems.attempt(open_footage, path, where=f"view {angle:g}: ") for angle, path in pairs]
    return [
        Source(angle_deg=angle, footage=footage)
        for (angle, _), footage in zip(pairs, footages, strict=True)
        if footage is not None
    ]


def _align(sources: list[Source], notes: list[str]) -> list[Source]:
    """Let videos start where the image sequences start, and single pictures stand for the same frame."""
    firsts = [source.frames[0] for source in sources if source.footage.kind != "video"]
    if all(len(source.frames) == 1 for source in sources):
        return [replace(source, offset=sources[0].frames[0] - source.frames[0]) for source in sources]
    if not firsts or len(firsts) == len(sources):
        return sources
    first = max(firsts)
    notes.append(f"videos start at frame {first}, where the image sequences start")
    return [
        replace(source, offset=first - source.frames[0]) if source.footage.kind == "video" else source
        for source in sources
    ]


def _common_frames(
    sources: list[Source], asked: list[int] | None, problems: Problems, notes: list[str]
) -> tuple[int, ...]:
    """Return the frames to reconstruct; note the views that lack any of them."""
    first = max(source.frames[0] for source in sources)
    last = min(source.frames[-1] for source in sources)
    if first > last and not asked:
        spans = ", ".join(f"{source.name} has {format_frames(source.frames)}" for source in sources)
        problems.append(f"the views have no frame in common ({spans}): number their files alike")
        return ()
    wanted = sorted(set(asked)) if asked else _expected_frames(sources, first, last)
    for source in sources:
        missing = sorted(set(wanted) - set(source.frames))
        if missing:
            way_out = "" if asked else ": mend the sequence or leave them out with --frames"
            have = f" (it has {format_frames(source.frames)})" if asked else ""
            problems.append(f"{source.name} lacks frame {format_frames(missing)}{have}{way_out}")
        elif not asked and (source.frames[0], source.frames[-1]) != (first, last):
            span = f"{format_frames(source.frames)}, the others less"
            notes.append(f"{source.name} has frames {span}: {format_frames(wanted)} are used")
    return tuple(wanted)


def _expected_frames(sources: list[Source], first: int, last: int) -> list[int]:
    """Return the frames from first to last that any view has, and those its step would have put there."""
    expected: set[int] = set()
    for source in sources:
        frames = [frame for frame in source.frames if first <= frame <= last]
        step = min((b - a for a, b in pairwise(frames)), default=1)
        expected |= {*frames, *range(frames[0], frames[-1] + 1, step)} if frames else set()
    return sorted(expected)


def _expose(sources: list[Source], frames: Sequence[int]) -> list[Source]:
    """Give float footage one white: the brightest pixel of a sample of frames, over all views."""
    floats = [source for source in sources if not is_integer(source)]
    sample = spread(frames, SAMPLED_FRAMES)
    white = max((float(source.light(frame).max()) for source in floats for frame in sample), default=0.0)
    return [source if is_integer(source) else source.with_matting(white=white or 1.0) for source in sources]
