"""A Dask cluster that is there already, and its workers, as they come and go.

Whoever may use the scheduler may run any program on its workers, and the other way round: a cluster is for people who
trust each other. Workers need this package, and the folders of footage and results under the same names.
"""

import logging
import time
from collections import Counter
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from warpfluid import __version__
from warpfluid.cluster import remote

PATIENCE = 10.0  # s that a scheduler has to answer
ALONE = 300.0  # s without a worker after which none is waited for; queues of machines are slow
NEWS = 2.0  # s between two looks at who is there


class Farm:
    """A connection to a scheduler, and the workers that can be used; a context.

    Args:
        address: Of the scheduler, such as ``tcp://host:8786``.
        folder: Where results will go; every worker must see it, or what is there of its path.
        need: Memory of a worker with a task [byte]; those with less get none.
        say: Called with what the user should know.

    Raises:
        ValueError: If there is no such cluster, or none of its workers can be used.
    """

    def __init__(self, address: str, *, folder: Path, need: int, say: Callable[[str], None]):
        self.address, self._need, self._say = address, need, say
        self._folder = next(str(path) for path in (folder, *folder.absolute().parents) if path.is_dir())
        self.workers: list[str] = []
        self._refused: dict[str, str] = {}
        self.client = _connect(address)
        try:
            self._await_workers()
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> "Farm":
        return self

    def __exit__(self, *_) -> None:
        self.close()

    def close(self) -> None:
        """End the connection."""
        self.client.close(timeout=PATIENCE)

    @property
    def is_connected(self) -> bool:
        """Whether the scheduler is there."""
        return self.client.status == "running"

    def news(self) -> tuple[list[str], list[str]]:
        """Ask the scheduler who is there; return the workers that came and can be used, and those that are gone."""
        if not self.is_connected:
            return [], []
        try:
            there = self.client.scheduler_info(n_workers=-1)["workers"]
        except OSError:  # it goes at this moment
            return [], []
        gone = [worker for worker in self.workers if worker not in there]
        looked_at = {*self.workers, *self._refused}
        new = {w: about for w, about in there.items() if w not in looked_at and about["status"] == "running"}
        found = self._look_at(new)
        came = [worker for worker, reason in found.items() if not reason]
        refused = {worker: reason for worker, reason in found.items() if reason}
        self.workers = [worker for worker in self.workers if worker not in gone] + came
        self._refused = {w: reason for w, reason in self._refused.items() if w in there} | refused
        if came or gone:
            self._say(f"workers {len(self.workers)} of the cluster at {self.address}")
        if refused and self.workers:
            self._say(f"note    {_sum_up(refused)}")
        return came, gone

    def why_alone(self) -> str:
        """Return why there is no worker, and what to do."""
        if self._refused:
            return f"no worker of {self.address} can be used: {_sum_up(self._refused)}"
        return f"{self.address} has no workers: {_start(self.address)}"

    def forget(self, worker: str) -> None:
        """Look at a worker again, as at one that came."""
        self.workers.remove(worker)

    def run(self, function: Callable, *arguments: Any, workers: Iterable[str]) -> dict[str, Any]:
        """Call a function in workers; return what it returned, or the error, by worker."""
        workers = list(workers)
        if not workers:
            return {}
        try:
            return self.client.run(function, *arguments, workers=workers, on_error="return")
        except OSError as error:  # the scheduler is gone
            return dict.fromkeys(workers, error)

    def _look_at(self, new: dict[str, dict]) -> dict[str, str]:
        """Return why each of some workers cannot be used, or nothing; those that are gone already are left out."""
        found = self.run(remote.look_around, self._folder, workers=new)
        return {
            worker: self._judge(answer, new[worker]["memory_limit"])
            for worker, answer in found.items()
            if not isinstance(answer, OSError)
        }

    def _judge(self, answer: Any, memory: int) -> str:
        """Return why a worker cannot be used, or nothing."""
        if isinstance(answer, Exception):
            return f"a package is missing or fails there ({answer}), install warpfluid"
        version, sees = answer
        if version != __version__:
            return f"warpfluid is {version} there and {__version__} here, install the same"
        if not sees:
            return f"{self._folder} is not seen from there, results must go into a folder that all share"
        if 0 < memory < self._need:
            return f"it may take {memory / 1e9:.2g} GB of memory, and a frame needs {self._need / 1e9:.2g} GB"
        return ""

    def _await_workers(self) -> None:
        """Wait until a worker can be used."""
        give_up, told = time.monotonic() + ALONE, False
        while True:
            self.news()
            if self.workers:
                return
            if self._refused or time.monotonic() > give_up or not self.is_connected:
                raise ValueError(self.why_alone())
            if not told:
                self._say(f"note    {self.why_alone()}; waiting {ALONE:.0f} s for them")
                told = True
            time.sleep(NEWS)


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
            f"no scheduler answers at {address}: start one with `dask scheduler`, and {_start(address)}"
        ) from error


def _start(address: str) -> str:
    return f"start workers with `dask worker {address} --nthreads 1`"


def _sum_up(refused: dict[str, str]) -> str:
    """Return how many workers are left out, and why."""
    return "; ".join(
        f"{count} worker{'s are' if count > 1 else ' is'} left out, {reason}"
        for reason, count in Counter(refused.values()).items()
    )
