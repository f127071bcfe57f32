"""A run on disk: what counts as finished, what may be continued, what is never lost."""

import dataclasses
import os
import platform
import subprocess
import sys
import tomllib

import numpy as np
import pytest
import tomli_w
from hypothesis import given
from hypothesis import settings as examples
from hypothesis import strategies as st
from tiny import numbers

from warpfluid.files.lines import read_lines
from warpfluid.options import InputOptions, OutputOptions, ReconstructOptions, Scene, SimulateOptions
from warpfluid.run import Run
from warpfluid.settings import Settings, SimulateSettings, check_same, read_settings

DENSITY = np.random.default_rng(3).random((9, 9, 11)).astype(np.float32)
FACTS = {"device": "cpu", "inputs": {"0": "abc", "90": "def"}}


def settings(views=("0=/a", "90=/b"), output=None, **options) -> Settings:
    """Return settings, some of them changed."""
    method, footage = ReconstructOptions(**options), InputOptions()
    return Settings(views=views, input=footage, reconstruct=method, output=output or OutputOptions())


@pytest.fixture
def run(tmp_path) -> Run:
    """A run with two frames."""
    run = Run(tmp_path / "run")
    assert run.begin(settings(), FACTS) == {}
    for frame in (1001, 1002):
        run.write_frame(frame, DENSITY * frame, OutputOptions(drop_below=0), {"seconds": 1.0})
    return run


def test_what_is_written_comes_back(run):
    """Volumes in the order of the package, records by frame, and options with versions and hashes."""
    np.testing.assert_array_equal(run.volume(1002), DENSITY * 1002)
    assert list(run.records()) == [1001, 1002]
    assert run.records()[1001]["file"] == "density.1001.vdb"
    document = run.settings()
    assert document["views"] == ["0=/a", "90=/b"]
    assert document["reconstruct"]["iterations"] == 8
    assert "angles" not in document["reconstruct"]  # nothing was chosen, and TOML has no null
    assert document["made-with"]["inputs"] == FACTS["inputs"]
    assert document["made-with"]["warp-lang"]
    assert not list(run.folder.glob(".*"))


def test_a_run_is_not_lost_by_accident(run):
    """A second run in the folder needs a word."""
    with pytest.raises(ValueError, match="holds a run already: continue it with --resume"):
        run.begin(settings(), FACTS)
    assert list(run.begin(settings(), FACTS, resume=True)) == [1001, 1002]
    (run.folder / "notes.txt").write_text("mine")
    (run.folder / "report.html").write_text("old")
    assert run.begin(settings(blur=1.0), FACTS, overwrite=True) == {}
    assert sorted(path.name for path in run.folder.iterdir()) == ["notes.txt", "run.toml"]


@pytest.mark.parametrize(
    ("changed", "facts", "words"),
    [
        (settings(iterations=3), FACTS, r"iterations \(was 8, now 3\)"),
        (settings(noise_grain=3.0), FACTS, r"noise-grain \(was None, now 3.0\)"),
        (settings(views=("0=/a", "90=/c")), FACTS, r"views \(were 0=/a 90=/b, now 0=/a 90=/c\)"),
        (settings(views=("0=/a",)), FACTS, "views"),
        (settings(output=OutputOptions(half=True)), FACTS, r"half \(was False, now True\)"),
        (settings(), {"inputs": {"0": "abc", "90": "other"}}, "the background of the view at 90 degrees"),
    ],
)
def test_a_run_is_continued_only_as_it_was_begun(run, changed, facts, words):
    """Everything the volumes depend on must be the same; the message names what is not, and nothing is touched."""
    before = {path.name: path.read_bytes() for path in run.folder.iterdir()}
    with pytest.raises(ValueError, match=words) as error:
        run.begin(changed, facts, resume=True)
    assert "--overwrite, or another folder with -o" in str(error.value)
    assert {path.name: path.read_bytes() for path in run.folder.iterdir()} == before


def lack(run, *lines):
    """Take options out of ``run.toml``, as an earlier version wrote it."""
    text = (run.folder / "run.toml").read_text()
    for line in lines:
        assert f"\n{line}\n" in text
        text = text.replace(f"\n{line}\n", "\n")
    (run.folder / "run.toml").write_text(text.split("\n", 1)[1])  # without the checksum


def test_runs_of_earlier_versions_go_on(run):
    """An option that was not there yet was what the version did; only another choice is refused."""
    lack(run, 'highpass = "parted"', 'transfer = "histograms"', 'align = "none"')
    with pytest.raises(ValueError, match=r"else: highpass \(was whole, now parted\);"):
        run.begin(settings(), FACTS, resume=True)
    with pytest.raises(ValueError, match=r"else: transfer \(was histograms, now texture-optimization\);"):
        run.begin(settings(highpass="whole", transfer="texture-optimization"), FACTS, resume=True)
    assert list(run.begin(settings(highpass="whole"), FACTS, resume=True)) == [1001, 1002]
    assert run.settings()["reconstruct"]["highpass"] == "whole"


def test_simulations_of_earlier_versions(tmp_path):
    """The same, by the settings that are read again; what is None is in no table, of whatever version."""
    made = SimulateSettings(
        source=None, size=(16, 24), simulate=SimulateOptions(), output=OutputOptions(), scene=Scene()
    ).to_dict()
    old = made | {"simulate": dict(made["simulate"]), "made-with": {}}
    for name in ("detail", "blend_apart", "liquid_surface"):
        del old["simulate"][name]
    (tmp_path / "run.toml").write_text(tomli_w.dumps(old))
    old = read_settings(tmp_path / "run.toml")
    check_same(tmp_path, old, made | {"simulate": made["simulate"] | {"blend_apart": 1.0, "liquid_surface": 0.0}})
    with pytest.raises(ValueError, match=r"blend-apart \(was 1.0, now 2.0\), liquid-surface \(was 0.0, now 1.0\);"):
        check_same(tmp_path, old, made)
    with pytest.raises(ValueError, match=r"fidelity \(was None, now 0.5\)"):
        check_same(tmp_path, old, made | {"simulate": made["simulate"] | {"fidelity": 0.5}})


def test_what_may_change(run):
    """The look of film and report, and the angle's spelling, are free."""
    other = settings(views=("0.0=/a", "90=/x/../b"), output=OutputOptions(look="smoke", report=False))
    assert len(run.begin(other, FACTS, resume=True)) == 2


def test_parts_of_a_run_add_up(tmp_path):
    """Frames asked for in parts are noted together, so that run.toml repeats all of them."""
    run = Run(tmp_path)
    for frames, together in (("1-3", "1-3"), ("7,9", "1-3,7,9"), ("3-5", "1-5,7,9"), (None, None)):
        part = dataclasses.replace(settings(), input=InputOptions(frames=frames))
        run.begin(part, FACTS, resume=True)
        assert run.settings()["input"].get("frames") == together


def test_missing_and_damaged_volumes_are_made_again(run):
    """Their records go; the others stay as they are."""
    run.write_frame(1003, DENSITY, OutputOptions(), {})
    run.volume_path(1001).unlink()
    whole = run.volume_path(1003).read_bytes()
    run.volume_path(1003).write_bytes(whole[:200] + bytes([whole[200] ^ 1]) + whole[201:])
    assert list(run.begin(settings(), FACTS, resume=True)) == [1002]
    assert numbers(run.folder) == [1002]
    run.volume_path(1002).write_bytes(run.volume_path(1003).read_bytes()[:-5])
    assert run.begin(settings(), FACTS, resume=True) == {}
    assert not run.is_whole(5)


@given(st.data())
def test_no_flipped_bit_goes_unseen(tmp_path_factory, data):
    """Wherever a bit of a volume flips, the frame counts as missing."""
    run = Run(tmp_path_factory.mktemp("run"))
    run.write_frame(1, DENSITY, OutputOptions(), {})
    path = run.volume_path(1)
    whole = bytearray(path.read_bytes())
    assert run.is_whole(1)
    place, bit = data.draw(st.integers(0, len(whole) - 1)), data.draw(st.integers(0, 7))
    whole[place] ^= 1 << bit
    path.write_bytes(whole)
    assert not run.is_whole(1)


@examples(max_examples=25)
@given(st.integers(0, 300))
def test_records_after_half_a_line(tmp_path_factory, length):
    """Wherever the records were cut off, the next one stands on a line of its own."""
    run = Run(tmp_path_factory.mktemp("run"))
    for frame in (1, 2, 3):
        run.write_frame(frame, DENSITY, OutputOptions(), {"note": "é"})
    path = run.folder / "frames.jsonl"
    lines = path.read_bytes()
    path.write_bytes(lines[:length])
    ends = np.cumsum([len(line) for line in lines.splitlines(keepends=True)])
    whole = [frame for frame, end in zip((1, 2, 3), ends, strict=True) if end - 1 <= length]  # the end of line may lack
    assert list(run.records()) == whole
    record = run.write_frame(4, DENSITY, OutputOptions(), {})
    assert list(run.records()) == [*whole, 4]
    assert read_lines(path)[-1] == record


def test_strange_lines_are_no_records(run):
    """Lines that are no record of ours are passed over and dropped when the run goes on."""
    with (run.folder / "frames.jsonl").open("ab") as file:
        file.write(b'[]\n{"frame": "x"}\nnull\n\xff\xfe\n{"frame": 1002, "seconds": 2.0}\n{"fra')
    assert list(run.records()) == [1001, 1002]
    assert run.records()[1002]["seconds"] == 2.0
    run.begin(settings(), FACTS, resume=True)
    assert numbers(run.folder) == [1001, 1002]


def test_leftovers_of_a_killed_run_go(run):
    """A half-written file of a process that is no more is removed when its frame is made, or the run goes on."""
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        process.wait()
    left = run.folder / f".density.1003.vdb.{process.pid}@{platform.node()}.tmp"
    left.write_bytes(b"half")
    run.write_frame(1003, DENSITY, OutputOptions(), {})
    assert not left.exists()
    left.write_bytes(b"half")
    run.begin(settings(), FACTS, resume=True)
    assert not left.exists()


def test_what_another_process_writes_stays(run):
    """A worker that was given up as gone may live, and write the same frame."""
    writing = [run.folder / f".density.1003.vdb.{who}.tmp" for who in (f"{os.getppid()}@{platform.node()}", "1@other")]
    for path in writing:
        path.write_bytes(b"half")
    run.write_frame(1003, DENSITY, OutputOptions(), {})
    run.begin(settings(), FACTS, resume=True)
    assert sorted(run.folder.glob(".*")) == sorted(writing)


def test_empty_volumes(run):
    """A frame before the fire begins is a frame, too."""
    run.write_frame(1, DENSITY * 0, OutputOptions(), {})
    np.testing.assert_array_equal(run.volume(1), DENSITY * 0)
    assert run.is_whole(1)


def test_numbers_that_json_lacks_are_refused(run):
    """Records hold no NaN, which other programs cannot read; the frame then counts as missing."""
    with pytest.raises(ValueError, match="JSON"):
        run.write_frame(7, DENSITY, OutputOptions(), {"energies": [[float("nan"), 1.0]]})
    assert 7 not in run.records()


def test_settings_repeat_exactly(run):
    """run.toml holds every option that is not left open."""
    document = tomllib.loads((run.folder / "run.toml").read_text())
    assert ReconstructOptions(**document["reconstruct"]) == ReconstructOptions()
    assert InputOptions(**document["input"]) == InputOptions()
    assert OutputOptions(**document["output"]) == OutputOptions()


def test_a_volume_that_is_not_finite_leaves_nothing(run):
    """Neither a file nor a record."""
    with pytest.raises(ValueError, match="not finite"):
        run.write_frame(1003, DENSITY * np.inf, OutputOptions(), {"seconds": 1.0})
    assert numbers(run.folder) == [1001, 1002]
    assert 1003 not in run.records()


def test_overwriting_clears_strays(run):
    """Volumes and records of a run whose settings are gone do not join the new one."""
    (run.folder / "run.toml").unlink()
    assert run.begin(settings(), FACTS, overwrite=True) == {}
    assert not list(run.folder.glob("*.vdb"))
    assert run.records() == {}


def test_negative_density_is_kept(run):
    """Dropping is by size."""
    output = OutputOptions(drop_below=0.1)
    run.write_frame(1003, np.where(DENSITY > 0.5, -DENSITY, DENSITY), output, {"seconds": 1.0})
    assert run.volume(1003).min() == pytest.approx(-DENSITY.max())
