"""Files that appear whole or not at all."""

import glob
import os
import platform
import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

_LEFT = re.compile(r"\..+\.(\d+)@(.+)\.tmp")  # hidden, with the process and the machine that writes it


@contextmanager
def replacing(path: str | Path) -> Iterator[BinaryIO]:
    """Open a file that takes the place of ``path`` once it is whole.

    It is written under a temporary name in the same folder and then renamed, so that a run that is stopped,
    or a full disk, never leaves half a frame under a good name.

    Args:
        path: The file to write or to replace; its folder must exist.

    Yields:
        The open file, binary.

    Raises:
        OSError: If the file cannot be written; it names ``path``.
    """
    path = Path(path)
    temporary = path.with_name(f".{path.name}.{os.getpid()}@{platform.node()}.tmp")
    try:
        with open(temporary, "wb") as file:
            yield file
        os.replace(temporary, path)
    except OSError as error:
        raise OSError(error.errno, f"cannot write the file: {error.strerror or error}", str(path)) from error
    finally:
        temporary.unlink(missing_ok=True)


def remove_left(folder: str | Path, name: str | None = None) -> None:
    """Remove the temporary files of processes of this machine that were killed while they wrote.

    Args:
        folder: Where they are; those of other machines and of living processes stay.
        name: Of the file that they were to become; any by default.
    """
    for path in Path(folder).glob(f".{glob.escape(name)}.*.tmp" if name else ".*.tmp"):
        found = _LEFT.fullmatch(path.name)
        if found and found[2] == platform.node() and not _lives(int(found[1])):
            with suppress(OSError):  # another one removes it, too, or may alone
                path.unlink(missing_ok=True)


def _lives(process: int) -> bool:
    """Tell whether there may be a process of a number on this machine."""
    if os.name != "posix":  # elsewhere to ask is to end it
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True
    with suppress(OSError):  # one that has ended keeps its number until somebody waits for it
        return not Path(f"/proc/{process}/stat").read_text(errors="replace").rpartition(")")[2].startswith(" Z")
    return True
