"""Film and sheet: every frame at its angle, names in letters below, short names for narrow columns."""

import numpy as np
import pytest
from PIL import Image, ImageDraw
from plumes import HEIGHT, WIDTH, blurred, entries, plume, write
from tiny import BARE, run

from warpfluid.comparison import film
from warpfluid.comparison.film import film_pictures, fitted, lettered, write_film, write_sheet
from warpfluid.rendering.turntable import GAP, render_turntable


@pytest.fixture
def two(tmp_path):
    """A plume and its blur, three frames."""
    return entries(
        write(tmp_path / "sharp", plume, range(1, 4)),
        write(tmp_path / "soft", lambda f: blurred(plume(f)), range(1, 4)),
    )


def test_pictures_of_the_film(two):
    """Picture i shows frame i % n from i steps on, each in its column; below are letters."""
    pictures = list(film_pictures(two, [1, 2, 3], "fire", 30.0, 90.0))
    assert len(pictures) == 4
    for i, picture in enumerate(pictures):
        for column, entry in enumerate(two):
            left = column * (2 * WIDTH + GAP)
            shown = picture[: 2 * HEIGHT, left : left + 2 * WIDTH]
            wanted = render_turntable(entry.volume((1, 2, 3)[i % 3]), [30 + 90 * i], "fire")[0]
            assert np.abs(shown.astype(int) - wanted).max() <= 2
            assert picture[2 * HEIGHT :, left : left + 2 * WIDTH].max() > 200


@pytest.mark.parametrize(("frames", "step", "count"), [([1, 2, 3], 0, 72), ([1], 0, 72), ([1, 2, 3], 180, 3)])
def test_length(two, frames, step, count):
    """A camera that stands still shows whole repeats; a turn that is shorter than the sequence shows all of it."""
    assert sum(1 for _ in film_pictures(two, frames, "fire", 0, step)) == count


@pytest.mark.parametrize("ending", ["webp", "gif", "mp4"])
def test_films_decode(tmp_path, two, ending):
    """The file has all pictures in their order."""
    path = tmp_path / f"film.{ending}"
    write_film(path, two, [1, 2, 3], fps=12, step_deg=60)
    made = list(film_pictures(two, [1, 2, 3], "fire", 0, 60))
    if ending == "mp4":
        import av

        with av.open(path) as container:
            shown = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
    else:
        with Image.open(path) as file:
            shown = []
            for i in range(file.n_frames):
                file.seek(i)
                shown.append(np.asarray(file.convert("RGB")))
    assert len(shown) == len(made) == 6
    for a, b in zip(shown, made, strict=True):
        assert np.abs(a[: b.shape[0], : b.shape[1]].astype(int) - b).mean() < 8


def test_sheet(tmp_path, two):
    """A row an entry, a column a frame and angle."""
    write_sheet(tmp_path / "sheet.png", two, [1, 2, 3], [0, 45], look="fire")
    with Image.open(tmp_path / "sheet.png") as picture:
        sheet = np.asarray(picture)
    columns = 6
    assert sheet.shape[1] == columns * 2 * WIDTH + (columns - 1) * GAP
    top = 2 * HEIGHT + GAP
    still = render_turntable(two[1].volume(1), [45], "fire")[0]
    shown = sheet[top + 30 : top + 2 * HEIGHT, 2 * WIDTH + GAP : 4 * WIDTH + GAP]
    np.testing.assert_array_equal(shown, still[30:])


def test_what_stands_in_a_simulation_is_drawn(tmp_path):
    """In the sheet and in the film, as its own turntable has it, and not as a hole."""
    folder = tmp_path / "run"
    box = ("--size", "16x24", "--emitter", "sphere center=0,2,0 radius=1.5 density=8", "--frames", "1-2", "-q")
    post = ("--obstacle", "box center=2,2,0 size=2,2,2", "--body", "box center=-2,3,0 size=2,2,2 weight=2")
    assert run("simulate", *box, *post, *BARE, "--device", "cpu", "-o", folder) == 0
    (entry,) = entries(str(folder))
    assert len(entry.surfaces(2)) == 2
    with_them = render_turntable(entry.volume(2), [30], "fire", surfaces=entry.surfaces(2))[0]
    bare = render_turntable(entry.volume(2), [30], "fire")[0]
    (film,) = list(film_pictures([entry], [2], "fire", 30.0, 360.0))
    write_sheet(tmp_path / "sheet.png", [entry], [2], [30], look="fire")
    with Image.open(tmp_path / "sheet.png") as picture:
        sheet = np.asarray(picture)
    for shown in (film, sheet):
        np.testing.assert_array_equal(shown[30 : len(bare)], with_them[30:])
        assert np.abs(shown[30 : len(bare)].astype(int) - bare[30:]).max() > 60


def test_names_fit():
    """What is too long loses its middle; the letters stay inside of their column."""
    draw = ImageDraw.Draw(Image.new("RGB", (10, 10)))
    assert fitted(draw, "fire", 200) == "fire"
    short = fitted(draw, "a-very-long-name-of-a-run-0042", 100)
    assert short.startswith("a-v")
    assert short.endswith("042")
    assert ".." in short
    assert draw.textlength(short, font_size=film.NAME) <= 92
    row = np.zeros((20, 2 * 64 + GAP, 3), np.uint8)
    below = lettered(row, ["a-very-long-name-of-a-run-0042", ""])[20:]
    assert below[:, :64].max() > 200
    assert (below[:, 64:] == below[0, -1]).all()
