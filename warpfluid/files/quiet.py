"""Keep back what foreign libraries print about damaged files: the one error of ours says it."""

import io
import os
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout

_ONE = threading.Lock()


@contextmanager
def quiet(*, pass_on: bool = True) -> Iterator[None]:
    """Keep back what is printed if the block fails.

    Libraries print below Python, so the streams are exchanged for the whole process; what others print meanwhile is
    passed on when the block ends well.

    Args:
        pass_on: Whether that is so; the library also prints about sound files otherwise.
    """
    with _ONE, tempfile.TemporaryFile() as noise, redirect_stdout(io.StringIO()) as words:
        sys.stderr.flush()
        saved = os.dup(2)
        os.dup2(noise.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(saved, 2)
            os.close(saved)
        if pass_on:
            noise.seek(0)
            os.write(2, noise.read())
    sys.stdout.write(words.getvalue())
