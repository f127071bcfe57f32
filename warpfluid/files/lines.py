"""Records, a line of JSON each, that only ever grow: whatever ends a run, what was written before it is there."""

import json
import os
from pathlib import Path


def read_lines(path: str | Path) -> list[dict]:
    """Return the records of a file in its order, without lines that are none; nothing where there is no file."""
    path, found = Path(path), []
    for line in path.read_bytes().splitlines() if path.exists() else ():
        try:
            record = json.loads(line)
        except ValueError:  # the run was stopped while it wrote this line
            continue
        found += [record] if isinstance(record, dict) else []
    return found


def append_line(path: str | Path, record: dict) -> None:
    """Add a record on a line of its own, even after half a line.

    Raises:
        OSError: If the file cannot be written.
        ValueError: If the record holds what JSON lacks.
    """
    line = json.dumps(record, allow_nan=False).encode()
    with Path(path).open("a+b") as file:
        file.seek(max(file.seek(0, os.SEEK_END) - 1, 0))
        half = file.read(1) not in (b"", b"\n")
        file.write(b"\n" * half + line + b"\n")
        file.flush()
        os.fsync(file.fileno())
