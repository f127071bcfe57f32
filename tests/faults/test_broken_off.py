"""Runs of two processes that are really broken off: killed, interrupted, out of disk, damaged; and then go on."""

import contextlib
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from tiny import BARE, numbers, pair, run, volumes

from warpfluid.run import Run

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals of another kind")
FRAMES = range(1, 9)
METHOD = ("--iterations", "2", "--angles", "12", "--cg-steps", "2", "--lsm-steps", "2", "--device", "cpu")
PIECES = ("--piece", "3", "--overlap", "1")
# A shell starts what runs in its background with Ctrl-C ignored, and tests may run there.
PROGRAM = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from warpfluid.cli import main
if __name__ == "__main__":
    sys.exit(main())
"""


@pytest.fixture(scope="module")
def shot(tmp_path_factory):
    """Footage, its flags, and the volumes of a run that nothing happened to."""
    folder = tmp_path_factory.mktemp("shot")
    flags = [*pair(folder, FRAMES), *BARE, *METHOD, *PIECES]
    assert run("reconstruct", *flags, "-o", folder / "unbroken") == 0
    return folder, flags, volumes(folder / "unbroken")


def start(folder: Path, flags, *more, **options) -> subprocess.Popen:
    """Start a run of two processes."""
    command = [sys.executable, "-c", PROGRAM, "reconstruct", *flags, "-o", folder, "--jobs", "2", *more]
    pipe = subprocess.PIPE
    return subprocess.Popen(list(map(str, command)), stdout=pipe, stderr=pipe, text=True, **options)


def until(process: subprocess.Popen, folder: Path, count: int) -> None:
    """Wait until some frames are there, or the run has ended."""
    give_up = time.monotonic() + 300  # kernels may have to be compiled
    while len(list(folder.glob("density.*.vdb"))) < count and process.poll() is None:
        assert time.monotonic() < give_up
        time.sleep(0.002)


def workers(process: subprocess.Popen) -> list[int]:
    """Return the process ids of a run's workers, those that multiprocessing started for us."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, parent = path.read_text().rsplit(")", 1)[1].split()[:2]
            words = (path.parent / "cmdline").read_bytes()
            if int(parent) == process.pid and state != "Z" and b"spawn_main" in words:
                found.append(int(path.parent.name))
    return found


def nothing_is_half(folder: Path) -> None:
    """Every frame that is noted is whole, and every record is a line."""
    made = Run(folder)
    assert all(made.is_whole(frame) for frame in made.records())


def finish(folder: Path, whole: dict[str, bytes]) -> None:
    """Go on, and end with the bits of the run that nothing happened to."""
    kept = {path: path.stat().st_mtime_ns for path in map(Run(folder).volume_path, Run(folder).records())}
    assert run("reconstruct", "-o", folder, "--resume") == 0
    assert volumes(folder) == whole
    assert sorted(numbers(folder)) == list(FRAMES)
    assert not list(folder.glob(".*"))
    assert {path: path.stat().st_mtime_ns for path in kept} == kept  # nothing that was finished was lost


@pytest.mark.parametrize("seed", [1, 2])
def test_workers_are_killed(shot, tmp_path, seed):
    """Two of them at random moments: the run replaces them, ends well, and the bits are right."""
    _, flags, whole = shot
    chance, folder = random.Random(seed), tmp_path / "run"
    process = start(folder, flags)
    killed = []
    for count in sorted(chance.sample(range(1, 5), 2)):
        until(process, folder, count)
        time.sleep(chance.uniform(0, 0.05))
        killed.append(chance.choice(workers(process)))
        os.kill(killed[-1], signal.SIGKILL)
    _, error = process.communicate(timeout=200)
    assert process.returncode == 0, error
    assert len(set(killed)) == 2
    assert volumes(folder) == whole
    assert sorted(numbers(folder)) == list(FRAMES)


@pytest.mark.parametrize(("how", "count"), [(signal.SIGKILL, 2), (signal.SIGINT, 3)])
def test_the_whole_run_is_broken_off(shot, tmp_path, how, count):
    """With its workers, which do not outlive it; Ctrl-C says how to go on."""
    _, flags, whole = shot
    folder = tmp_path / "run"
    process = start(folder, flags, start_new_session=True)
    until(process, folder, count)
    assert len(volumes(folder)) < len(whole)
    if how == signal.SIGINT:
        os.killpg(process.pid, how)  # as a terminal does: to the workers, too
    else:
        process.kill()
    _, error = process.communicate(timeout=100)
    if how == signal.SIGINT:
        assert process.returncode == 130
        assert f"to continue: warpfluid reconstruct -o {folder} --resume" in error
        assert "Traceback" not in error
    else:
        assert process.returncode == -signal.SIGKILL
    nothing_is_half(folder)
    finish(folder, whole)


FILLING = """
import resource, signal, sys
from warpfluid.cli import main
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
assert main(sys.argv[2:] + ["--frames", "1-2"]) == 0
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]),) * 2)
sys.exit(main(sys.argv[2:] + ["--frames", "1-8", "--resume"]))
"""


def test_a_disk_that_is_full(shot, tmp_path):
    """No file may grow beyond some size: the run stops at once, says what was not made, and goes on when it may."""
    _, flags, whole = shot
    folder, limit = tmp_path / "run", len(whole["density.0003.vdb"]) - 1
    command = [sys.executable, "-c", FILLING, limit, "reconstruct", *flags, "-o", folder]
    ended = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=200, check=False)
    assert ended.returncode == 1, ended.stderr
    assert "density.0003.vdb: cannot write the file: file too large" in ended.stderr
    assert "frames 4-8: not made" in ended.stderr
    assert "--resume tries again" in ended.stderr
    assert "Traceback" not in ended.stderr
    assert not list(folder.glob(".density*"))
    assert list(Run(folder).records()) == [1, 2]
    finish(folder, whole)


def test_damaged_files(shot, tmp_path):
    """Records and volumes that are cut off or have flipped bytes are made again; a damaged run.toml is named."""
    _, flags, whole = shot
    chance, folder = random.Random(4), tmp_path / "run"
    assert run("reconstruct", *flags, "-o", folder) == 0
    for name in ("density.0002.vdb", "density.0006.vdb"):
        data = bytearray((folder / name).read_bytes())
        data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
        (folder / name).write_bytes(data if name.endswith("2.vdb") else data[: chance.randrange(len(data))])
    lines = (folder / "frames.jsonl").read_bytes()
    (folder / "frames.jsonl").write_bytes(lines[: chance.randrange(len(lines) // 2, len(lines))])
    assert run("reconstruct", "-o", folder, "--resume") == 0
    assert volumes(folder) == whole
    assert sorted(numbers(folder)) == list(FRAMES)


def test_damaged_settings(shot, tmp_path, capsys):
    """Cut off or flipped, they are refused by name, and no volume is touched."""
    unbroken = shot[0] / "unbroken"
    folder = tmp_path / "run"
    folder.mkdir()
    for path in unbroken.iterdir():
        (folder / path.name).write_bytes(path.read_bytes())
    text = (folder / "run.toml").read_bytes()
    before = volumes(folder)
    for damaged in (text[:40], text[:100] + b"\xff" + text[101:], text.replace(b"overlap", b"overlop")):
        (folder / "run.toml").write_bytes(damaged)
        assert run("reconstruct", "-o", folder, "--resume") == 2
        assert "run.toml" in capsys.readouterr().err
    assert volumes(folder) == before


def test_a_kernel_cache_that_cannot_be_written(shot, tmp_path):
    """The workers share another folder, and it is gone in the end."""
    _, flags, _ = shot
    (tmp_path / "cache").write_text("in the way")
    (tmp_path / "tmp").mkdir()
    environment = os.environ | {"WARP_CACHE_PATH": str(tmp_path / "cache"), "TMPDIR": str(tmp_path / "tmp")}
    process = start(tmp_path / "run", [*flags, "--frames", "1,2,4", "--coherence", "none"], env=environment)
    _, error = process.communicate(timeout=400)
    assert process.returncode == 0, error
    assert "Traceback" not in error
    assert len(volumes(tmp_path / "run")) == 3
    assert not list((tmp_path / "tmp").iterdir())
