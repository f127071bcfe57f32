"""Views aligned with the first one, by the row sums of their frames."""

from collections.abc import Sequence
from dataclasses import asdict, replace

import numpy as np

from warpfluid.footage.alignment import Alignment, ViewAlignment, given_numbers, with_numbers
from warpfluid.footage.preparing import expose, prepare
from warpfluid.footage.row_alignment import Match, match_row_sums
from warpfluid.footage.row_sums import disagreement
from warpfluid.footage.sources import Source
from warpfluid.footage.tone import undo_shoulder
from warpfluid.options import InputOptions

COMPARED_FRAMES = 120
STEADY = 0.02  # change of row sums over their size; below it nothing tells when a view plays


def align_views(
    sources: Sequence[Source],
    options: InputOptions,
    size: tuple[int, int],
    asked: Sequence[int] | None,
    shoulder: float,
    notes: list[str],
) -> tuple[list[Source], tuple[ViewAlignment, ...], InputOptions]:
    """Find how every other view is aligned with the first; what is given by hand is kept.

    Args:
        sources: With the alignment that is given by hand.
        options: How pictures become images.
        size: Width and height of the images [pixel].
        asked: Frames that were asked for; those about their middle are compared, whether or not they are among them.
        shoulder: Tone curve behind which light is compared.
        notes: Sentences on what was decided are added.

    Returns:
        The aligned sources, what was found, and options that give the numbers by hand.

    Raises:
        ValueError: If a view cannot be aligned; one line each.
    """
    angles = [source.angle_deg for source in sources]
    given, found, problems = given_numbers(options, angles), [], []
    lacking = [i for i, numbers in enumerate(given) if i and len(numbers) < len(asdict(Alignment()))]
    if len(sources) == 1:
        notes.append("there is one view, and nothing to align it with")
    sums, step = _row_sums(sources, given, lacking, options, size, asked, shoulder) if lacking else (None, 1)
    for i in lacking:
        try:
            aligned = _align(sums[0], sums[i], sources[i], given[i], step, size, options)
        except ValueError as error:
            problems.append(_refusal(error, sources[i], sources[0]))
            continue
        found.append(replace(aligned, reference_deg=angles[0]))
        given[i] = asdict(aligned.alignment)
        if _change(sums[0]) < STEADY and not aligned.alignment.time:
            notes.append(f"view {angles[i]:g}: the rows hardly change, so nothing tells when it plays")
    if problems:
        raise ValueError("\n".join(problems))
    aligned = [replace(source, alignment=Alignment(**numbers)) for source, numbers in zip(sources, given, strict=True)]
    return aligned, tuple(found), with_numbers(options, angles, given)


def _row_sums(sources, given, lacking, options: InputOptions, size, asked, shoulder: float) -> tuple[np.ndarray, int]:
    """Return row sums (view, step, v) of successive pictures, and the frames of a step; holes are filled in between.

    A view whose alignment is wanted plays at the time that is given, and is otherwise as it is in its files.
    """
    raw = [
        replace(source, alignment=Alignment(time=given[i].get("time", 0.0))) if i in lacking else source
        for i, source in enumerate(sources)
    ]
    frames = _compared(raw, asked)
    raw = [prepare(source, frames, size, options) for source in raw]
    if options.white is None:
        raw = expose(raw, frames)
    sums = np.array([[_sum(source, frame, shoulder) for frame in frames] for source in raw])
    step = raw[0].step
    grid = np.arange(frames[0], frames[-1] + 1, step)
    flat = sums.transpose(1, 0, 2).reshape(len(frames), -1)
    filled = np.stack([np.interp(grid, frames, column) for column in flat.T], axis=1)
    return filled.reshape(len(grid), len(raw), -1).transpose(1, 0, 2), step


def _sum(source: Source, frame: int, shoulder: float) -> np.ndarray:
    """Return the linear light in each image row of a frame."""
    light = undo_shoulder(source.image(frame), shoulder)
    return source.alignment.gain * light.sum(axis=0, dtype=np.float64)


def _compared(sources: list[Source], asked: Sequence[int] | None) -> list[int]:
    """Return the frames to compare: those that every view has, about the middle of the ones that are asked for."""
    frames = sorted(set.intersection(*(set(source.frames) for source in sources)))
    if not frames:
        raise ValueError("the views have no frame in common to compare: number their files alike")
    wanted = [frame for frame in asked or frames if frames[0] <= frame <= frames[-1]] or frames
    middle = int(np.searchsorted(frames, (wanted[0] + wanted[-1]) / 2))
    start = min(max(0, middle - COMPARED_FRAMES // 2), max(0, len(frames) - COMPARED_FRAMES))
    return frames[start : start + COMPARED_FRAMES]


def _align(
    reference: np.ndarray, sums: np.ndarray, source: Source, given: dict, step: int, size, options: InputOptions
) -> ViewAlignment:
    """Return the alignment of one view, in frames and in pixels of its footage."""
    height = source.footage.size[1] if not options.crop else _cropped_height(options.crop)
    pixel = height / size[1]  # footage pixels of an image row
    fixed = {"time": 0.0} if "time" in given else {}
    fixed |= {"shift": given["shift"] / pixel} if "shift" in given else {}
    fixed |= {"scale": given["scale"]} if "scale" in given else {}
    match = match_row_sums(reference, sums, fixed, subframe=options.align_subframe)
    return ViewAlignment(
        angle_deg=source.angle_deg,
        reference_deg=0.0,
        alignment=Alignment(**_numbers(match, step, pixel) | given),
        disagreement=disagreement(reference, sums),
        disagreement_after=match.disagreement,
        correlation=match.correlation,
    )


def _numbers(match: Match, step: int, pixel: float) -> dict[str, float]:
    """Return a match as people give it by hand, with as many digits as it can be told to."""
    return {
        "time": round(match.time * step, 2),
        "shift": round(match.shift * pixel, 2) + 0.0,
        "scale": round(match.scale, 4),
        "gain": round(match.gain, 4),
    }


def _cropped_height(crop: str) -> int:
    from warpfluid.footage.matting import parse_crop

    return parse_crop(crop)[1]


def _change(sums: np.ndarray) -> float:
    """Return how much row sums change over time, as a part of their size."""
    return float(np.sqrt(((sums - sums.mean(axis=0)) ** 2).mean() / max((sums**2).mean(), 1e-12)))


def _refusal(error: ValueError, source: Source, reference: Source) -> str:
    return (
        f"view {source.angle_deg:g} cannot be aligned with view {reference.angle_deg:g}: {error}; "
        f"see whether both show one fluid, or give what is known with --view-time {source.angle_deg:g}=FRAMES, "
        "--view-shift, --view-scale, --view-gain, without --align"
    )
