"""Workers of a real cluster that come and go, and those that are of no use."""

import contextlib
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
from chores import Chores

from warpfluid.cluster import farm as farms
from warpfluid.cluster import remote
from warpfluid.cluster.pools import Asked, reach
from warpfluid.cluster.scheduler import Scheduler
from warpfluid.cluster.spread import Lost, single, spread
from warpfluid.cluster.workforce import PROCESS_BYTES

pytest.importorskip("distributed")
pytestmark = [
    pytest.mark.skipif(os.name != "posix", reason="signals of another kind"),
    pytest.mark.filterwarnings("default"),  # those of distributed are not ours
]
MEGABYTE = 1 << 20


class Cluster:
    """A scheduler, and workers that are started when they are wanted."""

    def __init__(self, folder):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = str(free.getsockname()[1])
        self.address, self.folder, self.started = f"tcp://127.0.0.1:{port}", folder, []
        self.start("scheduler", "--port", port)

    def start(self, *words):
        command = [sys.executable, "-m", "dask", *words, "--host", "127.0.0.1", "--no-dashboard"]
        environment = os.environ | {"PYTHONPATH": os.pathsep.join([os.path.dirname(__file__), *sys.path])}
        silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        process = subprocess.Popen(command, cwd=self.folder, env=environment, start_new_session=True, **silent)
        self.started.append(process)
        return process

    def add(self, *words):
        return self.start("worker", self.address, "--nthreads", "1", *words)

    def end(self):
        for process in reversed(self.started):
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


@pytest.fixture
def cluster(tmp_path, monkeypatch):
    monkeypatch.setattr(farms, "NEWS", 0.2)
    made = Cluster(tmp_path)
    yield made
    made.end()


def connect(cluster, said, need=1):
    """Return the farm, once its scheduler listens and a worker is there."""
    give_up = time.monotonic() + 60
    while time.monotonic() < give_up:
        try:
            return farms.Farm(cluster.address, folder=cluster.folder, need=need, say=said.append)
        except ValueError as error:
            if "no scheduler answers" not in str(error):
                raise
    raise TimeoutError


def test_workers_come_and_go(cluster, tmp_path, monkeypatch):
    """They are waited for, get work when they come late, leave it to others when they go; in the end nobody is left."""
    said = []
    alone = cluster.add("--no-nanny", "--memory-limit", str(900 * MEGABYTE))
    with connect(cluster, said, need=500 * MEGABYTE) as farm:
        assert any("has no workers yet" in line for line in said) or farm.workers
        others = cluster.add("--nworkers", "2"), cluster.add("--no-nanny", "--memory-limit", str(100 * MEGABYTE))
        pids = []

        def until_others_help():
            while len(set(pids)) < 3 or not any("left out" in line for line in said):
                assert len(pids) < 600
                outcome = yield "sleep", 0.1
                pids.append(outcome["pid"])

        with Scheduler(Chores(tmp_path), farm, "cpu", print) as pool:
            assert len({name for name, _ in spread((until_others_help() for _ in range(5)), pool)}) == 1
            assert len(pool._farm.workers) == 3
            for process in (alone, *others):
                os.killpg(process.pid, signal.SIGKILL)
            monkeypatch.setattr(farms, "ALONE", 1.0)
            with pytest.raises(ConnectionError, match="none came in 1 s"):
                list(spread([single(("sleep", 0.1))], pool))
    assert "1 worker is left out, it may take 0.1 GB of memory, and a frame needs 0.52 GB" in "\n".join(said)
    assert {int(path.stem) for path in tmp_path.glob("*.got")} == set(pids)  # each got the job once
    assert others[1].pid not in pids


def test_a_task_that_kills_its_workers(cluster, tmp_path):
    """Three of them; nannies start others, and what else there is gets done."""
    cluster.add("--nworkers", "2")
    with connect(cluster, []) as farm, Scheduler(Chores(tmp_path), farm, "cpu", print) as pool:
        tasks = [("die",), *[("sleep", 0.01 * k) for k in range(6)]]
        ended = dict(spread(map(single, tasks), pool))
    assert ended.pop(("die",))["error"].endswith("killed (out of memory?), 3 times")
    assert all("pid" in outcome for outcome in ended.values())
    assert len(ended) == 6
    assert (tmp_path / "did").read_text().count("die") == 3


def test_no_worker_is_of_use(cluster, tmp_path):
    cluster.add("--no-nanny")
    with pytest.raises(ValueError, match=r"no worker of .* can be used: 1 worker is left out, .* GB of memory"):
        connect(cluster, [], need=10**15)


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (("9.9", True), "warpfluid is 9.9 there"),
        ((farms.__version__, False), "is not seen from there"),
        (ModuleNotFoundError("No module named 'warpfluid'"), "a package is missing"),
        ((farms.__version__, True), ""),
    ],
)
def test_why_a_worker_is_left_out(answer, words):
    farm = SimpleNamespace(_folder="/shared", _need=10)
    assert words in farms.Farm._judge(farm, answer, 0)
    assert bool(words) == bool(farms.Farm._judge(farm, answer, 0))


def test_workers_that_dask_gives_up(tmp_path):
    """Where Dask itself has tried often enough, the task is not tried again."""
    from distributed import KilledWorker

    error = KilledWorker("a", None, 0)
    pool = Scheduler(print, SimpleNamespace(client=None), "cpu", print)
    future = SimpleNamespace(key="a", status="error", exception=lambda: error)
    pool._under_way["a"] = future, "tcp://b"
    outcome = pool._conclude(future)
    assert not isinstance(outcome, Lost)
    assert outcome == {"error": "its workers were killed (out of memory?)"}
    assert pool.is_free()


def test_a_worker_that_was_started_again():
    """At the same address, so that nobody saw it go: it has no job. It is looked at as one that came."""
    forgotten = []
    pool = Scheduler(print, SimpleNamespace(client=None, forget=forgotten.append), "cpu", print)
    future = SimpleNamespace(key="a", status="finished", result=lambda timeout: remote.work("gone", "cpu", 1))
    pool._under_way["a"] = future, "tcp://b"
    assert isinstance(pool._conclude(future), Lost)
    assert forgotten == ["tcp://b"]
    assert not pool.is_free()


@pytest.mark.parametrize(("device", "need"), [("auto", 7), ("cpu", 7), ("cuda:1", 0)])
def test_the_memory_that_workers_must_have(monkeypatch, device, need):
    """That of a process, and of a frame, unless that is on a GPU."""
    asked, wanted = Asked(device=device, cluster="tcp://a:1"), []
    monkeypatch.setattr(farms, "_connect", lambda address: SimpleNamespace(close=lambda timeout: None))
    monkeypatch.setattr(farms.Farm, "_await_workers", lambda farm: wanted.append(farm._need))
    with reach(asked, need=7, folder=Path("/"), say=print) as crew:
        assert crew.farm
    assert wanted == [PROCESS_BYTES + need]


def test_the_folder_that_workers_must_see(tmp_path, monkeypatch):
    """Of one that is to be made, what is there of its path."""
    monkeypatch.setattr(farms, "_connect", lambda address: None)
    monkeypatch.setattr(farms.Farm, "_await_workers", lambda farm: None)
    farm = farms.Farm("tcp://a:1", folder=tmp_path / "new" / "run", need=1, say=print)
    assert Path(farm._folder) == tmp_path


def test_a_scheduler_that_goes_while_a_result_is_fetched():
    """It is named, as when it goes at any other moment."""

    def cut(timeout):
        raise ConnectionResetError("reset by peer")

    pool = Scheduler(print, SimpleNamespace(client=None, address="tcp://a:1"), "cpu", print)
    future = SimpleNamespace(key="a", status="finished", result=cut)
    pool._under_way["a"] = future, "tcp://b"
    with pytest.raises(ConnectionError, match="the scheduler at tcp://a:1 is gone"):
        pool._conclude(future)
