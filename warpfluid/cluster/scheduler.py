"""Tasks handed to the workers of a Dask cluster, one to each at a time.

A task is bound to the worker that it is meant for, so that none runs where it does not fit. When that worker goes, the
task is lost, and handed to another one. The job itself is sent once to each worker.
"""

import contextlib
import pickle
import queue
import time
import uuid
from collections.abc import Callable, Iterable
from typing import Any

from warpfluid.cluster import farm as farms
from warpfluid.cluster import remote
from warpfluid.cluster.farm import Farm
from warpfluid.cluster.spread import Job, Lost

GONE = 30.0  # s without a scheduler after which it does not come back


class Scheduler:
    """A pool of a cluster's workers; a context.

    Args:
        job: What is done with a task.
        farm: The cluster.
        device: As the command line names it; every worker looks for its own.
        progress: Called as the jobs go.
    """

    def __init__(self, job: Job, farm: Farm, device: str, progress: Callable[..., None]):
        self._job, self._name, self._device = pickle.dumps(job), f"warpfluid-{uuid.uuid4()}", device
        self._farm, self._client, self._progress = farm, farm.client, progress
        self._ended: queue.Queue = queue.Queue()
        self._under_way: dict[str, tuple[Any, str]] = {}  # future and worker by key
        self._idle: list[str] = []
        self._heard = self._seen = self._manned = time.monotonic()  # of news, the scheduler, a worker

    def __enter__(self) -> "Scheduler":
        self._client.subscribe_topic(self._name, lambda event: self._hear(event[1]))
        self._employ(self._farm.workers)
        return self

    def __exit__(self, *_) -> None:
        if not self._farm.is_connected:
            return
        with contextlib.suppress(OSError, TimeoutError):
            self._client.cancel([future for future, _ in self._under_way.values()], force=True)
            self._client.unsubscribe_topic(self._name)
            self._farm.run(remote.drop_job, self._name, workers=self._farm.workers)

    def is_free(self) -> bool:
        """Return whether another task can be handed in."""
        return bool(self._idle)

    def submit(self, task: Any) -> str:
        """Hand in a task, and return what it is known by."""
        worker = self._idle.pop()  # the one that was busy last has what the next task builds on
        bound = {"workers": [worker], "allow_other_workers": False, "pure": False}
        future = self._client.submit(remote.work, self._name, self._device, task, **bound)
        self._under_way[future.key] = future, worker
        future.add_done_callback(self._ended.put)
        return future.key

    def wait(self) -> list[tuple[str, dict | Lost]]:
        """Wait for the next outcomes, or for a worker that is free; for the latter there is none.

        Raises:
            ConnectionError: If the scheduler is gone, or there is no worker for long.
        """
        while True:
            ended, came = self._next(), []
            if time.monotonic() - self._heard >= farms.NEWS:  # however fast tasks end
                self._heard = time.monotonic()
                came, gone = self._farm.news()
                ended += self._dismiss(gone)
                self._employ(came)
            self._note_presence()
            if ended or came:
                return ended
            self._check_presence()

    def _next(self) -> list[tuple[str, dict | Lost]]:
        """Return the next outcome, or none if nothing ends for a while."""
        try:
            future = self._ended.get(timeout=farms.NEWS)
        except queue.Empty:
            return []
        return [(future.key, self._conclude(future))] if future.key in self._under_way else []

    def _hear(self, message: list[float]) -> None:
        """Pass on how far a job is; messages travel as plain numbers."""
        frame, iteration, energy = message
        self._progress(int(frame), int(iteration), energy)

    def _employ(self, workers: Iterable[str]) -> None:
        """Send the job to workers, which are free then."""
        for worker, error in self._farm.run(remote.take_job, self._name, self._job, workers=workers).items():
            if error is None:
                self._idle.append(worker)
            else:
                self._farm.forget(worker)

    def _dismiss(self, workers: Iterable[str]) -> list[tuple[str, Lost]]:
        """Take workers that are gone off the list; return their tasks as lost."""
        workers = set(workers)
        self._idle = [worker for worker in self._idle if worker not in workers]
        lost = [key for key, (_, worker) in self._under_way.items() if worker in workers]
        for key in lost:
            self._under_way.pop(key)[0].release()
        return [(key, Lost("its worker went away or was killed (out of memory?)")) for key in lost]

    def _note_presence(self) -> None:
        """Note who is there now."""
        now = time.monotonic()
        self._seen = now if self._farm.is_connected else self._seen
        self._manned = now if self._farm.workers else self._manned

    def _check_presence(self) -> None:
        """Raise where waiting makes no sense any more."""
        now = time.monotonic()
        if now - self._seen > GONE or self._client.status == "closed":
            raise ConnectionError(self._gone())
        if now - self._manned > farms.ALONE:
            raise ConnectionError(f"{self._farm.why_alone()}, and none came in {farms.ALONE:.0f} s")

    def _conclude(self, future) -> dict | Lost:
        """Return what came of a task that has ended; its worker is free."""
        from distributed import KilledWorker

        _, worker = self._under_way.pop(future.key)
        if future.status in ("cancelled", "lost"):
            raise ConnectionError(self._gone())
        if future.status == "error":
            self._idle.append(worker)
            error = future.exception()
            killed = isinstance(error, KilledWorker)
            reason = "its workers were killed (out of memory?)" if killed else f"{type(error).__name__}: {error}"
            return {"error": reason}
        try:
            outcome = future.result(timeout=GONE)
        except TimeoutError:  # who made it is gone, before it was fetched
            outcome = None
        except OSError as error:  # the scheduler went while it was fetched
            raise ConnectionError(self._gone()) from error
        if outcome is None:
            self._farm.forget(worker)
            return Lost("its worker was started again")
        self._idle.append(worker)
        return outcome

    def _gone(self) -> str:
        return f"the scheduler at {self._farm.address} is gone: start it again"
