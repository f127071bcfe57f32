"""Files that appear whole or not at all."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO


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
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        with open(temporary, "wb") as file:
            yield file
        os.replace(temporary, path)
    except OSError as error:
        raise OSError(error.errno, f"cannot write the file: {error.strerror or error}", str(path)) from error
    finally:
        temporary.unlink(missing_ok=True)
