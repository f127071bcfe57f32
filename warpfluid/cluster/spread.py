"""Work handed out to whoever is free, whatever breaks.

A chain is a generator of tasks: it yields one, is sent what came of it, and yields the next. So tasks that build on
each other keep their order, and chains run side by side. What a task makes does not depend on who does it or when.
"""

import traceback
from collections import deque
from collections.abc import Callable, Generator, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from warpfluid.errors import CannotWriteError, describe

TRIES = 3  # a task whose worker dies that often would take all of them along, one after the other

Chain = Generator[Any, dict, None]
Job = Callable[..., dict]  # job(task, device, progress); it can be sent to another process


@dataclass(frozen=True)
class Lost:
    """What comes of a task whose worker is gone.

    Attributes:
        reason: What is known of its end.
    """

    reason: str


class Pool(Protocol):
    """Workers of one kind; a context."""

    def is_free(self) -> bool:
        """Return whether another task can be handed in."""

    def submit(self, task: Any) -> Hashable:
        """Hand in a task, and return what it is known by."""

    def wait(self) -> Sequence[tuple[Hashable, dict | Lost]]:
        """Wait, and return what came of tasks; nothing where somebody has become free."""


def single(task: Any) -> Chain:
    """Return a chain of one task, which nobody waits for."""
    yield task


def spread(chains: Iterable[Chain], pool: Pool) -> Iterator[tuple[Any, dict]]:
    """Do all tasks of some chains.

    A task whose worker dies is done again. An outcome with the key ``stop`` ends the work: what is under way is
    waited for, and nothing else is begun.

    Args:
        chains: Their tasks; the first chains come first.
        pool: Who works.

    Yields:
        Every task with its outcome, which has the key ``error`` where it failed, in the order in which they end.
    """
    waiting, ready, under_way = deque(chains), deque(), {}
    stopped = False
    while True:
        while not stopped and pool.is_free() and (ready or waiting):
            chain, task, tries = ready.popleft() if ready else (waiting.popleft(), None, 0)
            task = next(chain, None) if task is None else task
            if task is not None:
                under_way[pool.submit(task)] = chain, task, tries + 1
        if not under_way and (stopped or not (ready or waiting)):
            return
        for key, outcome in pool.wait():
            chain, task, tries = under_way.pop(key)
            if isinstance(outcome, Lost):
                if tries < TRIES and not stopped:
                    ready.append((chain, task, tries))
                    continue
                outcome = {"error": f"{outcome.reason}, {tries} times"}
            stopped = stopped or bool(outcome.get("stop"))
            yield task, outcome
            following = None if stopped else _follow(chain, outcome)
            if following is not None:
                ready.appendleft((chain, following, 0))  # first: the worker that is free has what it builds on


def attempt(job: Job, task: Any, device, progress: Callable[..., None]) -> dict:
    """Return the outcome of a task; an error is one, too, and one that no other task escapes says stop."""
    try:
        return job(task, device, progress)
    except CannotWriteError as error:
        return {"error": describe(error), "stop": True}
    except Exception as error:  # one task must not end the others, whichever library gave up
        return {"error": describe(error), "stack": traceback.format_exc()}


def _follow(chain: Chain, outcome: dict):
    """Return the task of a chain that follows an outcome; None at its end."""
    try:
        return chain.send(outcome)
    except StopIteration:
        return None
