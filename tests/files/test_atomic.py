"""Files that are written whole, and what is left of those whose writer was killed."""

import os
import platform
import subprocess
import sys

import pytest
from tiny import run

from warpfluid.files.atomic import remove_left, replacing

KILLED = """
import os, signal, sys
from warpfluid.files.atomic import replacing
with replacing(sys.argv[1]) as file:
    file.write(b"half")
    file.flush()
    os.kill(os.getpid(), signal.SIGKILL)
"""

pytestmark = pytest.mark.skipif(os.name != "posix", reason="processes cannot be asked for elsewhere")


@pytest.fixture
def left(tmp_path):
    """A file of a process that was killed in the middle of it."""
    subprocess.run([sys.executable, "-c", KILLED, tmp_path / "first.mp4"], check=False)
    (file,) = tmp_path.glob(".first.mp4.*.tmp")
    return file


def test_what_the_dead_left_goes(left):
    remove_left(left.parent)
    assert not left.exists()


def test_what_others_write_stays(left):
    """A living process, another machine, and files that are not ours."""
    node, (dead, _) = platform.node(), left.name.removeprefix(".first.mp4.").split("@")
    names = [f".a.png.{os.getppid()}@{node}.tmp", f".a.png.{dead}@{node}-2.tmp", f".a.png.{dead}.tmp", ".mine.tmp"]
    for name in names:
        (left.parent / name).touch()
    with replacing(left.parent / "b.png") as file:
        remove_left(left.parent)
        file.write(b"whole")
    assert sorted(path.name for path in left.parent.iterdir()) == sorted([*names, "b.png"])


def test_a_later_render_removes_it(left, volume_file):
    assert run("render", volume_file, "-o", left.parent / "first.png", "--resolution", "8x8", "--device", "cpu") == 0
    assert sorted(path.name for path in left.parent.iterdir()) == ["first.png"]


@pytest.fixture
def volume_file(tmp_path_factory):
    """A volume elsewhere."""
    import numpy as np

    from warpfluid.files.npz import write_npz

    path = tmp_path_factory.mktemp("volumes") / "a.1.npz"
    write_npz(path, np.ones((8, 8, 8), np.float32))
    return path


@pytest.mark.skipif(not hasattr(os, "waitid"), reason="needs processes that have ended and are not waited for")
def test_what_a_process_left_that_nobody_waits_for(tmp_path):
    """It has a number still, in a container without init for ever, and writes no more."""
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
        (tmp_path / f".a.png.{process.pid}@{platform.node()}.tmp").touch()
        remove_left(tmp_path)
        assert not list(tmp_path.iterdir())
