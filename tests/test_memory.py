"""Limits of memory: where they stand, the largest width that fits, and what is refused before any work."""

import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
import warp as wp
from hypothesis import given
from hypothesis import strategies as st

from warpfluid import memory

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


@given(there=st.floats(0, 1e9), width=st.integers(1, 3000), height=st.integers(1, 5))
def test_the_largest_width_fits_and_the_next_does_not(there, width, height):
    """Whatever grows with the width."""

    def bytes_of(narrower):
        return 1000 + 16 * narrower**3 * height

    fits = memory.largest_width(bytes_of, width, there)
    assert 0 <= fits <= max(width - 1, 0)
    assert fits == 0 or bytes_of(fits) <= there
    assert fits == width - 1 or bytes_of(fits + 1) > there


def test_what_is_too_large_is_refused(monkeypatch):
    """With the numbers and the way out; what fits is not; a card's own memory counts."""
    cpu, card = wp.get_device("cpu"), SimpleNamespace(is_cuda=True, total_memory=8e6)
    told = {"what": "the volumes", "way_out": "take {width}"}
    monkeypatch.setattr(memory, "memory_limit", lambda: 64e6)
    memory.check_memory(lambda n: n**3, 400, cpu, **told)
    with pytest.raises(ValueError, match=r"the volumes need about 0.064 GB of memory, cpu has 0.064 GB: take 399"):
        memory.check_memory(lambda n: n**3 + 1, 400, cpu, **told)
    with pytest.raises(ValueError, match="take 200"):
        memory.check_memory(lambda n: n**3, 400, card, **told)
    with pytest.raises(ValueError, match="use a larger machine"):
        memory.check_memory(lambda n: 1e9 + n, 400, cpu, **told)
