"""The long campaign of examples/fuzz.py notices what goes wrong, goes on, and keeps the files."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="memory is measured by /proc")

# Kinds of files whose readers do one wrong thing each; every third file is read well.
WRONG = """
import os, time
from types import SimpleNamespace

def wrong(act):
    def read(path):
        if int(path.read_bytes()) % 3:
            act(path)
    return read

def refuse(words):
    raise ValueError(words)

ACTS = {
    "crash": lambda path: os.abort(),
    "hang": lambda path: time.sleep(60),
    "exception": lambda path: {}["x"],
    "nameless": lambda path: refuse("no name"),
    "memory": lambda path: bytes(10**10),
    "slow": lambda path: sum(range(10**7)),
    "refused": lambda path: refuse(str(path)),
}
HARM = lambda data, chance: b"%d" % chance.randrange(99)
KINDS = {
    name: SimpleNamespace(make=lambda: [(".txt", b"")], harm=HARM, read=wrong(act)) for name, act in ACTS.items()
}
"""


@pytest.mark.parametrize("kind", ["crash", "hang", "exception", "nameless", "memory", "slow", "refused"])
def test_what_goes_wrong_is_noticed(tmp_path, kind):
    """It is counted beside what goes well; its file is kept, and makes it happen again."""
    text = (EXAMPLES / "fuzz.py").read_text("utf-8")
    text = text.replace("PATIENCE = 20.0", "PATIENCE = 2.0").replace("SLOW = 5.0", "SLOW = 0.02")
    (tmp_path / "fuzz.py").write_text(text)
    (tmp_path / "fuzz_files.py").write_text(WRONG)
    command = [sys.executable, "fuzz.py", "--minutes", "0.05", "--kinds", kind, "--keep", "kept"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == (kind != "refused"), done.stderr
    counts = re.findall(r"(\d+) (\w+)(?:,|$)", done.stdout.splitlines()[-1])
    found = {word: int(number) for number, word in counts}
    assert set(found) <= {"read", kind}
    assert found[kind] > 0
    kept = list((tmp_path / "kept").glob(f"{kind}.1.*.{kind}.txt"))
    assert bool(kept) == (kind != "refused")
    assert all(int(path.read_bytes()) % 3 for path in kept)
