"""Every system: what it returns, frames that are empty, sequences, starts."""

import json
from typing import get_args, get_type_hints

import numpy as np
import pytest
from tiny import numbers, pair, quick, run

from warpfluid.options import ReconstructOptions
from warpfluid.projector import Projector
from warpfluid.reconstruction.em import reconstruct
from warpfluid.reconstruction.systems import SYSTEMS, round_count
from warpfluid.views import Views

FEW = {"mutations": 50_000, "chains": 20, "convex_steps": 60}


def views_of(fire, angles):
    return Views(Projector(angles, fire.shape, device="cpu").project(fire), angles)


def test_every_method_has_a_system():
    """Appearance transfer is the iteration; all others are in the table."""
    methods = set(get_args(get_type_hints(ReconstructOptions)["method"]))
    assert methods == {*SYSTEMS, "appearance-transfer"}


@pytest.mark.parametrize("angles", [(0.0,), (20.0,), (0.0, 90.0), (0.0, 50.0), (0.0, 40.0, 90.0)])
@pytest.mark.parametrize("method", SYSTEMS)
def test_a_volume_of_the_views(fire, method, angles, device):
    """Finite and nowhere negative, in the whole box, about as bright as the views, with least squares beside it."""
    views, told = views_of(fire, angles), []
    options = ReconstructOptions(method=method, sad_weight=0.1, **FEW)
    found = reconstruct(views, options, device=device, progress=lambda *now: told.append(now))
    assert found.volume.shape == fire.shape
    assert np.isfinite(found.volume).all()
    assert found.volume.min() >= 0
    assert found.volume.sum(dtype=np.float64) == pytest.approx(fire.sum(dtype=np.float64), rel=0.15)
    assert found.energies.shape == (len(told), 2)
    assert len(told) == (round_count(options) if len(told) else 0)
    least_squares = reconstruct(views, ReconstructOptions(method="lsm"), device=device)
    np.testing.assert_array_equal(found.initial, least_squares.volume)


@pytest.mark.parametrize("method", SYSTEMS)
def test_nothing_lit(method, device):
    """An empty frame has an empty volume."""
    found = reconstruct(
        Views(np.zeros((2, 12, 10), np.float32), (0.0, 90.0)), ReconstructOptions(method=method), device=device
    )
    assert not found.volume.any()


@pytest.mark.parametrize("start", ["multiplication", "flame-sheet"])
@pytest.mark.parametrize("angles", [(0.0,), (0.0, 90.0), (0.0, 50.0, 100.0)])
def test_starts(fire, start, angles):
    """The iteration begins with the coupling, goes elsewhere than from least squares, and its energy falls."""
    views = views_of(fire, angles)
    options = {"angles": 24, "iterations": 3}
    found = reconstruct(views, ReconstructOptions(start=start, **options), device="cpu")
    coupling = reconstruct(views, ReconstructOptions(method=start), device="cpu")
    np.testing.assert_array_equal(found.initial, coupling.volume)
    assert found.energies[-1, 1] < found.energies[0, 0]
    usual = reconstruct(views, ReconstructOptions(**options), device="cpu")
    assert (found.volume != usual.volume).any()


@pytest.mark.parametrize("method", ["stochastic", "flame-sheet"])
def test_runs_of_other_methods(tmp_path, method):
    """From the command line: frames alone whatever coherence says, resumed bit for bit, walks in the records."""
    flags = [*pair(tmp_path), "--method", method, "--mutations", "20000", "--chains", "10", "--no-turntable"]
    out = tmp_path / "run"
    assert run("reconstruct", *quick(*flags, "--frames", "1"), "-o", out, "-q") == 0
    assert run("reconstruct", "--resume", "--frames", "1-3", "-o", out, "-q", "--device", "cpu", "--no-turntable") == 0
    assert numbers(out) == [1, 2, 3]
    records = [json.loads(line) for line in (out / "frames.jsonl").read_text().splitlines()]
    assert not any(record["carried"] for record in records)
    for record in records:
        assert ("walk" in record) == (method == "stochastic")
        assert len(record.get("walk", [])) == len(record["energies"])
    assert f'method = "{method}"' in (out / "run.toml").read_text()
    page = (out / "report.html").read_text()
    assert ("stochastic tomography" if method == "stochastic" else "flame sheet") in page
    assert "after M" not in page
