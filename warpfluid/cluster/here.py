"""One worker: this process."""

from collections.abc import Callable
from typing import Any

from warpfluid.cluster.spread import Job, attempt


class Here:
    """A pool of this process alone.

    Args:
        job: What is done with a task.
        device: Where it computes.
        progress: Called by the job as it goes.
    """

    def __init__(self, job: Job, device, progress: Callable[..., None]):
        self._job, self._device, self._progress = job, device, progress
        self._tasks: list[Any] = []

    def __enter__(self) -> "Here":
        return self

    def __exit__(self, *_) -> None:
        self._tasks.clear()

    def is_free(self) -> bool:
        """Return whether another task can be handed in."""
        return not self._tasks

    def submit(self, task: Any) -> int:
        """Hand in a task, and return what it is known by."""
        self._tasks.append(task)
        return 0

    def wait(self) -> list[tuple[int, dict]]:
        """Do the task, and return what came of it."""
        outcome = attempt(self._job, self._tasks[0], self._device, self._progress)
        self._tasks.clear()
        return [(0, outcome)]
