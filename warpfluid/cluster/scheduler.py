"""Workers of a Dask cluster that is there already.

Whoever may use the scheduler may run any program on its workers, and the other way round: a cluster is for people who
trust each other. Workers need this package, and the folders of footage and results under the same names.
"""

import logging
import os
import pickle
import queue
import threading
import uuid
from collections.abc import Callable
from pathlib import Path
from typing import Any

from warpfluid import __version__
from warpfluid.cluster.spread import Job, Lost, attempt

PATIENCE = 10.0  # s that a scheduler has to answer
GONE = 30.0  # s without a scheduler after which it does not come back
_THREAD = threading.local()


class Scheduler:
    """A pool of a cluster's workers; a context.

    Args:
        job: What is done with a task.
        address: Of the scheduler, such as ``tcp://host:8786``.
        device: As the command line names it; every worker looks for its own.
        folder: Where results go; every worker must see it.
        need: Memory of a task [byte]; workers with less are left out.
        progress: Called as the jobs go.
        say: Called with what the user should know.

    Raises:
        ValueError: If there is no such cluster, or it cannot be used.
    """

    def __init__(
        self,
        job: Job,
        address: str,
        *,
        device: str,
        folder: Path,
        need: int,
        progress: Callable[..., None],
        say: Callable[[str], None],
    ):
        self._work = pickle.dumps(job), device, f"warpfluid-{uuid.uuid4()}"
        self._address, self._progress = address, progress
        self._ended: queue.Queue = queue.Queue()
        self._futures: dict[str, Any] = {}
        self._client = _connect(address)
        try:
            self._workers = _usable(self._client, address, folder, need, say)
        except BaseException:
            self._client.close()
            raise

    def __enter__(self) -> "Scheduler":
        self._client.subscribe_topic(self._work[2], lambda event: self._hear(event[1]))
        return self

    def __exit__(self, *_) -> None:
        if self._client.status == "running":
            self._client.cancel(list(self._futures.values()), force=True)
        self._client.close(timeout=PATIENCE)

    def is_free(self) -> bool:
        """Return whether another task can be handed in."""
        return len(self._futures) < len(self._workers)

    def submit(self, task: Any) -> str:
        """Hand in a task, and return what it is known by."""
        future = self._client.submit(_work, *self._work, task, pure=False)
        self._futures[future.key] = future
        future.add_done_callback(self._ended.put)
        return future.key

    def wait(self) -> list[tuple[str, dict | Lost]]:
        """Wait for the next outcome.

        Raises:
            ConnectionError: If the scheduler is gone.
        """
        lonely = 0.0
        while True:
            try:
                future = self._ended.get(timeout=1.0)
            except queue.Empty:
                lonely = 0.0 if self._client.status == "running" else lonely + 1.0
                if lonely < GONE and self._client.status != "closed":
                    continue
                future = None
            if future is None or future.status in ("cancelled", "lost"):
                raise ConnectionError(f"the scheduler at {self._address} is gone: start it again")
            self._futures.pop(future.key)
            return [(future.key, _outcome(future))]

    def _hear(self, message: list[float]) -> None:
        """Pass on how far a job is; messages travel as plain numbers."""
        frame, iteration, energy = message
        self._progress(int(frame), int(iteration), energy)


def _connect(address: str):
    try:
        from distributed import Client
    except ImportError as error:
        raise ValueError("--cluster needs dask.distributed: pip install 'warpfluid[cluster]'") from error
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # what matters is said as an error
    try:
        return Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ValueError(
            f"no scheduler answers at {address}: start one with `dask scheduler`, "
            f"and workers with `dask worker {address} --nthreads 1`"
        ) from error


def _usable(client, address: str, folder: Path, need: int, say: Callable[[str], None]) -> list[str]:
    """Return the workers that can do the work."""
    workers = client.scheduler_info(n_workers=-1)["workers"]
    if not workers:
        raise ValueError(f"{address} has no workers: start some with `dask worker {address} --nthreads 1`")
    try:
        found = client.run(_look_around, str(folder))
    except ImportError as error:
        raise ValueError(f"a worker of {address} lacks a package: {error}; install warpfluid there") from error
    for worker, (version, sees) in found.items():
        if version != __version__:
            raise ValueError(f"worker {worker} has warpfluid {version}, this is {__version__}: install the same")
        if not sees:
            raise ValueError(f"worker {worker} does not see {folder}: results must go into a folder that all share")
    small = [worker for worker, about in workers.items() if 0 < about["memory_limit"] < need]
    if len(small) == len(workers):
        raise ValueError(f"a frame needs {need / 1e9:.2g} GB, more than any worker of {address} may take")
    if small:
        say(f"note    {len(small)} workers have less memory than a frame needs, {need / 1e9:.2g} GB, and may fail")
    say(f"workers {len(workers) - len(small)} of the cluster at {address}")
    return [worker for worker in workers if worker not in small]


def _look_around(folder: str) -> tuple[str, bool]:
    """Return what a worker has and sees."""
    return __version__, os.path.isdir(folder)


def _work(job: bytes, device: str, topic: str, task: Any) -> dict:
    """Do a task on a worker; each thread keeps a job, which remembers what it has read."""
    from distributed import get_worker

    worker = get_worker()
    os.environ.setdefault("WARPFLUID_THREADS", str(worker.state.nthreads))
    from warpfluid.device import pick_device

    if getattr(_THREAD, "topic", None) != topic:
        _THREAD.topic, _THREAD.job = topic, pickle.loads(job)
    return attempt(
        _THREAD.job, task, pick_device(device), lambda *message: worker.log_event(topic, list(map(float, message)))
    )


def _outcome(future) -> dict | Lost:
    """Return what came of a task that has ended."""
    from distributed import KilledWorker

    if future.status == "finished":
        return future.result()
    error = future.exception()
    if isinstance(error, KilledWorker):
        return Lost("its workers were killed (out of memory?)")
    return {"error": f"{type(error).__name__}: {error}"}
