"""Files: one format a file; each reader and writer turns the package's arrays into the format's and back."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def written_whole(path: str | Path) -> Iterator[Path]:
    """Give a temporary name to write to, and rename the file when the block ends well.

    Nobody ever sees half a file under ``path``, and an old file stays when writing fails. The temporary name
    begins with a dot, keeps the suffix, and lies in the same folder, which is made when missing.

    Args:
        path: The file to write.

    Yields:
        The temporary path.

    Raises:
        OSError: If the folder cannot be made or the file not be renamed.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
    try:
        yield temporary
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
