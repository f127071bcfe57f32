"""The page of a simulated run: source, curves, scene, bodies, fields; and what it says where things are missing."""

import re
from pathlib import Path

import numpy as np
import pytest
from sound import Page
from tiny import BARE, flame, footage, quick, run

from warpfluid.files.npz import write_npz
from warpfluid.options import BodyOptions, EmitterOptions, ForceOptions, Scene, SimulateOptions
from warpfluid.report.course import departure, warnings
from warpfluid.report.fields import field_pictures, speed_of
from warpfluid.report.scene import body_rows, scene_rows
from warpfluid.run import Run
from warpfluid.settings import SimulateSettings
from warpfluid.volumes import open_volumes

PLAIN = ("--no-turntable", "--device", "cpu", "-q")
THINGS = (
    *("--emitter", "sphere center=0,2,0 radius=1.5 density=8 temperature=1"),
    *("--body", "box center=0,6,0 size=2,2,2", "--force", "wind direction=3,0,0"),
)


def text_of(folder: Path) -> str:
    """Return the page of a run, sound and without anything from elsewhere."""
    text = (folder / "report.html").read_text("utf-8")
    page = Page(text)
    assert not re.search(r"https?://|url\(|@import|<script", text)
    assert all(attrs["src"].startswith("data:") for tag, attrs in page.tags if "src" in attrs)
    return text


@pytest.fixture(scope="module")
def fire(tmp_path_factory) -> Path:
    """A reconstruction of three frames of 32 x 28 pixels."""

    folder = tmp_path_factory.mktemp("fire")
    big = lambda frame, angle: flame(frame, angle, width=32, height=28)  # noqa: E731
    flags = []
    for k, name in enumerate(("front", "side")):
        flags += [f"--{name}", footage(folder / name, make=big, angle=k)]
    assert run("reconstruct", *quick(*flags, *BARE, "-q"), "-o", folder / "run") == 0
    return folder / "run"


@pytest.fixture(scope="module")
def box(tmp_path_factory) -> Path:
    """A box with an emitter, wind and a body, five frames."""
    folder = tmp_path_factory.mktemp("box") / "run"
    assert run("simulate", "--size", "16x20", *THINGS, "--frames", "1-5", *PLAIN, "-o", folder) == 0
    return folder


def test_a_run_that_follows_footage(tmp_path, fire):
    """Its page has the footage, the source beside the result, floors, curves, and the options that were changed."""
    out = tmp_path / "out<b>"
    assert run("simulate", fire, *PLAIN, "--report", "--swirl", "2", "-o", out) == 0
    text = text_of(out)
    assert "<h1>out&lt;b&gt;</h1>" in text
    assert "<h2>Footage</h2>" in text
    assert f"It follows {fire}." in text
    assert re.findall(r'<div class="row">(\w+)<', text)[:2] == ["source", "simulated"]
    for words in ("footage, other view", "Patch SWD", "Left by motion", "Total density", "Solver steps a frame"):
        assert words in text
    assert "How exactly the views of the source come back" in text
    changed = dict(re.findall(r'class="changed"><td>([\w-]+)</td><td class="mono">([^<]+)', text))
    assert changed["swirl"] == "2.0"
    assert "flow" not in changed
    assert "no number is marked as the best" in text
    assert 'class="number best"' not in text
    assert re.search(r"At frame 3, \d+% of the light is elsewhere .*; for more of the edit: --fidelity 0\.05;", text)
    assert set(Page(text).images()) >= {"input at 0°", "input at 90°", "turntable of the result"}


def test_an_empty_box(box):
    """No source and no numbers of likeness, but scene, bodies, fields and curves."""
    text = text_of(box)
    assert "It starts from an empty box and follows nothing." in text
    assert "Patch SWD" not in text
    for words in ("<h2>Scene</h2>", "<h2>Rigid bodies</h2>", "Speed of the fluid", "center=0,2,0", "body1"):
        assert words in text
    names = [name.split(",")[0] for name in Page(text).images() if ", 0 to " in name]
    assert {"temperature", "speed"} <= set(names)


def test_footage_that_is_gone(tmp_path, fire):
    """The page says so and shows the source's own views instead."""
    gone = tmp_path / "gone"
    gone.mkdir()
    for path in fire.iterdir():
        (gone / path.name).write_bytes(path.read_bytes())
    toml = gone / "run.toml"
    toml.write_text(toml.read_text().replace("/side", "/lost"))
    assert run("simulate", gone, *PLAIN, "--report", "-o", tmp_path / "out") == 0
    text = text_of(tmp_path / "out")
    assert "The footage is not to be had" in text
    assert "<h2>Source</h2>" in text
    assert "input at 90°" in Page(text).images()


def test_volumes_in_another_unit(tmp_path):
    """Their pictures are as bright as if they had grey levels."""
    x, y, z = np.ogrid[:16, :20, :16]
    blob = np.exp(-((x - 7.5) ** 2 + (y - 8) ** 2 + (z - 7.5) ** 2) / 12).astype(np.float32)
    for frame in (1, 2):
        write_npz(tmp_path / f"a.{frame}.npz", 1e-4 * blob)
    assert run("simulate", tmp_path / "a.#.npz", *PLAIN, "-o", tmp_path / "out") == 0
    shown = Page(text_of(tmp_path / "out")).images()
    for name in ("simulated at 0°", "source at 0°", "turntable of the result"):
        assert shown[name][0].max() > 200


def test_no_report(tmp_path):
    """Nothing is written where none is wanted."""
    flags = ("--size", "12x16", *THINGS[:2], "--frames", "1-2", "--no-report", *PLAIN)
    assert run("simulate", *flags, "-o", tmp_path / "out") == 0
    assert not (tmp_path / "out" / "report.html").exists()


def test_what_stands_in_the_box(box):
    """A row a thing with what is not as usual; of bodies where they were first and last."""
    scene = Scene(emitter=(EmitterOptions(shape="box", fuel=2.0),), force=(ForceOptions(kind="wind"),))
    rows = scene_rows(scene)
    assert rows[0] == {"thing": "emitter", "shape": "box", "choices": "fuel=2.0"}
    assert rows[1] == {"thing": "force", "shape": "wind", "choices": "as usual"}
    (row,) = body_rows(Run(box), [BodyOptions()])
    assert row["body"] == "body1"
    assert row["at frame 1 (x, y, z)"].split(", ")[0] == "0.00"
    assert row["fastest [unit/s]"] > 0
    assert body_rows(Run(box), []) == []


def test_fields_and_speed(box):
    """Pictures of what there is, with the value of the last colour; the speed is that of the stored velocity."""
    volumes = open_volumes(box)
    pictures = field_pictures(volumes, 5, 24.0)
    assert [name.split(",")[0] for name in pictures] == ["temperature", "speed"]
    assert all(picture.shape == (20, 16, 3) for picture in pictures.values())
    assert field_pictures(volumes, 1, 24.0) == {}
    found = volumes.fields(5, ("density", "velocity"))
    length = np.sqrt((found["velocity"] ** 2).sum(axis=3)) / 24
    lit = found["density"] > 0.01 * found["density"].max()
    mean, fast = speed_of(volumes, 5, 24.0)
    assert mean == pytest.approx((length * found["density"])[lit].sum() / found["density"][lit].sum(), rel=1e-4)
    assert mean < fast <= length[lit].max()
    assert speed_of(volumes, 1, 24.0) is None


def test_fluids_that_are_too_fast_are_told():
    """Where many frames needed all steps that were allowed; not where the user chose their number."""
    records = {frame: {"steps": 8 if frame > 2 else 1} for frame in range(1, 7)}
    (told,) = warnings(records, SimulateOptions())
    assert told.startswith("4 of 6 frames needed all 8 solver steps")
    assert "--max-substeps" in told
    assert warnings(records, SimulateOptions(substeps=8)) == []
    assert warnings(records, SimulateOptions(max_substeps=16)) == []


@pytest.mark.parametrize(
    ("fidelity", "ways"),
    [
        (None, "0.3; for more of the edit: --fidelity 0.05; for more of the footage: --fidelity 1."),
        (0.1, "0.1; for more of the edit: --fidelity 0.05; for more of the footage: --fidelity 0.3."),
        (0.05, "0.05; for more of the edit: --fidelity 0; for more of the footage: --fidelity 0.3."),
        (0.0, "0; for more of the footage: --fidelity 0.05."),
        (1.0, "1; for more of the edit: --fidelity 0.3."),
    ],
)
def test_a_note_names_what_to_type(fidelity, ways):
    """The next step either way, and none where there is no farther one."""
    settings = SimulateSettings(
        source="fire", size=None, simulate=SimulateOptions(swirl=2.0, fidelity=fidelity), scene=Scene(), output=None
    )
    (note,) = departure({1: {"elsewhere": 0.0}, 2: {"elsewhere": 0.25}}, settings)
    assert note == f"At frame 2, 25% of the light is elsewhere than in the source; fidelity is {ways}"
