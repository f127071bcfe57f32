"""What ``warpfluid compare`` does, once its flags are read."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from warpfluid.comparison.comparison import Comparison, compare_entries
from warpfluid.comparison.entries import Entry, common_frames, make_entries, same_units
from warpfluid.comparison.film import FILMS, SHEET, write_film, write_sheet
from warpfluid.comparison.text import comparison_lines
from warpfluid.errors import Problems, describe
from warpfluid.files.folders import check_writable
from warpfluid.files.sequences import parse_frames
from warpfluid.footage.origin import Footage, find_footage, find_reconstruction
from warpfluid.footage.sources import spread
from warpfluid.metrics import SMALLEST_SIDE
from warpfluid.options import CompareOptions
from warpfluid.progress import Progress
from warpfluid.volumes import open_volumes


@dataclass(frozen=True, kw_only=True)
class Field:
    """Everything that takes part.

    Attributes:
        entries: What is compared, in one unit.
        truth: The true volumes.
        footage: What the first entry with footage was made of.
        frames: Frames that all have.
        measured: Those whose pictures are measured.
        notes: Sentences on what was decided.
    """

    entries: tuple[Entry, ...]
    truth: Entry | None
    footage: Footage | None
    frames: tuple[int, ...]
    measured: tuple[int, ...]
    notes: tuple[str, ...]


def compare(names: Sequence[str], truth: str | None, options: CompareOptions, outs: Sequence[Path], common) -> int:
    """Compare runs or volumes; return the exit code."""
    from warpfluid.device import pick_device

    log, problems = Progress(quiet=common.quiet, verbose=common.verbose), Problems()
    problems.extend(_wrong_outs(outs))
    for path in outs:
        problems.attempt(check_writable, path.parent)
    angles = problems.attempt(_angles, options.scored_angles)
    device = problems.attempt(pick_device, common.device)
    field = problems.attempt(_open, names, truth, options)
    problems.raise_if_any()
    for entry in field.entries:
        log.notes(f"{entry.name}: {text}" for text in entry.volumes.messages)
    facts = {"truth": field.truth, "footage": field.footage, "unseen_deg": angles, "device": device}
    progress = lambda frame: log.line(f"measure frame {frame}")  # noqa: E731
    comparison = compare_entries(field.entries, field.frames, field.measured, **facts, progress=progress)
    comparison = replace(comparison, notes=field.notes)
    _show(outs, field, comparison, options, log)
    if common.json:
        print(json.dumps(comparison.to_dict() | {"files": [str(path) for path in outs]}))
    else:
        print("\n".join(comparison_lines(comparison)))
    return 0


def _open(names: Sequence[str], truth: str | None, options: CompareOptions) -> Field:
    """Open everything, and check that it can be compared."""
    if len(names) + bool(truth) < 2:
        raise ValueError("there is nothing to compare it with: name another run, or the truth with --truth")
    problems = Problems()
    sequences = [problems.attempt(open_volumes, name) for name in [*names, *([truth] if truth else [])]]
    problems.raise_if_any()
    entries = make_entries(sequences)
    width, height = _size(entries[0])
    frames = common_frames(entries, parse_frames(options.frames) if options.frames else None)
    measured = tuple(spread(frames, options.measured_frames))
    footage, notes = _footage(entries[: len(names)])
    wanted = _total(footage, measured)
    if footage and footage.shot.size != (width, height):
        u, v = footage.shot.size
        notes.append(f"the footage has {u} x {v} pixels, the volumes {width} x {height}: it is left out")
        footage = None
    if any(entry.foreign for entry in entries):
        notes.append("densities of other programs are scaled to the same total light, by one factor for all frames")
        entries = same_units(entries, measured, wanted)
    if not (footage or truth):
        notes.append("there is neither footage nor a truth: name one with --truth to get more numbers")
    return Field(
        entries=tuple(entries[: len(names)]),
        truth=entries[-1] if truth else None,
        footage=footage,
        frames=frames,
        measured=measured,
        notes=tuple(notes),
    )


def _size(entry: Entry) -> tuple[int, int]:
    """Return width and height of the volumes, or refuse those that are too small."""
    width, _, height = entry.shape
    if min(width, height) < SMALLEST_SIDE:
        raise ValueError(
            f"the volumes are {width} x {height} voxels from the front: "
            f"the numbers need at least {SMALLEST_SIDE} a side"
        )
    return width, height


def _footage(entries: Sequence[Entry]) -> tuple[Footage | None, list[str]]:
    """Return the footage of the first entry that was made of any, and what to say about it."""
    notes = []
    for entry in entries:
        try:
            footage = find_footage(entry.volumes.document)
        except (ValueError, OSError) as error:
            lines = describe(error).splitlines()
            notes.append(f"the footage of {entry.name} cannot be opened: {lines[0]}")
            continue
        if footage:
            others = [e.name for e in entries if _views(e) not in (None, _views(entry))]
            notes += [f"{', '.join(others)} is of other footage than {entry.name}"] if others else []
            return footage, notes
    return None, notes


def _views(entry: Entry) -> list[str] | None:
    """Return the views that a run was made of."""
    origin = find_reconstruction(entry.volumes.document)
    return origin["views"] if origin else None


def _total(footage: Footage | None, frames: Sequence[int]) -> float | None:
    """Return all light of the footage over some frames; None if it is not known."""
    if footage is None or footage.shoulder:
        return None
    images = [footage.images(frame) for frame in frames]
    if any(image is None for image in images):
        return None
    return float(sum(image.sum(dtype=float) / len(image) for image in images))


def _angles(text: str | None) -> tuple[float, ...] | None:
    """Return angles that are written one after the other."""
    if text is None:
        return None
    try:
        angles = tuple(float(part) for part in text.split(","))
    except ValueError as error:
        raise ValueError(f"scored-angles is {text!r}, expected degrees such as 30,45,60") from error
    if not all(abs(angle) <= 360 for angle in angles):
        raise ValueError(f"scored-angles is {text!r}, expected degrees from -360 to 360")
    return angles


def _wrong_outs(outs: Sequence[Path]) -> list[str]:
    """Return what is wrong with the files to write."""
    known = (*FILMS, SHEET)
    wrong = [
        f"{path} ends in {path.suffix!r}: films are {', '.join(FILMS)}, a sheet is {SHEET}"
        for path in outs
        if path.suffix not in known
    ]
    return wrong + [
        f"{path.parent} is no folder: make it, or choose another with -o" for path in outs if not path.parent.is_dir()
    ]


def farthest(unseen_deg: Sequence[float], given_deg: Sequence[float]) -> float:
    """Return the unseen angle that is farthest from all given ones; half a turn only mirrors a view."""
    return max(unseen_deg, key=lambda angle: min(abs((angle - given + 90) % 180 - 90) for given in given_deg))


def _show(outs: Sequence[Path], field: Field, comparison: Comparison, options: CompareOptions, log: Progress) -> None:
    """Write the films and sheets."""
    entries = [*field.entries, *([field.truth] if field.truth else [])]
    look = options.look or field.entries[0].volumes.output.look
    for path in outs:
        log.line(f"write   {path}")
        if path.suffix == SHEET:
            angles = [comparison.given_deg[0], farthest(comparison.unseen_deg, comparison.given_deg)]
            write_sheet(path, entries, field.frames, angles, look=look)
        else:
            film = {"fps": options.fps, "start_deg": options.start_angle, "step_deg": options.turn_step}
            write_film(path, entries, field.frames, look=look, **film)
