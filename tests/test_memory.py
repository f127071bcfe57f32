"""Limits of memory: where they stand, the largest width that fits, and what is refused before any work."""

import math
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
import warp as wp
from hypothesis import given
from hypothesis import strategies as st
from tiny import BARE, pair, run

from warpfluid import memory
from warpfluid.simulation.need import FLUID

GB = 10**9


@pytest.fixture
def groups(tmp_path, monkeypatch):
    """Control groups as files of our own: inner and outer, on a machine of 100 GB."""
    inner, outer = tmp_path / "outer" / "inner", tmp_path / "outer"
    inner.mkdir(parents=True)
    monkeypatch.setattr(memory, "_groups", lambda: iter([inner, outer, tmp_path]))
    monkeypatch.setattr(memory, "machine_memory", lambda: 100.0 * GB)
    return inner, outer


def limit(group: Path, most: str, current: int = 0, cached: int = 0) -> None:
    (group / "memory.max").write_text(f"{most}\n")
    (group / "memory.current").write_text(f"{current}\n")
    (group / "memory.stat").write_text(f"anon 5\ninactive_file {cached}\n")


def test_the_narrowest_group_counts(groups):
    """Of all that a process is in; "max" is none. What files hold in memory can be taken back."""
    assert memory.memory_limit() == 100 * GB
    limit(groups[0], "max")
    limit(groups[1], str(4 * GB), 3 * GB, GB // 2)
    assert memory.memory_limit() == 4 * GB
    assert memory.free_memory() <= 1.5 * GB
    limit(groups[0], str(2 * GB), 2 * GB)
    assert memory.memory_limit() == 2 * GB
    assert memory.free_memory() == 0


def test_ulimit_counts():
    """In a process that has one."""
    code = (
        "import resource; resource.setrlimit(resource.RLIMIT_DATA, (3 * 10**9,) * 2); "
        "from warpfluid.memory import memory_limit; print(memory_limit())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert float(done.stdout) <= 3e9


@given(there=st.floats(0, 1e9), width=st.integers(1, 3000), height=st.integers(1, 3000))
def test_the_largest_size_fits_and_the_next_does_not(there, width, height):
    """Whatever grows with it; proportions stay."""

    def bytes_of(size):
        return 1000 + 16 * size[0] ** 2 * size[1]

    fits = memory.largest_size(bytes_of, (width, height), there)
    if fits is None:
        assert width == 1 or bytes_of((1, max(1, round(height / width)))) > there
        return
    assert bytes_of(fits) <= there
    assert 0 < fits[0] < width
    assert fits[1] == max(1, round(fits[0] * height / width))
    wider = fits[0] + 1
    assert wider == width or bytes_of((wider, max(1, round(wider * height / width)))) > there


def test_what_is_too_large_is_refused(monkeypatch):
    """With the numbers and the way out; what fits is not; a card's own memory counts."""
    cpu, card = wp.get_device("cpu"), SimpleNamespace(is_cuda=True, total_memory=8e6)
    told = {"what": "volumes", "way_out": "take {width}, {size}, {scale}"}
    monkeypatch.setattr(memory, "memory_limit", lambda: 64e6)
    memory.check_memory(math.prod, (400, 400, 400), cpu, **told)
    with pytest.raises(ValueError, match=r"volumes need about 0.065 GB of memory, cpu has 0.064 GB: take 398, 398x398"):
        memory.check_memory(lambda size: 1.01 * math.prod(size), (400, 400, 400), cpu, **told)
    with pytest.raises(ValueError, match=r"take 200, 200x200x200, 0\.5$"):
        memory.check_memory(math.prod, (400, 400, 400), card, **told)
    with pytest.raises(ValueError, match=r"this machine has 0\.064 GB: use a larger machine"):
        memory.check_memory(lambda size: 1e9 + size[0], (400,), **told)


@pytest.fixture(scope="module")
def clip(tmp_path_factory) -> str:
    """A simulation of one frame, 12 x 16 x 12 voxels with all fields."""
    folder = tmp_path_factory.mktemp("clip") / "run"
    flags = ["--size", "12x16", "--emitter", "sphere density=8", "--frames", "1", "--device", "cpu", "-q", *BARE]
    assert run("simulate", *flags, "-o", folder) == 0
    return str(folder)


@pytest.mark.parametrize(
    ("command", "room", "words"),
    [
        ("reconstruct", 20.3e6, "reduce the footage, --resolution "),
        ("simulate", 12**2 * 16 * FLUID - 1, "fits has 11x15 voxels: choose it with --size"),
        (
            "simulate CLIP --resolution-scale 2",
            24**2 * 32 * FLUID - 1,
            "fits has 23x31 voxels: lower --resolution-scale",
        ),
        ("render CLIP", 7e5, "voxels fit: make smaller ones where they come from"),
        ("render CLIP", 12**2 * 16 * 12 - 1, "at most 11x15x11 voxels fit"),
        ("export CLIP", 12**2 * 16 * 12 * 5 - 1, "at most 11x15x11 voxels fit"),
    ],
)
def test_every_command_refuses_what_does_not_fit(command, room, words, clip, tmp_path, monkeypatch, capsys):
    """Before anything is written, and with the largest size that would do."""
    monkeypatch.setattr(memory, "machine_memory", lambda: float(room))
    name, *rest = command.replace("CLIP", clip).split()
    flags = {
        "reconstruct": pair(tmp_path),
        "simulate": [] if rest else ["--size", "12x16", "--emitter", "sphere density=8"],
        "render": ["--resolution", "60x80"],
        "export": [],
    }[name]
    out = tmp_path / ("out.png" if name == "render" else "out")
    assert run(name, *rest, *flags, *([] if name == "export" else ["--device", "cpu"]), "-o", out) == 2
    told = capsys.readouterr().err
    assert words in told
    assert "GB of memory" in told
    assert not out.exists()
