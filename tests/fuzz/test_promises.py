"""A kilobyte that promises ten gigabytes is refused in a second, and before memory is taken."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="memory is measured by /proc")
SOUND = {"a.avi"}  # the codec knows better than the head, and is believed


@pytest.fixture(scope="module")
def answers(tmp_path_factory):
    """What reading each bomb cost, in a process that may have 8 GB."""
    command = [sys.executable, str(Path(__file__).with_name("bombs.py")), str(tmp_path_factory.mktemp("bombs"))]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return [json.loads(line) for line in done.stdout.splitlines()]


def test_each_is_refused_by_name(answers):
    """There is one of every kind."""
    assert len({answer["name"].rpartition(".")[2] for answer in answers}) >= 18
    for answer in answers:
        assert answer["name"] in (answer["error"] or str(SOUND)), answer


def test_none_takes_memory_or_time(answers):
    """300 MB and a second of the processor are far more than any of them takes."""
    for answer in answers:
        assert answer["bytes"] < 300e6, answer
        assert answer["seconds"] < 1, answer
