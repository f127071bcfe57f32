"""Find the files of a sequence."""

import re
from difflib import SequenceMatcher
from pathlib import Path

from warpfluid.run import SETTINGS

ENDINGS = (".vdb", ".npz", ".nvdb", ".vti")
_NUMBER = re.compile(r"(?:%0?\d*d|#+|\*)")
_LAST = re.compile(r"\d+(?=\D*$)")
MOST_NAMED = 6  # runs beside a path that does not exist


def find_volumes(path: Path) -> dict[int, Path]:
    """Return volumes by frame, which is the last number in a file's name.

    Args:
        path: A folder, a pattern (``smoke.####.vdb``) or a file of volumes.

    Raises:
        ValueError: If there are none, or several of one frame.
    """
    if path.is_dir():
        found = sorted(file for file in path.iterdir() if file.suffix in ENDINGS and not file.name.startswith("."))
    elif path.is_file():
        found = [path]
    else:
        parts = re.split(f"({_NUMBER.pattern})", path.name)
        form = re.compile("".join(".*" if _NUMBER.fullmatch(part) else re.escape(part) for part in parts), re.DOTALL)
        there = sorted(path.parent.iterdir()) if len(parts) > 1 and path.parent.is_dir() else []
        found = [file for file in there if form.fullmatch(file.name) and not file.name.startswith(".")]
    found = [file for file in found if file.suffix in ENDINGS and file.name != "checkpoint.npz"]
    if not found:
        kinds = f"{', '.join(ENDINGS[:-1])} or {ENDINGS[-1]}"
        lacking = "has no volumes" if path.exists() or _NUMBER.search(path.name) else "does not exist"
        way_out = f"name a run, or a folder, pattern or file of {kinds} volumes"
        raise ValueError(f"{path} {lacking}: {way_out}{_runs_beside(path)}")
    names = sorted({_LAST.sub("####", file.stem) + file.suffix for file in found})
    if len(names) > 1:
        raise ValueError(f"{path} has several sequences, {', '.join(names[:4])}: choose one with a pattern")
    numbers = [int(match[0]) if (match := _LAST.search(file.stem)) else 1 for file in found]
    files = dict(sorted(zip(numbers, found, strict=True)))
    if len(files) < len(found):
        raise ValueError(f"{path} has several volumes of one frame: leave one of them")
    return files


def _runs_beside(path: Path) -> str:
    """Return which runs there are in the folder of a path that does not exist, those of like names first."""
    if path.exists():
        return ""
    try:
        there = [folder.name for folder in path.parent.iterdir() if (folder / SETTINGS).is_file()]
    except OSError:
        return ""
    there.sort(key=lambda name: (-SequenceMatcher(None, name, path.name).ratio(), name))
    more = f" and {len(there) - MOST_NAMED} more" if len(there) > MOST_NAMED else ""
    return f"; runs beside it: {', '.join(there[:MOST_NAMED])}{more}" if there else ""
