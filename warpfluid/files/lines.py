"""Records, a line of JSON each, that only ever grow: whatever ends a run, what was written before it is there.

Every line ends in a checksum of what stands before it, so that a byte that flipped later is noticed.
"""

import json
import os
import zlib
from pathlib import Path

CHECK = "crc"


def read_lines(path: str | Path) -> list[dict]:
    """Return the records of a file in its order, without lines that are none; nothing where there is no file."""
    path, found = Path(path), []
    for line in path.read_bytes().splitlines() if path.exists() else ():
        try:
            record = json.loads(line)
        except (ValueError, RecursionError):  # the run was stopped while it wrote this line, or it is damaged
            continue
        if isinstance(record, dict) and record.pop(CHECK, None) in (None, checksum(record)):
            found.append(record)
    return found


def line_of(record: dict) -> bytes:
    """Return a record as a line.

    Raises:
        ValueError: If the record holds what JSON lacks.
    """
    return json.dumps(record | {CHECK: checksum(record)}, allow_nan=False).encode() + b"\n"


def append_line(path: str | Path, record: dict) -> None:
    """Add a record on a line of its own, even after half a line.

    Raises:
        OSError: If the file cannot be written.
        ValueError: If the record holds what JSON lacks.
    """
    line = line_of(record)
    with Path(path).open("a+b") as file:
        file.seek(max(file.seek(0, os.SEEK_END) - 1, 0))
        half = file.read(1) not in (b"", b"\n")
        file.write(b"\n" * half + line)
        file.flush()
        os.fsync(file.fileno())


def checksum(record: dict) -> str:
    """Return the checksum of a record, which is the same when it comes back from a file."""
    return f"{zlib.crc32(json.dumps(record).encode()):08x}"
