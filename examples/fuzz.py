"""
Damaged files, a great many
===========================

Every kind of file that warpfluid reads is damaged at random and read by a child process: bits flipped, parts cut out
or repeated, numbers made extreme, checksums put right again. The answer must be success, or one error of ours that
names the file. A crash, another exception, a warning, more than a few seconds or a few hundred megabytes are findings,
and the file is kept. ``python examples/fuzz.py --minutes 5 --kinds vdb,exr``; the same seed gives the same files.
"""

# %%
# The child reads one file after another; before each it says which one, so that a crash can be told.

import argparse
import os
import queue
import random
import re
import resource
import subprocess
import sys
import tempfile
import threading
import time
import traceback
import warnings
from collections import Counter
from pathlib import Path

from fuzz_files import KINDS

PATIENCE = 20.0  # seconds for a file
SLOW = 5.0  # processor seconds that are a finding
ROOM = 4 << 30  # bytes of address space
GROWTH = 1.2e9  # bytes of memory that are a finding
ALIKE = 2  # findings of one kind that are told and kept


def input_of(kind: str, seed: int, number: int) -> tuple[str, bytes]:
    """Return the ending and the bytes of one damaged file."""
    chance = random.Random(f"{kind} {seed} {number}")
    ending, data = chance.choice(_sound(kind))
    return ending, KINDS[kind].harm(data, chance)


def _sound(kind: str, cache={}) -> list[tuple[str, bytes]]:  # noqa: B006
    if kind not in cache:
        cache[kind] = KINDS[kind].make()
    return cache[kind]


def peak(reset: bool = False) -> float:
    """Return the most memory that this process had since the last reset [byte]."""
    if reset:
        Path("/proc/self/clear_refs").write_text("5")
    lines = Path("/proc/self/status").read_text().splitlines()
    return 1024 * float(next(line.split()[1] for line in lines if line.startswith("VmHWM")))


def judge(kind: str, path: Path) -> str:
    """Read a file; return ``read``, ``refused`` or what is wrong with the answer."""
    before, begin = peak(reset=True), time.process_time()
    try:
        KINDS[kind].read(path)
        answer = "read"
    except (ValueError, OSError) as error:
        answer = "refused" if path.name in str(error) else f"nameless: {type(error).__name__}: {error}"
    except MemoryError:
        answer = "memory: MemoryError"
    except BaseException:
        answer = f"exception: {traceback.format_exc(limit=-3)}"
    grown, took = peak() - before, time.process_time() - begin
    if grown > GROWTH:
        return f"memory: {grown / 1e6:.0f} MB, then {answer}"
    return f"slow: {took:.1f} s, then {answer}" if took > SLOW else answer


def serve(kind: str, seed: int, first: int, folder: Path) -> None:
    """Read damaged files until killed; a line for each."""
    resource.setrlimit(resource.RLIMIT_AS, (ROOM, ROOM))
    _sound(kind)
    warnings.simplefilter("error")
    for number in range(first, 10**9):
        ending, data = input_of(kind, seed, number)
        path = folder / f"damaged.0007{ending}"
        path.write_bytes(data)
        print(f"begin {number} {path.name}", flush=True)
        print("end", repr(judge(kind, path)), flush=True)
        path.unlink()


# %%
# The parent starts children, notices those that fall or hang, and counts.


class Answers(Counter):
    """How often each answer was given, and how often one like it."""

    def __init__(self):
        super().__init__()
        self.alike = Counter()


def campaign(kind: str, seed: int, seconds: float, keep: Path) -> Answers:
    """Damage files of one kind for some time; return how often each answer was given."""
    counts, number, until = Answers(), 0, time.monotonic() + seconds
    while time.monotonic() < until:
        with tempfile.TemporaryDirectory() as folder:
            number = follow(kind, seed, number, Path(folder), keep, counts, until)
    return counts


def follow(kind: str, seed: int, first: int, folder: Path, keep: Path, counts: Answers, until: float) -> int:
    """Follow one child until it ends or time is up; return the number to go on with."""
    command = [sys.executable, __file__, "--serve", kind, str(seed), str(first), str(folder)]
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    with tempfile.TemporaryFile() as noise:
        child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=noise, text=True, env=environment)
        lines: queue.Queue = queue.Queue()
        threading.Thread(target=lambda: [*map(lines.put, child.stdout), lines.put("")], daemon=True).start()
        number, name = first, ""
        while time.monotonic() < until or name:
            try:
                line = lines.get(timeout=PATIENCE)
            except queue.Empty:
                line = "hang"
            if line.startswith("begin"):
                _, word, name = line.split()
                number = int(word)
                continue
            answer = line.removeprefix("end ").strip().strip("'\"") if line.startswith("end") else ""
            answer = answer or ("hang: no answer" if line else f"crash: exit code {child.wait()}")
            note(answer, kind, seed, number, keep, counts)
            number, name = number + 1, ""
            if not line.startswith("end"):
                break
        child.kill()
        child.wait()
    return number


def note(answer: str, kind: str, seed: int, number: int, keep: Path, counts: Answers) -> None:
    """Count an answer; keep the file of a finding."""
    word = answer.split(":")[0]
    counts[word] += 1
    kin = " ".join(re.findall(r"line \d+, in \w+", answer)) or re.sub(r"\d+", "#", answer)[:60]
    counts.alike[kin] += 1
    if word in ("read", "refused") or counts.alike[kin] > ALIKE:
        return
    keep.mkdir(parents=True, exist_ok=True)
    ending, data = input_of(kind, seed, number)
    kept = keep / f"{kind}.{seed}.{number}.{word}{ending}"
    kept.write_bytes(data)
    print(f"{kept}\n    {answer.encode().decode('unicode_escape', 'replace').strip()}", flush=True)


def main() -> int:
    """Damage files of all kinds in turn; the exit code is 1 if there is any finding."""
    parser = argparse.ArgumentParser(description="Read damaged files and tell what goes wrong.")
    parser.add_argument("--minutes", type=float, default=1.0, help="for each kind")
    parser.add_argument("--kinds", default=",".join(KINDS), help="which, separated by commas")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, default=Path("fuzz-findings"), help="folder for the files of findings")
    choices = parser.parse_args()
    total = Counter()
    for kind in choices.kinds.split(","):
        counts = campaign(kind, choices.seed, 60 * choices.minutes, choices.keep)
        found = ", ".join(f"{count} {word}" for word, count in sorted(counts.items()))
        print(f"{kind:6} {sum(counts.values())} files: {found}", flush=True)
        total += counts
    return int(any(word not in ("read", "refused") for word in total))


if __name__ == "__main__":
    if sys.argv[1:2] == ["--serve"]:
        serve(sys.argv[2], int(sys.argv[3]), int(sys.argv[4]), Path(sys.argv[5]))
    else:
        sys.exit(main())
