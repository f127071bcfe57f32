"""Completion in real shells: keys are typed, and what stands on the line afterwards is read."""

import json
import os
import pty
import select
import shutil
import subprocess
import sys
import time

import pytest
from tiny import run

from warpfluid.cli import app
from warpfluid.cli.completion import make_script

PATIENCE = 20.0  # s
START = {
    "bash": (["bash", "--norc", "--noprofile", "-i"], "source {script}"),
    "zsh": (["zsh", "-f", "-i"], "fpath=({folder} $fpath); autoload -U compinit; compinit -u -D"),
}
CASES = [
    ("warpfluid rec", "warpfluid reconstruct "),
    ("warpfluid render --mot", "warpfluid render --motion-blur "),
    ("warpfluid render fire --mode em", "warpfluid render fire --mode emission "),
    ("warpfluid reconstruct --front fro", "warpfluid reconstruct --front front.mp4 "),
    ("warpfluid reconstruct --no-half --side fro", "warpfluid reconstruct --no-half --side front.mp4 "),
    ("warpfluid render camp", "warpfluid render campfire/"),
    ("warpfluid export --half camp", "warpfluid export --half campfire/"),
    ("warpfluid completion f", "warpfluid completion fish "),
]
OF_BASH = [
    ("warpfluid reconstruct --view 0=fro", "warpfluid reconstruct --view 0=front.mp4 "),
    ("warpfluid inspect my", r"warpfluid inspect my\ clip.mov "),
]


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with something to complete, and the scripts under the names that shells look for."""
    folder = tmp_path_factory.mktemp("shell")
    for name in ("front.mp4", "my clip.mov"):
        (folder / name).write_text("")
    (folder / "campfire").mkdir()
    for shell, name in (("bash", "warpfluid.bash"), ("zsh", "_warpfluid"), ("fish", "warpfluid.fish")):
        (folder / name).write_text(make_script(shell))
    return folder


def typed(shell: str, place, lines: list[str]) -> list[str]:
    """Type lines into a shell, each with a Tab at its end; return what they have become."""
    command, setup = START[shell]
    pid, screen = pty.fork()
    if pid == 0:
        os.chdir(place)
        os.environ |= {"TERM": "dumb" if shell == "bash" else "vt100", "PS1": "> ", "COLUMNS": "400"}
        os.execvp(command[0], command)
    try:
        named = setup.format(script=place / "warpfluid.bash", folder=place)
        send(screen, f"stty cols 400; {setup and named}; echo rea''dy\n")
        read(screen, "ready")
        found = []
        for number, line in enumerate(lines):
            send(screen, f"{line}\t")
            time.sleep(0.3)  # or a shell takes what follows for pasted text
            send(screen, f"\x01print '\x05' {number}.\n".replace("print", "printf '%s|\\n'"))
            found.append(read(screen, f"\n{number}.|"))
        return [text.rsplit("\n", 1)[-1].strip("\r").removesuffix("|") for text in found]
    finally:
        os.close(screen)
        os.waitpid(pid, 0)


def send(screen: int, text: str) -> None:
    """Press keys."""
    os.write(screen, text.encode())


def read(screen: int, end: str) -> str:
    """Return what a shell prints up to a text."""
    shown, limit = "", time.monotonic() + PATIENCE
    while end not in shown:
        assert time.monotonic() < limit, f"the shell shows only {shown!r}"
        if select.select([screen], [], [], 0.2)[0]:
            shown += os.read(screen, 65536).decode(errors="replace").replace("\r\n", "\n")
    return shown.split(end)[0]


@pytest.mark.parametrize("shell", START)
def test_keys(shell, place):
    """Commands, options, choices, files and folders; a switch takes no value."""
    if not shutil.which(shell):
        pytest.skip(f"{shell} is not installed")
    cases = CASES + (OF_BASH if shell == "bash" else [])
    ends = "" if shell == "bash" else " /"  # zsh takes its own back where another key follows
    found = typed(shell, place, [line for line, _ in cases])
    assert [line.rstrip(ends) for line in found] == [line.rstrip(ends) for _, line in cases]


@pytest.mark.parametrize(("line", "expected"), CASES)
def test_fish(line, expected, place):
    """It tells its candidates without a terminal."""
    if not shutil.which("fish"):
        pytest.skip("fish is not installed")
    program = f"source warpfluid.fish; complete -C '{line}'"
    done = subprocess.run(["fish", "-N", "-c", program], cwd=place, capture_output=True, text=True, check=True)
    words = [candidate.split("\t")[0] for candidate in done.stdout.splitlines()]
    assert words == [expected.split()[-1]]


def test_bash_lists_every_option(place):
    """Without a terminal, too: each command offers exactly its own options."""
    for command in (name for name in app if not name.startswith("-")):
        program = f"source warpfluid.bash; COMP_WORDS=(warpfluid {command} --) COMP_CWORD=2; _warpfluid"
        program += '; printf "%s\\n" "${COMPREPLY[@]}"'
        done = subprocess.run(["bash", "-c", program], cwd=place, capture_output=True, text=True, check=True)
        names = {name for argument in app[command].assemble_argument_collection() for name in argument.names}
        wanted = {name for name in names if name.startswith("--")}
        assert set(done.stdout.split()) == wanted | {"--help", "--version"}


def test_the_command(capsys):
    """It prints the script, or one JSON document with it."""
    assert run("completion", "zsh") == 0
    script = capsys.readouterr().out
    assert script == make_script("zsh") + "\n"
    assert run("completion", "zsh", "--json") == 0
    assert json.loads(capsys.readouterr().out) == {"shell": "zsh", "script": make_script("zsh")}
    assert run("completion", "tcsh") == 2
    assert '"bash", "zsh", "fish"' in capsys.readouterr().err


def test_a_reader_that_stops():
    """`warpfluid completion bash | head -5` is no error, however little is printed."""
    command = f"{sys.executable} -m warpfluid completion bash | head -5"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=True)
    assert len(done.stdout.splitlines()) == 5
    assert done.stderr == ""
