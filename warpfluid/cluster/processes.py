"""Workers that are processes of this machine.

Each has a pipe to this process. Whoever dies closes its end, so that this process notices within a moment: the task is
given to another worker and a new one is started. A worker whose parent is gone ends at once, whatever it does.
"""

import contextlib
import os
import pickle
import signal
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from multiprocessing import connection, get_context
from typing import Any

from warpfluid.cluster.spread import Job, Lost
from warpfluid.cluster.worker import serve
from warpfluid.cluster.workforce import Workforce

PATIENCE = 5.0  # s that a worker has to end
BLAS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS", "NUMEXPR_NUM_THREADS")


@dataclass
class _Worker:
    place: int
    process: Any
    pipe: connection.Connection
    busy: bool = False


class Processes:
    """A pool of processes; a context, at whose end they are gone.

    Args:
        job: What is done with a task.
        workforce: How many, where they compute, and with how many threads.
        progress: Called as the jobs go.
    """

    def __init__(self, job: Job, workforce: Workforce, progress: Callable[..., None]):
        self._job, self._workforce, self._progress = pickle.dumps(job), workforce, progress
        self._workers: list[_Worker] = []

    def __enter__(self) -> "Processes":
        try:
            for place in range(len(self._workforce.devices)):
                self._workers.append(self._start(place))
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_) -> None:
        for worker in self._workers:
            worker.pipe.close()
            worker.process.terminate()
        for worker in self._workers:
            worker.process.join(PATIENCE)
            if worker.process.is_alive():
                worker.process.kill()
                worker.process.join()
        self._workers.clear()

    @property
    def pids(self) -> list[int]:
        """Process ids of the workers there are."""
        return [worker.process.pid for worker in self._workers]

    def is_free(self) -> bool:
        """Return whether another task can be handed in."""
        return not all(worker.busy for worker in self._workers)

    def submit(self, task: Any) -> int:
        """Hand in a task, and return what it is known by."""
        worker = next(worker for worker in self._workers if not worker.busy)
        worker.busy = True
        with contextlib.suppress(OSError):  # it is dead: wait finds its pipe closed
            worker.pipe.send(task)
        return worker.place

    def wait(self) -> list[tuple[int, dict | Lost]]:
        """Wait for the next outcomes; what workers tell before is passed on."""
        found = []
        while not found:
            pipes = {worker.pipe: worker for worker in self._workers if worker.busy}
            for pipe in connection.wait(list(pipes)):
                outcome = self._receive(pipes[pipe])
                if outcome is not None:
                    found.append((pipes[pipe].place, outcome))
        return found

    def _receive(self, worker: _Worker) -> dict | Lost | None:
        """Return the outcome of a worker's task, if it is there."""
        try:
            kind, message = worker.pipe.recv()
        except (EOFError, OSError, pickle.UnpicklingError):
            return self._replace(worker)
        if kind == "progress":
            self._progress(*message)
            return None
        worker.busy = False
        return message

    def _replace(self, worker: _Worker) -> Lost:
        """Put a new worker in the place of one that is dead."""
        worker.pipe.close()
        worker.process.join(PATIENCE)
        worker.process.kill()
        code = worker.process.exitcode
        self._workers[worker.place] = self._start(worker.place)
        how = f"was killed by signal {-code}" + " (out of memory?)" * (code == -9) if code and code < 0 else "ended"
        return Lost(f"its worker process {how}")

    def _start(self, place: int) -> _Worker:
        context = get_context("spawn")
        ours, theirs = context.Pipe()
        arguments = (theirs, self._job, self._workforce.devices[place], self._workforce.cache)
        process = context.Process(target=serve, args=arguments, daemon=True, name=f"warpfluid-{place}")
        with _environment(self._workforce.threads), _deaf():
            process.start()
        theirs.close()
        return _Worker(place, process, ours)


@contextlib.contextmanager
def _environment(threads: int) -> Iterator[None]:
    """Let a process that is started now use some threads; its libraries read this when they are loaded."""
    names = {"WARPFLUID_THREADS": str(threads), **dict.fromkeys(BLAS, str(threads))}
    before = {name: os.environ.get(name) for name in names}
    os.environ.update(names)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


@contextlib.contextmanager
def _deaf() -> Iterator[None]:
    """Let a process that is started now ignore Ctrl-C, which goes to all: this one ends the others in good order."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
