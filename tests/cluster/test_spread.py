"""Handing out work: order within chains, workers that die, errors that end everything."""

from collections import deque

import pytest
from hypothesis import given
from hypothesis import strategies as st

from warpfluid.cluster.here import Here
from warpfluid.cluster.spread import Lost, attempt, single, spread
from warpfluid.errors import CannotWriteError


class Shuffling:
    """Workers that end in an order of their own, and die when they are told to."""

    def __init__(self, size, choose, dies=lambda task: False):
        self.size, self.choose, self.dies = size, choose, dies
        self.under_way, self.most, self.log = {}, 0, []

    def is_free(self):
        return len(self.under_way) < self.size

    def submit(self, task):
        key = len(self.log)
        self.log.append(task)
        self.under_way[key] = task
        self.most = max(self.most, len(self.under_way))
        return key

    def wait(self):
        key = self.choose(sorted(self.under_way))
        task = self.under_way.pop(key)
        return [(key, Lost("it died") if self.dies(task) else {"made": task})]


def chain(name, length):
    """Yield the tasks of a chain, each only after the one before is done."""
    before = None
    for number in range(length):
        outcome = yield name, number
        assert "error" in outcome or outcome["made"] == (name, number)
        assert before is None or number == before + 1
        before = number


@given(st.lists(st.integers(0, 4), max_size=6), st.integers(1, 4), st.data())
def test_everything_is_done_once_and_in_order(lengths, size, data):
    """Whoever ends when, and whoever dies once or twice."""
    dying = data.draw(st.sets(st.tuples(st.integers(0, 5), st.integers(0, 3))))
    deaths = dict.fromkeys(dying, 2)

    def dies(task):
        deaths[task] = deaths.get(task, 0) - 1
        return deaths[task] >= 0

    pool = Shuffling(size, lambda keys: data.draw(st.sampled_from(keys)), dies)
    ended = list(spread([chain(name, length) for name, length in enumerate(lengths)], pool))
    assert sorted(task for task, _ in ended) == [(n, k) for n, length in enumerate(lengths) for k in range(length)]
    assert all("made" in outcome for _, outcome in ended)
    for name in range(len(lengths)):
        numbers = [task[1] for task, _ in ended if task[0] == name]
        assert numbers == sorted(numbers)
    assert pool.most <= size


def test_a_task_that_kills_its_workers_is_given_up():
    """After three of them; the others are done."""
    pool = Shuffling(2, min, dies=lambda task: task == "poison")
    ended = dict(spread(map(single, ("a", "poison", "b")), pool))
    assert ended["poison"] == {"error": "it died, 3 times"}
    assert pool.log.count("poison") == 3
    assert {task for task, outcome in ended.items() if "made" in outcome} == {"a", "b"}


class Deserted(Shuffling):
    """Workers that are all away at times."""

    def __init__(self, away):
        super().__init__(1, min)
        self.away = away

    def is_free(self):
        return not self.away and super().is_free()

    def wait(self):
        if self.away:
            self.away -= 1
            return []
        (ended,) = super().wait()
        self.away = 2
        return [ended]


def test_nobody_is_there_for_a_while():
    """Work waits for those who come, at the begin and between."""
    ended = list(spread([chain("a", 3), chain("b", 2)], Deserted(away=3)))
    assert [task for task, _ in ended] == [("a", 0), ("a", 1), ("a", 2), ("b", 0), ("b", 1)]


def test_an_error_that_says_stop():
    """Nothing else is begun; what is under way is waited for."""

    def job(task, device, progress):
        if task == 2:
            raise CannotWriteError(28, "no space left on device", "/full")
        if task == 0:
            raise KeyError("luck")
        return {"made": task}

    with Here(job, "cpu", None) as pool:
        ended = list(spread(map(single, range(5)), pool))
    assert [task for task, _ in ended] == [0, 1, 2]
    assert ended[0][1]["error"] == "KeyError: 'luck'"
    assert ended[2][1] == {"error": "/full: no space left on device", "stop": True}


def test_interrupts_are_no_outcome():
    """Ctrl-C goes through."""

    def job(task, device, progress):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        attempt(job, 1, None, None)


def test_chains_are_begun_late():
    """A chain is not asked for its first task before somebody is free for it."""
    begun = deque()

    def watched(name):
        begun.append(name)
        yield name

    ended = spread(map(watched, range(9)), Shuffling(2, min))
    next(ended)
    assert list(begun) == [0, 1]
