"""Errors in words: what was found, without numbers of the system or names of foreign libraries."""

import errno
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

MOST_LINES = 20  # of one error; a thousand damaged frames need no thousand lines


class CannotWriteError(OSError):
    """What is made cannot be written: the disk is full, the folder is gone or protected."""


@contextmanager
def writing(path: str | Path) -> Iterator[None]:
    """Tell errors of a file that is written from those of files that are read.

    Raises:
        CannotWriteError: In place of any OSError; it names the file.
    """
    try:
        yield
    except OSError as error:
        reason = (error.strerror or str(error)).removeprefix("cannot write the file: ")
        reason = f"cannot write the file: {reason[:1].lower()}{reason[1:]}"
        raise CannotWriteError(error.errno, reason, str(error.filename or path)) from error


class Problems(list):
    """Everything that is wrong with an input, so that one error can tell all of it."""

    def attempt(self, function, *arguments, where: str = ""):
        """Return what the function returns; on a ValueError or OSError note it, and return None."""
        try:
            return function(*arguments)
        except (ValueError, OSError) as error:
            self.extend(f"{where}{line}" for line in describe(error).splitlines())
            return None

    def raise_if_any(self) -> None:
        """Raise one ValueError with a line for each problem."""
        lines = list(dict.fromkeys(self))
        if len(lines) > MOST_LINES:
            lines = [*lines[: MOST_LINES - 1], f"and {len(lines) - MOST_LINES + 1} more like these"]
        if lines:
            raise ValueError("\n".join(lines))


def changed_since(folder: str | Path, changed: Iterable[str]) -> str:
    """Return the refusal to continue a run with something else."""
    return (
        f"{folder} was made with something else: {', '.join(changed)}; "
        "use the same again, or --overwrite, or another folder with -o"
    )


def describe(error: BaseException) -> str:
    """Return an error as a sentence that an artist can act on."""
    if isinstance(error, OSError) and error.strerror:
        missing = error.strerror == os.strerror(errno.ENOENT)
        reason = error.strerror[0].lower() + error.strerror[1:]
        if error.filename is None:
            return reason
        return f"{error.filename} does not exist: check its name" if missing else f"{error.filename}: {reason}"
    if isinstance(error, MemoryError):
        return "there is not enough memory: reduce the footage with --resolution"
    if isinstance(error, ValueError | OSError) and str(error):
        return str(error)
    return f"{type(error).__name__}: {error}".removesuffix(": ")
