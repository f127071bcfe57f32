"""Keep back what foreign libraries print about damaged files: the one error of ours says it."""

import io
import os
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stdout

_ONE = threading.Lock()


@contextmanager
def quiet(*, pass_on: bool = True) -> Iterator[None]:
    """Keep back what is printed if the block fails.

    Libraries print below Python, so the streams are exchanged for the whole process; what others print meanwhile is
    passed on when the block ends well. Where no stream for errors is open, nothing is exchanged.

    Args:
        pass_on: Whether that is so; the library also prints about sound files otherwise.
    """
    with _ONE, ExitStack() as stack:
        saved = _copy_of_stderr()
        words = stack.enter_context(redirect_stdout(io.StringIO()))
        if saved is None:
            yield
        else:
            noise = stack.enter_context(tempfile.TemporaryFile())
            os.dup2(noise.fileno(), 2)
            try:
                yield
            finally:
                os.dup2(saved, 2)
                os.close(saved)
            if pass_on:
                noise.seek(0)
                os.write(2, noise.read())
    if sys.stdout is not None:
        sys.stdout.write(words.getvalue())


def _copy_of_stderr() -> int | None:
    """Return a second number of the stream for errors; None where it is closed: another file may have its number."""
    try:
        if sys.stderr is not None:
            sys.stderr.flush()
            return os.dup(2)
    except (OSError, ValueError):
        pass
    return None
