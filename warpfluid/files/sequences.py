"""Numbered image files, and sets of frame numbers as text."""

import os
import re
from collections.abc import Iterable, Mapping
from fnmatch import fnmatchcase
from pathlib import Path

from warpfluid.files.images import IMAGE_SUFFIXES, is_of_views

MOST_FRAMES = 100_000  # more than an hour of film: a longer set is a slip of the hand
MOST_DIGITS = 20  # of a frame number
FORMS = "a folder of images, an image, front.%04d.exr, front.####.exr, front.1001-1100#.exr or front.*.exr"

_RANGE = r"\d{1,9}-\d{1,9}(?:x\d{1,9})?(?:,\d{1,9}(?:-\d{1,9}(?:x\d{1,9})?)?)*"
# where a pattern has the frame number, printf, Nuke or Houdini style; before it may stand the frames to use
_TOKEN = re.compile(rf"(?P<frames>{_RANGE})?(?:%0?\d*d|#+|@+|\$F\d*)")
_LAST_NUMBER = re.compile(r"\d+(?=\D*$)")


def parse_frames(text: str) -> list[int]:
    """Return the frame numbers that a text such as ``1001-1100``, ``1-100x5`` or ``1,5,9`` names.

    Args:
        text: Numbers and ranges with an optional step, separated by commas.

    Returns:
        The frame numbers in rising order, each once.

    Raises:
        ValueError: If the text has another form, a range runs backwards, or the set is absurdly long.
    """
    ranges = [_parse_chunk(chunk.strip(), text) for chunk in text.split(",")]
    count = sum(map(len, ranges))
    if count > MOST_FRAMES:
        raise ValueError(f"frames {text!r} are {count} frames, at most {MOST_FRAMES} are allowed: use a step")
    return sorted({frame for chunk in ranges for frame in chunk})


def format_frames(frames: Iterable[int]) -> str:
    """Return frame numbers as the text that ``parse_frames`` reads, runs of neighbours as ranges."""
    runs: list[list[int]] = []
    for frame in sorted(set(frames)):
        if runs and frame == runs[-1][1] + 1:
            runs[-1][1] = frame
        else:
            runs.append([frame, frame])
    return ",".join(f"{first}" if first == last else f"{first}-{last}" for first, last in runs)


def find_sequence(source: str | Path) -> dict[int, Path]:
    """Return the files of one image sequence by frame number, which is the last number in a file's name.

    Args:
        source: A folder that holds one sequence; a pattern with the frame number as ``%04d``, ``####``,
            ``#``, ``@@@@`` or ``$F4``, which all match any padding; the same with the frames to use before it
            (``front.1001-1100#.exr``); a pattern with ``*``; or one image, frame 1 if it has no number.

    Returns:
        The files in the order of their frames; numbers may be missing between them.

    Raises:
        FileNotFoundError: If nothing is there.
        ValueError: If there is no image, more than one sequence, two files of one frame number, or a frame
            that the pattern asks for is missing.
    """
    path = Path(os.path.expanduser(source))
    if path.is_dir():
        return _only_sequence([file for file in _files(path) if _is_image(file) and not _is_ours(file)], path)
    _check_image_name(path)
    if path.is_file():  # before the patterns: names may hold # and [
        return _only_sequence([path], path)
    if not path.parent.is_dir():
        raise FileNotFoundError(f"{source} does not exist: there is no folder {path.parent}")
    token = _TOKEN.search(path.name)
    if token:
        return _matching_sequence(path, token)
    if not any(sign in path.name for sign in "*?["):
        raise FileNotFoundError(f"{source} does not exist: {_holds(path.parent)}; give {FORMS}")
    return _only_sequence([file for file in _files(path.parent) if fnmatchcase(file.name, path.name)], path)


def numbered_path(pattern: str | Path, number: int) -> Path:
    """Return the file of a number: 7 of ``a.####.png``, ``a.%04d.png`` or ``a.$F4.png`` is ``a.0007.png``.

    A name without a place for the number is returned as it is.

    Raises:
        ValueError: If the name has two such places, or says which frames to use.
    """
    path = Path(pattern)
    token = _TOKEN.search(path.name)
    if not token:
        return path
    before, after = path.name[: token.start()], path.name[token.end() :]
    if token["frames"] or _TOKEN.search(after):
        raise ValueError(f"{path} needs one place for the frame number, such as name.####{path.suffix}")
    digits = int(re.search(r"\d+", token[0])[0]) if re.search(r"\d", token[0]) else len(token[0].strip("$%Fd")) or 1
    if digits > MOST_DIGITS:
        raise ValueError(f"{path} asks for {digits} digits: write at most {MOST_DIGITS}, or name.####{path.suffix}")
    return path.with_name(f"{before}{number:0{digits}d}{after}")


def has_number(pattern: str | Path) -> bool:
    """Return whether a name has a place for the frame number."""
    return bool(_TOKEN.search(Path(pattern).name))


def before_number(pattern: str | Path) -> str:
    """Return what a name has before its number, or before its ending: ``a`` of ``a.####.png``."""
    path = Path(pattern)
    token = _TOKEN.search(path.name)
    return path.name[: token.start() if token else len(path.stem)].rstrip("._-")


def insert_word(pattern: str | Path, word: str) -> Path:
    """Return a name with a word before its number, or before its ending: ``a.left.####.png``."""
    path = Path(pattern)
    token = _TOKEN.search(path.name)
    end = token.start() if token else len(path.stem)
    return path.with_name(f"{path.name[:end].rstrip('._-')}.{word}.{path.name[end:].lstrip('._-')}")


def _parse_chunk(chunk: str, text: str) -> range:
    """Return the frames of one number or range."""
    match = re.fullmatch(r"(-?\d{1,9})(?:-(-?\d{1,9})(?:x(\d{1,9}))?)?", chunk)
    if not match:
        raise ValueError(f"frames {text!r} have no number at {chunk!r}: write 1001-1100, 1001-1100x5 or 1,5,9")
    first, last, step = int(match[1]), int(match[2] or match[1]), int(match[3] or 1)
    if last < first:
        raise ValueError(f"frames {text!r} run backwards at {chunk!r}: write {last}-{first}")
    if step == 0:
        raise ValueError(f"frames {text!r} have a step of 0 at {chunk!r}: write a step of 1 or more")
    return range(first, last + 1, step)


def _files(folder: Path) -> list[Path]:
    """Return the files of a folder but hidden ones, which are system files or not written whole yet."""
    return sorted(file for file in folder.iterdir() if file.is_file() and not file.name.startswith("."))


def _is_image(path: Path) -> bool:
    return path.suffix.lower() in IMAGE_SUFFIXES


def _is_ours(path: Path) -> bool:
    """Return whether a picture beside footage is one that ``inspect`` left there; it has no number."""
    return not _LAST_NUMBER.search(path.stem) and is_of_views(path)


def _check_image_name(path: Path) -> None:
    """Refuse a file or pattern that names no image."""
    if not _is_image(path):
        known = " ".join(IMAGE_SUFFIXES)
        raise ValueError(f"{path} is neither a folder nor an image: the name must end in one of {known}")


def _matching_sequence(path: Path, token: re.Match) -> dict[int, Path]:
    """Return the files that a pattern with a frame number matches."""
    before, after = path.name[: token.start()], path.name[token.end() :]
    if _TOKEN.search(after):
        raise ValueError(f"{path} has two places for a frame number: leave one")
    name = re.compile(rf"{re.escape(before)}(\d+){re.escape(after)}")
    matches = [(int(match[1]), file) for file in _files(path.parent) if (match := name.fullmatch(file.name))]
    if not matches:
        raise FileNotFoundError(f"no file matches {path}: {_holds(path.parent)}")
    found = _by_number(matches)
    if not token["frames"]:
        return found
    wanted = parse_frames(token["frames"])
    missing = format_frames(frame for frame in wanted if frame not in found)
    if missing:
        raise ValueError(f"{path} asks for missing frames: {missing}; there are {format_frames(found)}")
    return {frame: found[frame] for frame in wanted}


def _only_sequence(files: list[Path], source: Path) -> dict[int, Path]:
    """Return the one sequence that the files make up."""
    if not files:
        folder = source if source.is_dir() else source.parent
        raise FileNotFoundError(f"no image found for {source}: {_holds(folder)}; give {FORMS}")
    sequences = _group(files)
    if len(sequences) > 1:
        example = files[0].parent / next(iter(sequences))
        raise ValueError(f"{source} is more than one sequence: {_list(sequences)}; name one, as {example}")
    return _by_number(next(iter(sequences.values())))


def _group(files: Iterable[Path]) -> dict[str, list[tuple[int, Path]]]:
    """Sort files into sequences: names that differ in their last number only."""
    sequences: dict[str, list[tuple[int, Path]]] = {}
    for file in files:
        number = _LAST_NUMBER.search(file.stem)
        pattern, frame = file.name, 1
        if number:
            pattern = file.stem[: number.start()] + "####" + file.stem[number.end() :] + file.suffix.lower()
            frame = int(number[0])
        sequences.setdefault(pattern, []).append((frame, file))
    return sequences


def _by_number(numbered: list[tuple[int, Path]]) -> dict[int, Path]:
    """Return files by number; two files of one number are an error."""
    found: dict[int, Path] = {}
    for frame, file in sorted(numbered):
        if frame in found:
            raise ValueError(f"{found[frame]} and {file.name} are both frame {frame}: remove or rename one")
        found[frame] = file
    return found


def _holds(folder: Path) -> str:
    """Say what a folder holds, in a sentence without its full stop."""
    files = [file for file in _files(folder) if not _is_ours(file)]
    images = [file for file in files if _is_image(file)]
    others = sorted({file.suffix or file.name for file in files if not _is_image(file)})
    parts = ([_list(_group(images))] if images else []) + ([f"other files ({', '.join(others)})"] if others else [])
    rich = [] if images else [f"{inner.name} ({count})" for inner in _folders(folder) if (count := _image_count(inner))]
    inside = f"; in it, {_first(rich)} hold{'s' * (len(rich) == 1)} images: name one of these folders" if rich else ""
    return f"{'this folder' if folder == Path() else folder} holds {' and '.join(parts) or 'no files'}{inside}"


def _folders(folder: Path) -> list[Path]:
    """Return the folders in a folder but hidden ones and those that may not be read."""
    return sorted(
        inner
        for inner in folder.iterdir()
        if inner.is_dir() and not inner.name.startswith(".") and os.access(inner, os.R_OK | os.X_OK)
    )


def _image_count(folder: Path) -> int:
    return sum(map(_is_image, _files(folder)))


def _list(sequences: Mapping[str, list[tuple[int, Path]]]) -> str:
    """Name sequences with their length, the first few of them."""
    return _first([f"{pattern} ({len(files)})" for pattern, files in sequences.items()])


def _first(names: list[str], most: int = 5) -> str:
    """Name the first few, and say how many more there are."""
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")
