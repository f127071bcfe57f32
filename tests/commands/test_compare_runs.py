"""The command compare: tables, files, what it finds by itself, and what it refuses."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from plumes import HEIGHT, WIDTH, blurred, plume, write
from tiny import BARE, footage, run

from warpfluid.commands.compare import farthest

PLAIN = ("--device", "cpu", "-q")
FEW = ("--measured-frames", "1", "--scored-angles", "45", *PLAIN)


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> dict[str, str]:
    """Volumes of other programs: the truth, a blur of it, half of its light."""
    folder = tmp_path_factory.mktemp("volumes")
    makes = {"truth": plume, "soft": lambda f: blurred(plume(f)), "half": lambda f: plume(f) / 2}
    return {name: write(folder / name, make) for name, make in makes.items()}


@pytest.fixture(scope="module")
def fire(tmp_path_factory) -> str:
    """A reconstruction of two views of the plume, two frames."""
    folder, views = tmp_path_factory.mktemp("fire"), []
    for angle, axis in ((0, 1), (90, 0)):
        picture = lambda frame, _, axis=axis: np.rint(plume(frame).sum(axis=axis).T[::-1]).clip(0, 255).astype(np.uint8)  # noqa: E731
        views += ["--view", f"{angle}={footage(folder / str(angle), range(1, 3), make=picture)}"]
    quick = ("--iterations", "1", "--angles", "12", "--lsm-steps", "4", *BARE)
    assert run("reconstruct", *views, *quick, *PLAIN, "-o", folder / "run") == 0
    return str(folder / "run")


@pytest.fixture
def refused(capsys):
    """Return a function that runs compare on bad input and returns its message."""

    def refuse(*arguments) -> str:
        assert run("compare", *arguments, *PLAIN) == 2
        printed = capsys.readouterr()
        assert printed.out == ""
        assert all(line.startswith("error: ") for line in printed.err.splitlines())
        return printed.err

    return refuse


def test_against_the_truth(made, capsys):
    """A table with floors; the blur is worse, the unit of a copy does not matter."""
    assert run("compare", made["half"], made["soft"], "--truth", made["truth"], *FEW, "--json") == 0
    data = json.loads(capsys.readouterr().out)
    assert data["against"] == "truth"
    assert data["frames"] == [1, 2, 3, 4]
    assert data["unseen_deg"] == [45]
    assert data["floors"] == ["truth +10°", "truth +20°", "truth, mirrored"]
    copy, soft = data["values"]["half"], data["values"]["soft"]
    assert copy["patch_swd"] == pytest.approx(0, abs=1e-4)
    assert copy["total"] == pytest.approx(1, abs=1e-3)
    assert soft["patch_swd"] > 2 * data["values"]["truth +20°"]["patch_swd"]
    assert "scaled to the same total light" in data["notes"][0]


def test_the_table(made, capsys):
    """In plain text: aims, floors, multiples of the yardstick, the best marked."""
    assert run("compare", made["half"], made["soft"], "--truth", made["truth"], *FEW) == 0
    lines = capsys.readouterr().out.splitlines()
    head = next(line for line in lines if "truth +20°" in line and "half" in line)
    assert head.split()[:2] == ["half", "soft"]
    swd = next(line for line in lines if line.startswith("Patch SWD"))
    assert "↓ 0  > 0.000 (0.0 x)" in swd
    assert any(line.startswith("(Sub-band W1)") and ">" not in line for line in lines)
    assert max(map(len, lines)) < 160


def test_the_footage_is_found(made, fire, tmp_path, capsys):
    """Of a run, and of a simulation that follows it."""
    sim = tmp_path / "sim"
    assert run("simulate", fire, *BARE, *PLAIN, "-o", sim) == 0
    capsys.readouterr()
    assert run("compare", fire, sim, *FEW, "--json") == 0
    data = json.loads(capsys.readouterr().out)
    assert data["against"] == "footage"
    assert data["given_deg"] == [0, 90]
    assert data["floors"] == ["footage, other view", "footage, other frame"]
    assert data["values"]["run"]["input_psnr"] > 25
    assert data["values"]["sim"].keys() == data["values"]["run"].keys()
    assert data["edited"] == []
    assert run("compare", sim, made["soft"], *FEW, "--json") == 0
    data = json.loads(capsys.readouterr().out)
    assert data["against"] == "footage"
    assert data["values"]["soft"]["total"] == pytest.approx(1, abs=0.02)


def test_an_edit_is_not_ranked(fire, made, tmp_path, capsys):
    """Beside footage that it is not meant to be; a truth is meant."""
    windy = tmp_path / "windy"
    assert run("simulate", fire, "--wind", "2,0,0", *BARE, *PLAIN, "-o", windy) == 0
    assert run("compare", fire, windy, *FEW) == 0
    text = capsys.readouterr().out
    assert "windy: edited, so not meant to be the footage; no number is marked as the best" in text
    assert " > " not in text
    assert run("compare", fire, windy, "--truth", made["truth"], *FEW) == 0
    assert " > " in capsys.readouterr().out


def test_footage_that_is_gone(fire, made, tmp_path, capsys):
    """The volumes are compared as far as they go, and it is said why."""
    text = (Path(fire) / "run.toml").read_text()
    gone = tmp_path / "gone"
    gone.mkdir()
    for path in Path(fire).iterdir():
        (gone / path.name).write_bytes(path.read_bytes())
    (gone / "run.toml").write_text(text.replace("/90", "/lost"))
    assert run("compare", gone, made["soft"], *FEW, "--json") == 0
    data = json.loads(capsys.readouterr().out)
    assert data["against"] == "nothing"
    assert data["values"]["gone"].keys() == {"grid_index"}
    assert any("the footage of gone cannot be opened" in note and "lost" in note for note in data["notes"])


def test_film_and_sheet(made, tmp_path):
    """Both in one go."""
    film, sheet = tmp_path / "film.webp", tmp_path / "sheet.png"
    files = ("-o", film, "-o", sheet, "--turn-step", "90", "--frames", "1-2", "--look", "smoke")
    assert run("compare", made["half"], made["soft"], *files, *FEW) == 0
    with Image.open(film) as pictures:
        assert pictures.n_frames == 4
        assert pictures.size[0] == 2 * 2 * WIDTH + 4
    with Image.open(sheet) as stills:
        assert stills.size[1] > 2 * 2 * HEIGHT


def test_the_sheet_shows_what_is_farthest_from_the_footage():
    """Half-way between the views, also across half a turn."""
    around = range(0, 180, 15)
    assert farthest(around, [0, 90]) == 45
    assert farthest(around, [35, -52]) == 75
    assert farthest(around, [180]) == 90


def test_what_cannot_be_compared(made, tmp_path, refused):
    """Each is named with the way out, before any work."""
    small = write(tmp_path / "small", lambda frame: plume(frame)[8:-8, 8:-8])
    slim = write(tmp_path / "slim", lambda frame: plume(frame)[8:-8, 8:-8])
    later = write(tmp_path / "later", plume, [7])
    assert "nothing to compare it with: name another run, or the truth with --truth" in refused(made["soft"])
    assert f"unlike boxes (small 16 x {HEIGHT} x 16, soft {WIDTH} x {HEIGHT}" in refused(small, made["soft"])
    assert "no frame in common (soft has 1-4, later has 7)" in refused(made["soft"], later)
    assert "frame 9 is not in all of them" in refused(made["soft"], made["half"], "--frames", "9")
    assert "the numbers need at least 25 a side" in refused(small, slim)
    assert "nothing does not exist" in refused(made["soft"], tmp_path / "nothing")
    two = (made["soft"], made["half"])
    assert "film.avi ends in '.avi': films are .mp4, .webp, .gif, a sheet is .png" in refused(*two, "-o", "film.avi")
    assert "is no folder" in refused(*two, "-o", tmp_path / "none" / "film.mp4")
    assert "scored-angles is 'left', expected degrees such as 30,45,60" in refused(*two, "--scored-angles", "left")
    assert "measured-frames is 0, expected 1 to 1000" in refused(*two, "--measured-frames", "0")
