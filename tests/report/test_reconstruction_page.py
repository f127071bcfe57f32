"""The page of a reconstruction: footage, check, least squares beside the result, floors, curves."""

import re

import pytest
from sound import Page
from tiny import flame, footage, quick, run


@pytest.fixture(scope="module")
def page(tmp_path_factory) -> str:
    """The page of four frames of 32 x 28 pixels."""
    folder, flags = tmp_path_factory.mktemp("fire"), []
    for k, name in enumerate(("front", "side")):
        make = lambda frame, angle: flame(frame, angle, width=32, height=28)  # noqa: E731
        flags += [f"--{name}", footage(folder / name, range(1, 5), make=make, angle=k)]
    assert run("reconstruct", *quick(*flags, "--no-turntable", "-q"), "-o", folder / "run") == 0
    return (folder / "run" / "report.html").read_text("utf-8")


def test_it_needs_nothing(page):
    """Sound, in one file, with the film in it."""
    tags = Page(page).tags
    assert all(attrs["src"].startswith("data:") for tag, attrs in tags if "src" in attrs)
    assert len(Page(page).images()["turntable of the result"]) == 60


def test_methods_stand_beside_each_other(page):
    """Stills, slices and numbers of both; the floors after them, and no number of a floor is the best."""
    assert re.findall(r'<div class="row">([\w ]+)<', page)[:2] == ["least squares", "appearance transfer"]
    table = page.split("<h2>Quality")[1].split("</table>")[0]
    heads = re.findall(r"<th[^>]*>([^<]*)</th>", table)
    assert heads[2:] == ["least squares", "appearance transfer", "footage, other view", "footage, other frame"]
    (row,) = [row for row in table.split("<tr>") if "Patch SWD" in row]
    assert re.findall(r"number( best| floor)?", row)[2:] == [" floor", " floor"]
    assert re.search(r"<small>[\d.]+×</small>", row)
    assert "Left by motion" in table


def test_curves_and_motion(page):
    """What happened over the frames, and how fast each view moves."""
    for title in ("How exactly the inputs come back", "Total density", "Time a frame took"):
        assert f"<h3>{title}</h3>" in page
    assert len(re.findall(r"<svg ", page)) >= 4
    assert re.findall(r"[\d.]+, fastest [\d.]+", page)
