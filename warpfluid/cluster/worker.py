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
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(BROKEN_OFF))  # so that half a file goes
    threading.Thread(target=_end_with_parent, daemon=True).start()
    import warp as wp

    from warpfluid.device import pick_device

    there = pick_device(device)
    wp.config.kernel_cache_dir = cache
    work = pickle.loads(job)
    while True:
        try:
            task = pipe.recv()
        except (EOFError, OSError):
            return
        try:
            outcome = attempt(work, task, there, lambda *message: pipe.send(("progress", message)))
            pipe.send(("done", outcome))
        except OSError:  # nobody is left to hear it
            return


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(BROKEN_OFF)
