"""Who computes: flags over the environment over a file over the defaults."""

import os
import subprocess
import sys

import pytest
from tiny import pair, run

from warpfluid.options import MachineOptions
from warpfluid.settings import make_machine

NOTHING = {"device": "auto", "jobs": 1, "cluster": None}
HERE, FARM, OTHER = {"jobs": "4"}, {"cluster": "tcp://farm:1"}, {"cluster": "tcp://other:1"}


def variables(table: dict) -> dict[str, str]:
    """Return a table as the environment says it."""
    return {f"WARPFLUID_{name.upper()}": str(value) for name, value in table.items()}


@pytest.mark.parametrize(
    ("flags", "environment", "file", "expected"),
    [
        ({}, {}, {}, {}),
        ({}, {}, {"device": "cpu", "jobs": 2}, {"device": "cpu", "jobs": 2}),
        ({}, {"device": "cpu"}, {"device": "cuda:3"}, {"device": "cpu"}),
        ({"device": "auto"}, {"device": "cpu"}, {"device": "cuda:3"}, {}),
        ({"device": None}, {"device": ""}, {"device": "cuda:3"}, {"device": "cuda:3"}),
        (HERE, FARM, {}, HERE),
        (FARM, HERE, OTHER, FARM),
        ({}, FARM, HERE, FARM),
        ({"device": "cpu"}, FARM, {}, FARM | {"device": "cpu"}),
    ],
)
def test_order(monkeypatch, flags, environment, file, expected):
    """Each place wins over the ones below; processes here and a cluster set each other aside."""
    for name, value in variables(environment).items():
        monkeypatch.setenv(name, value)
    assert make_machine(flags, {"machine": file}) == MachineOptions(**NOTHING | expected)


def test_both_in_one_place():
    """They are refused where nothing tells which is meant."""
    with pytest.raises(ValueError, match="--jobs is for this machine and --cluster for others"):
        make_machine(HERE | FARM)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("JOBS", "many", "WARPFLUID_JOBS: jobs is 'many', expected a number of processes from 1, or auto"),
        ("JOBS", "0", "WARPFLUID_JOBS: jobs is '0'"),
        ("THREADS", "none", "WARPFLUID_THREADS is 'none', expected a number of threads from 1"),
        ("THREADS", "0", "WARPFLUID_THREADS is '0'"),
        ("DEVICE", "gpu", "there is no device 'gpu' (WARPFLUID_DEVICE): this machine has cpu"),
    ],
)
def test_wrong_values(tmp_path, monkeypatch, capsys, name, value, message):
    """The variable is named, before any work."""
    monkeypatch.setenv(f"WARPFLUID_{name}", value)
    assert run("reconstruct", *pair(tmp_path), "-o", tmp_path / "out") == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("flags", [{"jobs": "2"}, {"cluster": "tcp://a:1"}])
def test_a_flag_sets_aside_what_is_wrong(monkeypatch, flags):
    """Nobody is stopped by what does not count."""
    monkeypatch.setenv("WARPFLUID_JOBS", "many")
    machine = make_machine(flags)
    assert {name: getattr(machine, name) for name in flags} == flags


def test_jobs_of_a_file(tmp_path, capsys):
    """A number or a text; anything else is refused with the file and the table."""
    (tmp_path / "c.toml").write_text("[machine]\njobs = 1.5\n")
    assert run("render", "fire", "--config", tmp_path / "c.toml", "-o", tmp_path / "a.png") == 2
    assert f"{tmp_path / 'c.toml'}: [machine] jobs is 1.5, expected" in capsys.readouterr().err


def test_the_folder_of_kernels(tmp_path):
    """Compiled kernels lie where the variable says; a file in its place is refused."""
    program = (
        "import warp as wp; from warpfluid.device import start_warp; start_warp(); print(wp.config.kernel_cache_dir)"
    )

    def start(folder):
        environment = os.environ | {"WARPFLUID_CACHE": str(folder)}
        return subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True)

    (tmp_path / "taken").write_text("")
    assert start(tmp_path / "new" / "kernels").stdout.startswith(str(tmp_path / "new" / "kernels"))
    assert f"WARPFLUID_CACHE is '{tmp_path / 'taken'}', but" in start(tmp_path / "taken").stderr
