"""Which frame of one view goes with which of another."""

from dataclasses import replace
from itertools import pairwise

from warpfluid.errors import Problems
from warpfluid.files.sequences import format_frames
from warpfluid.footage.sources import Source


def start_together(sources: list[Source], notes: list[str]) -> list[Source]:
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


def common_frames(
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
