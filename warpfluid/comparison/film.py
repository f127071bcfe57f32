"""Results side by side: a film that plays while the camera walks around, and a sheet of stills; names in letters."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from warpfluid.comparison.entries import Entry
from warpfluid.rendering.turntable import GAP, in_a_row, render_turntable

FILMS, SHEET = (".mp4", ".webp", ".gif"), ".png"
SHORTEST = 72  # pictures of a film that stands still
NAME, NOTE = 15, 12  # height of the letters [pixel]
PAPER, INK, SOFT = (16, 16, 18), (236, 232, 226), (150, 145, 138)
LINE = 1.5  # of the letters' height
SHEET_FRAMES = 3


def write_film(
    path: str | Path,
    entries: Sequence[Entry],
    frames: Sequence[int],
    *,
    look: str = "fire",
    fps: float = 24.0,
    start_deg: float = 0.0,
    step_deg: float = 3.0,
) -> None:
    """Film entries side by side; short sequences are repeated until the turn is full.

    Args:
        path: The film, .mp4, .webp or .gif.
        entries: The columns.
        frames: Frames that all have.
        look: Name of a colour ramp.
        fps: Pictures a second.
        start_deg: Where the camera begins.
        step_deg: How far it walks between two pictures; 0 stands still.

    Raises:
        ValueError: If the ending or the rate will not do, or a volume is damaged.
        OSError: If a file cannot be read or written.
    """
    from warpfluid.files.video import write_animation, write_video

    write = write_video if Path(path).suffix == ".mp4" else write_animation
    write(path, film_pictures(entries, frames, look, start_deg, step_deg), fps)


def film_pictures(
    entries: Sequence[Entry], frames: Sequence[int], look: str, start_deg: float, step_deg: float
) -> Iterator[np.ndarray]:
    """Yield the pictures of a film, uint8, shape (rows, columns, 3); frame i % n is seen in picture i."""
    turn = int(np.ceil(360 / abs(step_deg))) if step_deg else -(-SHORTEST // len(frames)) * len(frames)
    count = max(turn, len(frames))
    angles = (start_deg + step_deg * np.arange(count)) % 360
    columns = [_turning(entry, frames, angles, look) for entry in entries]
    names = [entry.name for entry in entries]
    for i, pictures in enumerate(zip(*columns, strict=True)):
        yield lettered(in_a_row(pictures), names, f"frame {frames[i % len(frames)]}   {angles[i]:.0f}°")


def write_sheet(
    path: str | Path, entries: Sequence[Entry], frames: Sequence[int], angles_deg: Sequence[float], *, look: str
) -> None:
    """Write stills as one picture: a row an entry, a column a frame and angle.

    Args:
        path: The picture, .png.
        entries: The rows.
        frames: Frames that all have; a few of them are shown.
        angles_deg: Angles to show.
        look: Name of a colour ramp.

    Raises:
        ValueError: If a volume is damaged.
        OSError: If a file cannot be read or written.
    """
    from warpfluid.files.images import write_png

    middles = (np.arange(SHEET_FRAMES) + 0.5) / SHEET_FRAMES * len(frames)
    shown = [frames[place] for place in np.unique(middles.astype(int))]
    rows = []
    for entry in entries:
        stills = [picture for frame in shown for picture in _pictures(entry, frame, angles_deg, look)]
        rows.append(named(in_a_row(stills), entry.name))
    labels = [f"frame {frame}   {angle:.0f}°" for frame in shown for angle in angles_deg]
    rows[-1] = lettered(rows[-1], labels)
    line = np.full((GAP, *rows[0].shape[1:]), PAPER, np.uint8)
    write_png(path, np.concatenate([part for row in rows for part in (line, row)][1:]))


def named(row: np.ndarray, name: str) -> np.ndarray:
    """Return pictures with a name in their upper left corner."""
    from PIL import Image, ImageDraw

    canvas = Image.fromarray(row)
    draw = ImageDraw.Draw(canvas)
    draw.text((8, 6), fitted(draw, name, row.shape[1]), INK, font_size=NAME, stroke_width=2, stroke_fill=(0, 0, 0))
    return np.asarray(canvas)


def lettered(row: np.ndarray, names: Sequence[str], note: str = "") -> np.ndarray:
    """Return pictures in a row with a name in the middle under each, and a note below at the left.

    Args:
        row: uint8, shape (rows, columns, 3), as ``in_a_row`` returns it.
        names: One a picture.
        note: What is true of all.
    """
    from PIL import Image, ImageDraw

    rows, columns = row.shape[:2]
    width = (columns - GAP * (len(names) - 1)) // len(names)
    name_line, note_line = round(NAME * LINE), round(NOTE * LINE) * bool(note)
    canvas = Image.new("RGB", (columns, rows + name_line + note_line), PAPER)
    canvas.paste(Image.fromarray(row))
    draw = ImageDraw.Draw(canvas)
    for i, name in enumerate(names):
        middle = i * (width + GAP) + width / 2
        draw.text((middle, rows + name_line / 2), fitted(draw, name, width), INK, anchor="mm", font_size=NAME)
    draw.text(
        (6, rows + name_line + note_line / 2), fitted(draw, note, columns, NOTE), SOFT, anchor="lm", font_size=NOTE
    )
    return np.asarray(canvas)


def fitted(draw, text: str, width: float, size: int = NAME) -> str:
    """Return a text that is at most so wide [pixel], its middle left out if need be."""
    for keep in range(len(text), 1, -1):
        head = keep // 2
        shown = text if keep == len(text) else f"{text[:head]}..{text[head - keep :]}"
        if draw.textlength(shown, font_size=size) <= width - 8:
            return shown
    return text[:1]


def _pictures(entry: Entry, frame: int, angles_deg: Sequence[float], look: str) -> np.ndarray:
    """Return a frame from some angles, with what stands in it."""
    return render_turntable(entry.volume(frame), angles_deg, look, surfaces=entry.surfaces(frame))


def _turning(entry: Entry, frames: Sequence[int], angles_deg: np.ndarray, look: str) -> list[np.ndarray]:
    """Return the pictures of one entry; every volume is read once."""
    film: list[np.ndarray] = [np.empty(0)] * len(angles_deg)
    for first, frame in enumerate(frames):
        places = range(first, len(angles_deg), len(frames))
        angles = [float(angles_deg[place]) for place in places]
        kinds, where = np.unique(angles, return_inverse=True)
        pictures = _pictures(entry, frame, kinds, look)
        for place, which in zip(places, where, strict=True):
            film[place] = pictures[which]
    return film
