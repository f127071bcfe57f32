"""Worker processes: real ones, which are killed, raise, and tell how far they are."""

import os
import signal
import subprocess
import sys
import time

import pytest

from warpfluid.cluster.processes import Processes
from warpfluid.cluster.spread import single, spread
from warpfluid.cluster.workforce import Workforce

TWO = Workforce(devices=("cpu", "cpu"), threads=1)


class Job:
    """Does what the task says."""

    def __call__(self, task, device, progress):
        what, *more = task
        if what == "die" and not os.path.exists(more[0]):
            with open(more[0], "w"):
                os.kill(os.getpid(), signal.SIGKILL)
        if what == "always die":
            os.kill(os.getpid(), signal.SIGKILL)
        if what == "raise":
            raise ValueError("as told")
        if what == "tell":
            progress(more[0], 7)
        if what == "sleep":
            time.sleep(more[0])
        return {"pid": os.getpid(), "threads": os.environ["WARPFLUID_THREADS"], "blas": os.environ["OMP_NUM_THREADS"]}


@pytest.mark.skipif(os.name != "posix", reason="signals of another kind")
def test_workers(tmp_path):
    """Two work; one that dies is replaced and its task done again; one that always dies is given up."""
    told = []
    tasks = [
        ("tell", 3),
        ("die", str(tmp_path / "died")),
        ("raise",),
        ("always die",),
        *[("tell", k) for k in range(4)],
    ]
    before = os.environ.get("WARPFLUID_THREADS")
    with Processes(Job(), TWO, lambda *message: told.append(message)) as pool:
        ended = list(spread(map(single, tasks), pool))
        pids = pool.pids
    outcomes = dict(ended)
    assert len(ended) == len(tasks)
    assert outcomes["raise",]["error"] == "as told"
    assert outcomes["always die",]["error"].startswith("its worker process was killed by signal 9 (out of memory?), 3")
    good = [outcome for task, outcome in ended if task[0] in ("tell", "die")]
    assert {(outcome["threads"], outcome["blas"]) for outcome in good} == {("1", "1")}
    assert os.getpid() not in {outcome["pid"] for outcome in good}
    assert sorted(told) == sorted((task[1], 7) for task in tasks if task[0] == "tell")
    assert os.environ.get("WARPFLUID_THREADS") == before
    assert not any(is_alive(pid) for pid in pids)


PARENT = """
import sys
sys.path.insert(0, {folder!r})
from test_processes import Job, TWO
from warpfluid.cluster.processes import Processes

with Processes(Job(), TWO, None) as pool:
    pool.submit(("sleep", 300))
    pool.submit(("sleep", 300))
    print(*pool.pids, flush=True)
    pool.wait()
"""


@pytest.mark.skipif(os.name != "posix", reason="signals of another kind")
def test_workers_do_not_outlive_their_parent():
    """Not even one that is killed, while they are busy."""
    program = PARENT.format(folder=os.path.dirname(__file__))
    parent = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    pids = [int(pid) for pid in parent.stdout.readline().split()]
    time.sleep(1)
    parent.kill()
    parent.communicate()
    give_up = time.monotonic() + 60
    while any(map(is_alive, pids)):
        assert time.monotonic() < give_up
        time.sleep(0.05)


def is_alive(pid):
    """Return whether there is such a process, and it is no corpse that nobody has buried."""
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False
