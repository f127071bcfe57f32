"""The doctor reports what there is and what is not, whatever is broken."""

import asyncio
import json
import re

import pytest
import warp
from tiny import run

from warpfluid import __version__
from warpfluid.cli import app
from warpfluid.doctor import examining, farm, lines, windows


def test_report(capsys):
    """Versions, devices, memory, disk, kernels, video, windows, cluster; a line each for people."""
    assert run("doctor", "--device", "cpu") == 0
    text = capsys.readouterr().out
    for words in ("warpfluid", "warp-lang", "device       cpu", "threads", "memory", "kernels", "h264", "cluster"):
        assert words in text
    assert not re.search("MISSING|FAILS|LACKS|problem", text)
    assert run("doctor", "--json") == 0
    data = json.loads(capsys.readouterr().out)
    assert "cpu" in [device["name"] for device in data["devices"]]
    assert data["video"]["write"] is True
    assert set(data["video"]["read"]) >= {"h264", "prores"}
    assert 0 < data["memory"]["free"] <= data["memory"]["total"]
    assert data["disk"]["free"] > 0
    assert data["problems"] == []


def test_what_is_missing_is_told(monkeypatch, capsys):
    """Without a GL library, an encoder, a cluster's library or a lasting cache the ways out are named; it works."""
    monkeypatch.setattr(windows, "DRAW", "import os; os.abort()")
    monkeypatch.setattr(examining, "_has_codec", lambda name, mode: mode == "r" and name != "av1")
    monkeypatch.setattr(examining.os, "access", lambda *_: False)
    monkeypatch.setattr(examining, "_is_there", lambda _: False)
    monkeypatch.setattr(examining.shutil, "which", lambda _: None)
    monkeypatch.setattr(farm, "_installed", lambda: None)
    assert run("doctor") == 0
    text = capsys.readouterr().out
    for words in (
        "windows      no OpenGL: warpfluid draws without",
        "libgl1",
        "NOT KEPT: set WARPFLUID_CACHE",
        "(LACKS av1), LACKS the encoder libx264 of .mp4; install av",
        "pip install 'warpfluid[cluster]'",
        "Blender      not on this machine",
        "warpfluid reads and writes .vdb by itself",
    ):
        assert words in text
    named = {name for name in re.findall(r"`(\w+)`", text) if name not in ("pip", "dask")}
    assert named <= set(app)  # no command is named that there is not


@pytest.mark.parametrize("as_json", [False, True])
def test_what_cannot_work(monkeypatch, capsys, as_json):
    """A package that is not there, a device that fails: exit code 1, and both are named."""
    monkeypatch.setattr(examining, "PACKAGES", ("numpy", "warpfluid-lacks-this"))
    monkeypatch.setattr(examining, "_fault", lambda device: "out of luck")
    assert run("doctor", "--device", "cpu", *(["--json"] if as_json else [])) == 1
    text = capsys.readouterr().out
    if as_json:
        assert json.loads(text)["problems"] == ["warpfluid-lacks-this is not installed", "cpu: out of luck"]
    else:
        assert "warpfluid-lacks-this MISSING: install warpfluid again" in text
        assert "problem      cpu: out of luck" in text


def test_kernels_that_are_being_compiled(monkeypatch, tmp_path):
    """Folders without anything compiled in them are no compiled kernels."""
    found, folder = examining.examine("cpu"), tmp_path / "wp_warpfluid.kernels.x"
    monkeypatch.setattr(warp.config, "kernel_cache_dir", str(tmp_path))
    expected = {None: "compiled at the first run", "x.cpp": "being compiled by a command", "x.cpu1.o": "compiled, 0 MB"}
    for name, said in expected.items():
        if name:
            folder.mkdir(exist_ok=True)
            (folder / name).write_text("")
        report = lines(found | {"kernels": examining._kernel_cache()})
        assert f": {said}" in next(line for line in report if line.startswith("kernels"))


def test_a_device_that_is_not_there(capsys):
    """All else is reported."""
    assert run("doctor", "--device", "cuda:99") == 1
    text = capsys.readouterr().out
    assert "device       FAILS: there is no device 'cuda:99'" in text
    assert "windows" in text


def test_no_cluster(monkeypatch, capsys):
    """An address where nobody is, given by a flag or by the environment."""
    monkeypatch.setattr(farm, "PATIENCE", 0.5)
    monkeypatch.setenv("WARPFLUID_CLUSTER", "tcp://127.0.0.1:1")
    assert run("doctor") == 1
    assert "tcp://127.0.0.1:1 DOES NOT ANSWER" in capsys.readouterr().out
    assert run("doctor", "--cluster", "nonsense://x") == 1
    assert "nonsense://x DOES NOT ANSWER" in capsys.readouterr().out


def test_a_cluster(capsys):
    """Its workers are counted, with the versions they have."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, dashboard_address=":0", worker_dashboard_address=None
    ) as cluster:
        assert run("doctor", "--cluster", cluster.scheduler_address) == 0
        assert f": 2 workers, 2 threads, warpfluid {__version__} on 2" in capsys.readouterr().out
        cluster.scale(0)
        while cluster.scheduler.workers:
            cluster.sync(asyncio.sleep, 0.05)
        assert run("doctor", "--cluster", cluster.scheduler_address) == 1
        assert "HAS NO WORKERS: start some with `dask worker" in capsys.readouterr().out
