"""What a worker process does: it takes tasks out of a pipe until that is closed."""

import os
import pickle
import signal
import sys
import threading
from multiprocessing import connection, parent_process

from warpfluid.cluster.spread import attempt

BROKEN_OFF = 143  # exit code of what SIGTERM ended


def serve(pipe: connection.Connection, job: bytes, device: str, cache: str) -> None:
    """Do tasks.

    Args:
        pipe: Where tasks come from and outcomes go to.
        job: What is done with them, pickled.
        device: Where it computes.
        cache: Folder of compiled kernels.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _break_off)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    import warp as wp

    from warpfluid.device import pick_device

    there = pick_device(device)
    wp.config.kernel_cache_dir = cache
    work = pickle.loads(job)
    try:
        while True:
            task = pipe.recv()
            outcome = attempt(work, task, there, lambda *message: pipe.send(("progress", message)))
            pipe.send(("done", outcome))
    except (EOFError, OSError):  # nobody is left to ask, or to hear it
        signal.signal(signal.SIGTERM, signal.SIG_IGN)  # what is cleared away on the way out is cleared wholly


def _break_off(*_) -> None:
    """End with what is half done removed, and do not let a second signal disturb that."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    sys.exit(BROKEN_OFF)


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(BROKEN_OFF)
