"""What a worker of a Dask cluster does: it is sent a job once, and then tasks."""

import os
import pickle
import threading
from typing import Any

from warpfluid import __version__
from warpfluid.cluster.spread import attempt

_JOBS: dict[str, "_Held"] = {}


class _Held:
    """A job as it was sent; it is unpacked by the first task, and remembers what it has read."""

    def __init__(self, packed: bytes):
        self.packed, self.job, self.lock = packed, None, threading.Lock()


def look_around(folder: str) -> tuple[str, bool]:
    """Return the version of this package, and whether a folder is seen."""
    return __version__, os.path.isdir(folder)


def take_job(name: str, packed: bytes) -> None:
    """Keep a pickled job under a name."""
    _JOBS[name] = _Held(packed)


def drop_job(name: str) -> None:
    """Forget a job."""
    _JOBS.pop(name, None)


def work(name: str, device: str, task: Any) -> dict | None:
    """Do a task of a job; its progress goes to the topic of the job's name.

    Returns:
        What came of it; None where the job is not there, as in a worker that was started again at the same address.
    """
    from distributed import get_worker

    held = _JOBS.get(name)
    if held is None:
        return None
    worker = get_worker()
    os.environ.setdefault("WARPFLUID_THREADS", str(worker.state.nthreads))
    from warpfluid.device import pick_device

    def tell(*message) -> None:
        worker.log_event(name, list(map(float, message)))

    with held.lock:
        held.job = held.job or pickle.loads(held.packed)
        return attempt(held.job, task, pick_device(device), tell)
