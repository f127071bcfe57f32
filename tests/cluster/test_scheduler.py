"""A real Dask scheduler with two workers, all on this machine: same bits, workers and scheduler killed."""

import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from tiny import BARE, numbers, pair, quick, run, volumes

from warpfluid.cluster import farm as farms

pytest.importorskip("distributed")
pytestmark = [
    pytest.mark.skipif(os.name != "posix", reason="signals of another kind"),
    pytest.mark.filterwarnings("default"),  # those of distributed are not ours
]
FRAMES = range(1, 7)
PIECES = ("--piece", "2", "--overlap", "1")
SMALL = ("--device", "cpu", "--resolution", "20x20")


@pytest.fixture
def farm(tmp_path):
    """Address and processes of a scheduler and a nanny with two workers, whose folder is another one."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    address = f"tcp://127.0.0.1:{port}"
    dask = [sys.executable, "-m", "dask"]
    hosts = ["--host", "127.0.0.1"]
    (tmp_path / "elsewhere").mkdir()
    common = {"cwd": tmp_path / "elsewhere", "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    scheduler = subprocess.Popen([*dask, "scheduler", *hosts, "--port", port, "--no-dashboard"], **common)
    worker = ["worker", address, *hosts, "--nworkers", "2", "--nthreads", "1", "--no-dashboard"]
    nanny = subprocess.Popen([*dask, *worker], start_new_session=True, **common)
    yield address, scheduler, nanny
    with contextlib.suppress(ProcessLookupError):
        os.killpg(nanny.pid, signal.SIGKILL)
    scheduler.kill()
    scheduler.wait()
    nanny.wait()


@pytest.fixture
def ready(farm):
    """The farm, once both workers are there."""
    from distributed import Client

    with Client(farm[0], timeout=120, set_as_default=False) as client:
        client.wait_for_workers(2, timeout=120)
    return farm


@pytest.fixture
def flags(tmp_path) -> list[str]:
    return quick(*pair(tmp_path, FRAMES), *BARE, *PIECES)


def when(folder: Path, count: int, do) -> threading.Thread:
    """Do something as soon as some frames are there."""

    def wait():
        give_up = time.monotonic() + 200
        while len(list(folder.glob("density.*.vdb"))) < count and time.monotonic() < give_up:
            time.sleep(0.002)
        do()

    thread = threading.Thread(target=wait)
    thread.start()
    return thread


def kill_a_worker(nanny) -> int | None:
    """Kill one that is alive, and return its process id."""
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, parent = path.read_text().rsplit(")", 1)[1].split()[:2]
            if int(parent) == nanny.pid and state != "Z" and b"spawn_main" in (path.parent / "cmdline").read_bytes():
                os.kill(int(path.parent.name), signal.SIGKILL)
                return int(path.parent.name)
    return None


def test_a_cluster_makes_the_bits_of_one_process(ready, tmp_path, flags, monkeypatch, capsys):
    """From relative names, with a worker killed; when the scheduler goes, the run says so and goes on without it."""
    address, scheduler, nanny = ready
    monkeypatch.chdir(tmp_path)
    flags = quick("--front", "front", "--side", "side", *BARE, *PIECES)
    assert run("reconstruct", *flags, "-o", "one") == 0
    killed = []
    killing = when(tmp_path / "two", 2, lambda: killed.append((kill_a_worker(nanny), len(volumes(tmp_path / "two")))))
    assert run("reconstruct", *flags, "-o", "two", "--cluster", address, "--debug-dir", "seen") == 0
    killing.join()
    assert not list((tmp_path / "elsewhere").glob("*.*"))
    assert len(list((tmp_path / "seen").iterdir())) >= len(FRAMES)
    assert killed[0][0]
    assert killed[0][1] < len(FRAMES)
    assert volumes(tmp_path / "two") == volumes(tmp_path / "one")
    assert sorted(numbers(tmp_path / "two")) == list(FRAMES)
    for name, more in (("a", ()), ("b", ("--cluster", address))):
        assert run("render", "one", "-o", f"{name}.#.png", *SMALL, *more) == 0
    assert all((tmp_path / f"a.{k}.png").read_bytes() == (tmp_path / f"b.{k}.png").read_bytes() for k in FRAMES)
    capsys.readouterr()
    killing = when(tmp_path / "three", 1, scheduler.kill)
    assert run("reconstruct", *flags, "-o", "three", "--cluster", address) == 1
    killing.join()
    message = capsys.readouterr().err
    assert f"the scheduler at {address} is gone: start it again" in message
    assert "--resume tries again" in message
    assert run("reconstruct", "-o", "three", "--resume") == 0
    assert volumes(tmp_path / "three") == volumes(tmp_path / "one")


@pytest.mark.parametrize("lack", ["scheduler", "package"])
def test_where_there_is_no_cluster(flags, tmp_path, monkeypatch, capsys, lack):
    """What was made before is not touched, whatever may be overwritten."""
    monkeypatch.setattr(farms, "PATIENCE", 0.5)
    assert run("reconstruct", *flags, "--frames", "1-2", "-o", tmp_path / "run") == 0
    assert run("render", tmp_path / "run", "-o", tmp_path / "a.#.png", *SMALL) == 0
    before = {path: path.read_bytes() for path in tmp_path.rglob("*.*") if path.is_file()}
    if lack == "package":
        monkeypatch.setitem(sys.modules, "distributed", None)
    nowhere = ("--cluster", "tcp://127.0.0.1:9", "--overwrite")
    said = {
        "scheduler": "no scheduler answers at tcp://127.0.0.1:9: start one with `dask scheduler`",
        "package": "pip install 'warpfluid[cluster]'",
    }[lack]
    capsys.readouterr()
    assert run("reconstruct", *flags, "-o", tmp_path / "run", *nowhere) == 2
    assert said in capsys.readouterr().err
    assert run("render", tmp_path / "run", "-o", tmp_path / "a.#.png", *SMALL, "--angle", "9", *nowhere) == 2
    assert said in capsys.readouterr().err
    assert {path: path.read_bytes() for path in tmp_path.rglob("*.*") if path.is_file()} == before


def test_jobs_and_cluster(flags, tmp_path, capsys):
    assert run("reconstruct", *flags, "-o", tmp_path / "run", "--cluster", "tcp://a:1", "--jobs", "2") == 2
    assert "choose one of them" in capsys.readouterr().err
