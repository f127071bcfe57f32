"""Folders that files go into: whether they can, told before any work."""

import os
from pathlib import Path


def check_writable(folder: str | Path) -> None:
    """Refuse a folder that nothing can be written into, whether it is there or would have to be made.

    Args:
        folder: Its path.

    Raises:
        ValueError: If it, or the nearest folder above that is there, is protected.
    """
    folder = Path(folder).absolute()
    nearest = next(path for path in (folder, *folder.parents) if path.exists())
    if nearest.is_dir() and not os.access(nearest, os.W_OK | os.X_OK):
        raise ValueError(f"{nearest} is write-protected: choose another folder with -o")
