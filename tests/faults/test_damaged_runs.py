"""Every file of a run, cut short or with a flipped bit: going on notices it, or ends with the right bits."""

import random

import pytest
from tiny import BARE, METHOD_FLAGS, pair, run, volumes

EMITTER = ("--emitter", "sphere density=4 temperature=1")
SIMULATE = ("--size", "12x16", *EMITTER, "--substeps", "1", "--device", "cpu", "--quiet", *BARE)
PARTS = (("--frames", "1-2"), ("--frames", "1-3"))  # what is made first, and with --resume
CASES = [
    *(("reconstruct", name, blow) for name in ("run.toml", "frames.jsonl") for blow in ("cut", "flipped", "empty")),
    *(("simulate", "checkpoint.npz", blow) for blow in ("cut", "flipped", "empty")),
    *(("simulate", "run.toml", "cut"), ("simulate", "frames.jsonl", "flipped")),
    *(("reconstruct", "density.0002.vdb", "flipped"), ("simulate", "density.0002.vdb", "cut")),
]


@pytest.fixture(scope="module")
def commands(tmp_path_factory):
    """Two commands, and the volumes that each makes when nothing happens."""
    folder = tmp_path_factory.mktemp("whole")
    flags = {
        "reconstruct": ("reconstruct", *pair(folder, range(1, 4)), *METHOD_FLAGS, *BARE),
        "simulate": ("simulate", *SIMULATE),
    }
    for name, words in flags.items():
        assert run(*words, *PARTS[1], "-o", folder / name) == 0
    return {name: (words, volumes(folder / name)) for name, words in flags.items()}


def blows(data: bytes, chance: random.Random) -> dict[str, bytes]:
    """Return damaged forms of a file: cut, flipped, empty."""
    at = chance.randrange(len(data))
    flipped = data[:at] + bytes([data[at] ^ 1 << chance.randrange(8)]) + data[at + 1 :]
    return {"cut": data[: chance.randrange(len(data))], "flipped": flipped, "empty": b""}


@pytest.mark.parametrize(("command", "name", "blow"), CASES)
def test_going_on_with_a_damaged_file(commands, tmp_path, capsys, command, name, blow):
    """A damaged run.toml is named and nothing is touched; all else is noticed and made again, with the same bits."""
    words, whole = commands[command]
    assert run(*words, *PARTS[0], "-o", tmp_path) == 0
    path = tmp_path / name
    path.write_bytes(blows(path.read_bytes(), random.Random(f"{command} {name} {blow}"))[blow])
    capsys.readouterr()
    code, error = run(*words, *PARTS[1], "-o", tmp_path, "--resume"), capsys.readouterr().err
    if name == "run.toml" and code:
        assert (code, "run.toml" in error) == (2, True)
        return
    assert code == 0, error
    assert volumes(tmp_path) == whole


@pytest.mark.parametrize("place", range(0, 1000, 199))
def test_no_flip_in_the_settings_goes_unnoticed(commands, tmp_path, place):
    """Continued by itself, a run with other numbers than it was begun with would be two halves."""
    words, whole = commands["reconstruct"]
    assert run(*words, *PARTS[0], "-o", tmp_path) == 0
    path = tmp_path / "run.toml"
    data = bytearray(path.read_bytes())
    data[place % len(data)] ^= 1
    path.write_bytes(data)
    if run("reconstruct", "-o", tmp_path, "--resume", *PARTS[1], "--quiet") == 0:
        assert volumes(tmp_path) == whole
