"""The report: sound HTML, all in one file, nothing from strangers executed, every picture whole."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sound import Page

from warpfluid.report import html
from warpfluid.report.data import FrameReport, InputReport, ReportData, SeriesReport
from warpfluid.report.page import html_report, write_report

EVIL = """<script>alert("1")</script>' onerror="x" & $body"""


def pictures(*shape, seed=0):
    return np.random.default_rng(seed).integers(0, 256, shape).astype(np.uint8)


def full_report(name="fire"):
    """A report that has everything, with one name in all places that come from outside."""
    numbers = {"patch_swd": 0.21, "band_w1": 0.5, "input_psnr": 30.0, "gradient_ratio": 0.6, "unknown": 1.0}
    better = {"patch_swd": 0.04, "band_w1": 0.1, "input_psnr": 68.0, "gradient_ratio": 1.1}
    frame = FrameReport(
        number=1008,
        angles_deg=[0, 45, 90],
        stills={"LSM": pictures(3, 6, 5, 3), name: pictures(3, 6, 5, 3, seed=1)},
        slices={name: pictures(5, 11, 3)},
        slices_white=2.0,
        fields={f"{name}, 0 to 2": pictures(6, 5, 3)},
        energies=np.array([[4e6, 2e6], [3e6, 1e6]]),
        metrics={"LSM": numbers, name: better, "nearby": {"patch_swd": 0.01}},
        seconds=3.21,
    )
    return ReportData(
        title=name,
        subtitle=name,
        inputs=[InputReport(name=name, angle_deg=90, picture=pictures(6, 5))],
        warnings=[name],
        check=[name],
        check_table=[{"view": name, "shift": -0.5}, {"view": "side", "shift": None}],
        frames=[frame],
        metrics={name: better},
        metrics_note=name,
        yardsticks=["nearby"],
        series=[SeriesReport(title=name, values={name: {1: 2.0, 2: 3.0}, "b": {1: 2.5, 2: 2.0}}, unit=name)],
        facts={name: [{"thing": name, "number": 2}]},
        origin=name,
        turntable=pictures(4, 6, 5, 3),
        options={"blur": 0.4, name: name, "angles": 180},
        defaults={"blur": 0.4, name: "x", "angles": None},
        versions={name: name},
        timings={name: 2.0, "rest": 0.5},
    )


@pytest.mark.parametrize("report", [full_report(), ReportData(title="nothing")], ids=["full", "empty"])
def test_pages_are_sound_and_need_nothing(tmp_path, report):
    """Tags balance, there is no script, and nothing is fetched."""
    write_report(tmp_path / "report.html", report)
    text = (tmp_path / "report.html").read_text("utf-8")
    page = Page(text)
    assert not re.search(r"https?://|url\(|@import|//cdn", text)
    tags = {tag for tag, _ in page.tags}
    assert not tags & {"script", "link", "iframe", "object"}
    assert all(attrs["src"].startswith("data:") for tag, attrs in page.tags if "src" in attrs)
    assert [path.name for path in tmp_path.iterdir()] == ["report.html"]


def test_names_are_only_text():
    """Names that look like HTML or like placeholders show as they are, and make no tag or attribute."""
    evil, tame = Page(html_report(full_report(EVIL))), Page(html_report(full_report("tame")))
    assert [(tag, set(attrs)) for tag, attrs in evil.tags] == [(tag, set(attrs)) for tag, attrs in tame.tags]
    assert sum(EVIL in words for words in evil.words) == sum("tame" in words for words in tame.words) > 10


@settings(max_examples=20, deadline=None)
@given(st.text(max_size=30))
def test_any_name_keeps_the_page_sound(name):
    """No text unbalances the page."""
    Page(html_report(full_report(name or "x")))


def test_pictures_are_whole():
    """Every picture decodes to the pixels that went in, and the film has all its pictures."""
    report = full_report()
    shown = Page(html_report(report)).images()
    frame = report.frames[0]
    np.testing.assert_array_equal(shown["input at 90°"][0], report.inputs[0].picture)
    for name, stills in frame.stills.items():
        for angle, still in zip(frame.angles_deg, stills, strict=True):
            np.testing.assert_array_equal(shown[f"{name} at {angle}°"][0], still)
    np.testing.assert_array_equal(shown["horizontal slices, fire"][0], frame.slices["fire"])
    assert len(shown["turntable of the result"]) == 4
    assert len(shown) == 1 + 6 + 1 + 1 + 1


def test_the_best_method_is_marked_but_not_by_what_is_tuned():
    """Independent numbers mark a winner; tuned ones, yardsticks and unknown ones do not."""
    text = html_report(full_report())
    rows = {
        row.split("</td>")[0].split(">")[-1]: re.findall(r'class="number( best| floor)?">([^<]+)', row)
        for row in text.split("<h3>Quality</h3>")[1].split("</table>")[0].split("<tr>")[2:]
    }
    assert rows["Patch SWD"] == [("", "0.210"), (" best", "0.040"), (" floor", "0.010")]
    assert rows["Sub-band W1*"] == [("", "0.500"), ("", "0.100"), (" floor", "–")]
    assert rows["Gradient ratio"] == [("", "0.600"), (" best", "1.100"), (" floor", "–")]
    assert rows["PSNR, given views [dB]"] == [("", "30.0"), (" best", "68.0"), (" floor", "–")]
    assert len(rows) == 4


def test_changed_options_come_first():
    """What differs from its default is marked, the rest is folded away."""
    top, rest = html_report(full_report()).split("<h2>Options</h2>")[1].split("<details>")
    assert re.findall(r'class="changed"><td>([^<]+)', top) == ["fire", "angles"]
    assert "default None" in top
    assert re.findall(r'class="plain"><td>([^<]+)', rest) == ["blur"]


def test_tables_scroll_on_narrow_screens():
    """Every table lies in a box that scrolls, so that none is cut off."""
    text = html_report(full_report())
    assert text.count("<table") == text.count('<div class="scroll"><table') > 5


@pytest.mark.parametrize("length", [20, 60, 61, 300])
def test_long_paths_are_shortened_in_the_middle(length):
    """Head and tail stay, the whole path shows on hovering, and what is short stays as it is."""
    path = "/shots/" + "x" * (length - 16) + "/fire.mp4"
    page = Page(
        html_report(ReportData(title="t", inputs=[InputReport(name=path, angle_deg=0, picture=pictures(4, 4))]))
    )
    (shown,) = [words for words in page.words if words.endswith("fire.mp4")]
    titles = [attrs["title"] for tag, attrs in page.tags if tag == "span" and "title" in attrs]
    if length <= 60:
        assert (shown.strip(), titles) == (path, [])
    else:
        assert (len(shown), titles) == (60, [path])
        assert shown.startswith("/shots/x")
        assert "…" in shown


def test_input_angles_are_marked_and_the_total_is_added_up():
    """Stills at an input's angle say so, and the stages add up."""
    text = html_report(full_report())
    assert re.findall(r'class="angle">([^/]+)</', text) == ["0°", "45°", "90° <b>input"]
    assert "<b>2.5 s</b>" in text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        *[(None, "–"), (np.nan, "–"), (7, "7"), ("<b>", "&lt;b&gt;"), (np.float32(0.5), "0.500")],
        *[(0.12345, "0.123"), (-3.0, "−3.000"), (68.82, "68.8"), (12345.6, "12346")],
    ],
)
def test_numbers_are_short(value, text):
    """Three digits where it matters, a dash for what is missing."""
    assert html.cell(value) == text


def test_wrong_pictures_are_refused(tmp_path):
    """Float pictures and missing stills are named, and no half page is left."""
    floats = ReportData(title="x", inputs=[InputReport(name="x", angle_deg=0, picture=np.ones((3, 3)))])
    with pytest.raises(ValueError, match="'input at 0°' is float64"):
        write_report(tmp_path / "report.html", floats)
    short = FrameReport(number=7, angles_deg=[0, 90], stills={"LSM": pictures(1, 4, 4)})
    with pytest.raises(ValueError, match="frame 7: LSM has 1 stills for 2 angles"):
        write_report(tmp_path / "report.html", ReportData(title="x", frames=[short]))
    assert not list(tmp_path.iterdir())
