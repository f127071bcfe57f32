"""The doctor reports what there is and what is not, and never fails."""

import json
import re

from tiny import run

from warpfluid import doctor
from warpfluid.cli import app


def test_report(capsys):
    """Versions, devices, kernels, video and windows; a line each for people."""
    assert run("doctor") == 0
    text = capsys.readouterr().out
    for words in ("warpfluid", "warp-lang", "device       ", "threads", "kernels", "H.264", "windows"):
        assert words in text
    assert run("doctor", "--json") == 0
    data = json.loads(capsys.readouterr().out)
    assert "cpu" in [device["name"] for device in data["devices"]]
    assert data["video"] == {"write": True, "read": True}


def test_what_is_missing_is_told(monkeypatch, capsys):
    """Without a GL library, an encoder, a package or a lasting cache the ways out are named."""
    monkeypatch.setattr(doctor, "DRAW", "import os; os.abort()")
    monkeypatch.setattr(doctor, "PACKAGES", ("numpy", "warpfluid-lacks-this"))
    monkeypatch.setattr(doctor, "_has_codec", lambda name, mode: mode == "r")
    monkeypatch.setattr(doctor.os, "access", lambda *_: False)
    assert run("doctor") == 0
    text = capsys.readouterr().out
    for words in (
        "windows      no",
        "warpfluid draws without them",
        "libgl1",
        "MISSING",
        "NOT KEPT: set WARP_CACHE_PATH",
        "writes it: no",
        "install av",
    ):
        assert words in text
    assert set(re.findall(r"`(\w+)`", text)) <= set(app)  # no command is named that there is not
