"""Every example runs as it is, without a warning, and leaves its pictures in the folder it is given."""

import runpy
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

EXAMPLES = Path(__file__).parents[1] / "examples"
SCRIPTS = sorted(path.name for path in EXAMPLES.glob("[0-9]*.py"))


@pytest.fixture
def run(monkeypatch, tmp_path):
    """Run an example with a folder for its pictures, as if it were started from a shell."""

    def run_script(name: str) -> Path:
        monkeypatch.setattr(sys, "argv", [name, str(tmp_path)])
        monkeypatch.syspath_prepend(str(EXAMPLES))
        monkeypatch.delitem(sys.modules, "gallery", raising=False)  # it remembers the folder
        runpy.run_path(str(EXAMPLES / name), run_name="__main__")
        return tmp_path

    return run_script


@pytest.mark.parametrize("name", SCRIPTS)
def test_example_leaves_pictures(run, capsys, name):
    """A numbered example writes what it says it wrote, and its pictures show something."""
    folder = run(name)
    written = [Path(line.split()[1].rstrip(":")) for line in capsys.readouterr().out.splitlines() if "wrote" in line]
    assert written
    assert all(path.exists() for path in written)
    for path in folder.glob("*.png"):
        assert np.ptp(np.asarray(Image.open(path))) > 50


def test_examples_are_numbered():
    """The gallery is read in order, without a gap."""
    assert [int(name[:2]) for name in SCRIPTS] == list(range(1, len(SCRIPTS) + 1))


def test_picture_of_the_axes(run):
    """The picture of docs/conventions.md can be drawn anywhere."""
    with Image.open(run("draw_conventions.py") / "conventions.png") as picture:
        assert picture.size == (1160, 520)


def test_film_of_the_readme(run, monkeypatch):
    """The film is small enough for a page, repeats, and shows three panels of which two turn."""
    import warpfluid as wf

    few = wf.ReconstructOptions(iterations=1, angles=30)
    reconstruct = wf.reconstruct
    monkeypatch.setattr(wf, "reconstruct", lambda views: reconstruct(views, few), raising=False)
    path = run("draw_turntable.py") / "turntable.webp"
    assert path.stat().st_size < 700_000
    with Image.open(path) as film:
        assert film.n_frames == 72
        assert film.info["loop"] == 0
        first = np.asarray(film.convert("RGB")).astype(int)
        film.seek(9)  # 45 degrees
        later = np.asarray(film.convert("RGB")).astype(int)
    change = np.abs(later - first).mean(axis=(0, 2))
    panels = np.array_split(change, [first.shape[1] // 5, 3 * first.shape[1] // 5])
    assert panels[0].mean() < 1
    assert min(panels[1].mean(), panels[2].mean()) > 3
