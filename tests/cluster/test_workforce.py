"""How many work: cores, memory, tasks and cards each set a limit."""

from types import SimpleNamespace

import pytest

from warpfluid.cluster.workforce import PROCESS_BYTES, make_workforce
from warpfluid.options.machine import parse_jobs

CPU = SimpleNamespace(is_cuda=False)
GB = 1 << 30


class Card(SimpleNamespace):
    """A GPU."""

    def __str__(self):
        return f"cuda:{self.number}"


CARDS = tuple(Card(is_cuda=True, number=k, free_memory=16 * GB) for k in range(3))


@pytest.fixture(autouse=True)
def _cores(monkeypatch):
    monkeypatch.setenv("WARPFLUID_THREADS", "8")


def workers(jobs, devices=(CPU,), *, tasks=100, need=GB, free=1000 * GB):
    return make_workforce(jobs, devices, tasks=tasks, need=need, free=lambda: free)


@pytest.mark.parametrize(("jobs", "threads"), [(1, 8), (2, 4), (3, 2), (5, 1), (8, 1), (None, 1)])
def test_cores_are_shared(jobs, threads):
    """Processes times threads is never more than the cores."""
    made = workers(jobs)
    assert (len(made.devices), made.threads) == (jobs or 8, threads)
    assert not made.notes


def test_more_than_the_cores():
    made = workers(20)
    assert (len(made.devices), made.threads) == (8, 1)
    assert made.notes == ("20 processes are more than the 8 cores: 8 at once",)


def test_memory_sets_a_limit():
    """What a frame needs, and what a process takes by itself."""
    made = workers(6, free=3 * (GB + PROCESS_BYTES) + 1)
    assert (len(made.devices), made.threads) == (3, 2)
    assert made.notes == ("6 frames at once need 1.5 GB each, more than is free: 3 at once",)
    assert len(workers(6, free=0).devices) == 1


def test_no_more_than_there_is_work():
    assert len(workers(4, tasks=2).devices) == 2
    assert workers(4, tasks=2).threads == 4
    assert len(workers(4, tasks=0).devices) == 1
    assert not workers(None, tasks=2).notes


def test_a_process_a_card():
    assert workers(None, CARDS).devices == ("cuda:0", "cuda:1", "cuda:2")
    assert workers(5, CARDS).devices == ("cuda:0", "cuda:1", "cuda:2", "cuda:0", "cuda:1")
    assert len(workers(5, CARDS, need=16 * GB).devices) == 3
    assert len(workers(3, CARDS, free=2 * PROCESS_BYTES).devices) == 2


def test_cards_with_unequal_room():
    """One that another program fills gets no worker, a large one gets several."""
    cards = tuple(
        Card(is_cuda=True, number=k, free_memory=room) for k, room in enumerate((2 * GB, 40 * GB, 9 * GB, 20 * GB))
    )
    assert workers(None, cards, need=8 * GB).devices == ("cuda:1", "cuda:2", "cuda:3")
    assert workers(6, cards, need=8 * GB).devices == ("cuda:1", "cuda:2", "cuda:3", "cuda:1", "cuda:3", "cuda:1")
    few = workers(7, cards, need=12 * GB)
    assert few.devices == ("cuda:1", "cuda:3", "cuda:1", "cuda:1")
    assert few.notes == ("7 frames at once need 13 GB each, more than is free: 4 at once",)
    assert workers(None, cards, need=50 * GB).devices == ("cuda:1",)


@pytest.mark.parametrize("jobs", ["0", "-1", "two", "1.5", "", "9999", "²"])
def test_what_is_no_number(jobs):
    with pytest.raises(ValueError, match="jobs is"):
        parse_jobs(jobs)


def test_numbers():
    assert (parse_jobs("auto"), parse_jobs("4")) == (None, 4)
