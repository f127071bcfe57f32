"""Views aligned when their frames are read: found from row sums or given by hand, the same bits either way."""

import json

import numpy as np
import pytest
from tiny import BARE, quick, run, volumes

from warpfluid.files.images import write_png
from warpfluid.footage.inspection import inspect_shot
from warpfluid.footage.shot import open_shot
from warpfluid.footage.tone import apply_shoulder, undo_shoulder
from warpfluid.options import InputOptions
from warpfluid.run import Run

ROWS, COLUMNS = 48, 32
OFF = {"time": 2, "shift": 3.0, "scale": 1.0, "gain": 1.25}  # what puts the side right


def light(frame, rows, base=500):
    """Light in each row: puffs that rise over a base that flickers."""
    rng = np.random.default_rng(7)
    sums = base * np.exp(-(((rows - 12) / 6) ** 2)) * (1 + 0.2 * np.sin(1.7 * frame))
    for _ in range(9):
        start, speed, bright, wide = rng.uniform((-20, 0.7, 150, 2.5), (40, 2.5, 500, 5))
        sums = sums + bright * np.exp(-(((rows - start - speed * frame) / wide) ** 2))
    return sums


def picture(frame, angle=0, *, shift=0.0, gain=1.0, shoulder=0.0, fine=1, base=500):
    """Grey light, uint8 (rows, columns); all views have the same light in a row, up to what puts them right."""
    rows = (np.arange(ROWS * fine)[::-1] + 0.5) / fine - 0.5 + shift
    middle = COLUMNS / 2 + 4 * np.sin(0.2 * rows + angle + 0.3 * frame)
    columns = (np.arange(COLUMNS * fine) + 0.5) / fine
    bell = np.exp(-(((columns - middle[:, None]) / (3 + angle)) ** 2))
    grey = light(frame, rows, base)[:, None] * bell / bell.sum(axis=1, keepdims=True) / gain * 0.8
    return np.round(apply_shoulder(grey, shoulder)).clip(0, 255).astype(np.uint8)


def footage(folder, frames=range(1, 15), **how):
    """Write a picture a frame; return the folder's name."""
    folder.mkdir()
    later = how.pop("time", 0)
    for frame in frames:
        write_png(folder / f"fire.{frame:03d}.png", picture(frame + later, **how))
    return str(folder)


@pytest.fixture
def pair(tmp_path):
    """A front, and a side that runs early, sits low and is dim."""
    return off_pair(tmp_path)


def off_pair(folder, **how):
    """Write such a pair; return its views."""
    side = {key: value for key, value in OFF.items() if key != "scale"}
    return [f"0={footage(folder / 'front', **how)}", f"90={footage(folder / 'side', angle=2, **side, **how)}"]


def apart(shot):
    """Return the disagreement that the check of a shot finds."""
    return inspect_shot(shot).pairs[0].remedy.disagreement


def refusal(views, **options):
    """Return the message with which a shot is refused."""
    with pytest.raises(ValueError, match=r".") as error:
        open_shot(views, InputOptions(**options))
    return str(error.value)


def test_a_side_is_put_right(pair):
    """Time, height and light are found, told before and after, and applied when frames are read."""
    before = open_shot(pair, InputOptions(equalize_rows=False))
    shot = open_shot(pair, InputOptions(align="auto", equalize_rows=False))
    (found,) = shot.alignments
    assert found.alignment.time == 2
    assert found.alignment.shift == pytest.approx(3, abs=0.1)
    assert found.alignment.scale == 1
    assert found.alignment.gain == pytest.approx(1.25, abs=0.02)
    assert found.disagreement == pytest.approx(apart(before), abs=0.05)
    assert found.disagreement_after < 0.05
    assert shot.frames == tuple(range(3, 15))
    assert apart(shot) < 0.08 < 0.2 < apart(before)
    np.testing.assert_array_equal(shot.views(5).images[0], before.views(5).images[0])


def test_numbers_repeat_the_bits(tmp_path):
    """What was found and is then given by hand gives the very same images, and the files stay as they were."""
    pair = off_pair(tmp_path, base=0)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*.png")}
    shot = open_shot(pair, InputOptions(align="auto", background="median", align_subframe=True))
    assert shot.options.align == "none"
    again = open_shot(pair, shot.options)
    assert again.frames == shot.frames
    for frame in shot.frames:
        np.testing.assert_array_equal(again.views(frame).images, shot.views(frame).images)
    assert before == {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}


def test_aligned_views_stay_as_they_are(tmp_path):
    """Bit by bit."""
    views = [f"0={footage(tmp_path / 'front')}", f"90={footage(tmp_path / 'side', angle=2)}"]
    plain, aligned = open_shot(views), open_shot(views, InputOptions(align="auto", align_subframe=True))
    assert aligned.frames == plain.frames
    for frame in plain.frames:
        np.testing.assert_array_equal(aligned.views(frame).images, plain.views(frame).images)
    assert "view 90: as it is" in aligned.alignments[0].line()


def test_parts_of_frames_blend(pair):
    """Half a frame later is the mean of two pictures; only between pictures that are there."""
    plain = open_shot(pair, InputOptions(equalize_rows=False))
    half = open_shot(pair, InputOptions(equalize_rows=False, view_time="90=0.25"))
    assert half.frames == tuple(range(2, 15))
    expected = 0.25 * plain.views(5).images[1] + 0.75 * plain.views(6).images[1]
    np.testing.assert_allclose(half.views(6).images[1], expected, atol=1e-3)


def test_footage_on_twos(tmp_path):
    """By two frames it is the picture before, by one a blend."""
    views = [f"{a}={footage(tmp_path / str(a), range(1, 29, 2), angle=a)}" for a in (0, 90)]
    plain, later, between = (
        open_shot(views, InputOptions(equalize_rows=False, view_time=time)) for time in (None, "90=2", "90=1")
    )
    assert later.frames == between.frames == tuple(range(3, 28, 2))
    first, second = plain.views(5).images[1], plain.views(7).images[1]
    np.testing.assert_array_equal(later.views(7).images[1], first)
    np.testing.assert_allclose(between.views(7).images[1], (first + second) / 2, atol=1e-3)


def test_shifts_count_in_the_footage(tmp_path):
    """So that they hold at every resolution and crop."""
    front = footage(tmp_path / "front", fine=2)
    side = footage(tmp_path / "side", fine=2, angle=2, shift=2.0)
    views = [f"0={front}", f"90={side}"]
    for options in ({"resolution": "32"}, {"resolution": "32", "crop": "64x92+0+2"}, {}):
        (found,) = open_shot(views, InputOptions(align="auto", **options)).alignments
        assert found.alignment.shift == pytest.approx(4, abs=0.25)
    low, high = (
        open_shot(views, InputOptions(resolution="32", view_shift=s, equalize_rows=False)) for s in (None, "90=4")
    )
    lifted, plain = high.views(5).images[1][:, 2:], low.views(5).images[1][:, :-2]
    assert np.abs(lifted - plain).sum() < 0.01 * plain.sum()


def test_light_is_scaled_behind_the_tone_curve(tmp_path):
    """Gains and equal rows are those of linear light."""
    front = footage(tmp_path / "front", shoulder=3.0)
    side = footage(tmp_path / "side", angle=2, gain=2.0, shoulder=3.0)
    views = [f"0={front}", f"90={side}"]
    shot = open_shot(views, InputOptions(align="auto"), 3.0)
    assert shot.alignments[0].alignment.gain == pytest.approx(2, rel=0.03)
    sums = undo_shoulder(shot.views(5).images, 3.0).sum(axis=1)
    np.testing.assert_allclose(sums[0], sums[1], rtol=1e-4, atol=1)
    display = open_shot(views).views(5).images
    sums = undo_shoulder(display, 3.0).sum(axis=1)
    assert np.abs(sums[0] - sums[1]).max() > 0.03 * sums.max()


def test_what_is_given_is_kept(pair):
    """The rest is found around it, and nothing is searched where all is given."""
    shot = open_shot(pair, InputOptions(align="auto", view_time="90=2", view_gain="90=1"))
    found = shot.alignments[0].alignment
    assert (found.time, found.gain) == (2, 1)
    assert found.shift == pytest.approx(3, abs=0.1)
    again = open_shot(pair, InputOptions(**{**vars(shot.options), "align": "auto"}))
    assert again.options == shot.options
    assert again.alignments[0].disagreement is None


def test_one_view_has_nothing_to_align(pair):
    """That is said, and is no error."""
    shot = open_shot(pair[:1], InputOptions(align="auto"))
    assert any("nothing to align" in note for note in shot.notes)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"view_time": "3"}, "--view-time '3' is not ANGLE=NUMBER, such as 90=1.5"),
        ({"view_gain": "90=bright"}, "--view-gain '90=bright' is not ANGLE=NUMBER"),
        ({"view_shift": "45=2"}, "--view-shift names view 45, which is not there: the views are 0 and 90"),
        ({"view_scale": "90=0"}, "--view-scale 90=0 is out of range, expected 0.5 to 2"),
        ({"view_time": "90=nan"}, "out of range"),
        ({"view_time": "90=99"}, "no frame in common"),
        ({"view_time": "90=2", "frames": "1-5"}, "lacks frame 1-2 (it has 3-16)"),
    ],
)
def test_what_is_given_wrong(pair, options, words):
    """Is named with its flag."""
    assert words in refusal(pair, **options)


def test_what_cannot_be_aligned(tmp_path, pair):
    """Too few frames, rows all alike, another scene: numbers and the way out."""
    few = [f"{a}={footage(tmp_path / f'few{a}', range(1, 5), angle=a)}" for a in (0, 90)]
    message = refusal(few, align="auto")
    assert "4 frames are too few to compare, at least 8 are needed" in message
    assert "--view-time 90=FRAMES" in message
    flat = tmp_path / "flat"
    flat.mkdir()
    backwards = tmp_path / "backwards"
    backwards.mkdir()
    for frame in range(1, 15):
        write_png(flat / f"{frame:03d}.png", np.full((ROWS, COLUMNS), 90 + frame % 2, np.uint8))
        write_png(backwards / f"{frame:03d}.png", picture(15 - frame)[::-1])
    assert "all alike" in refusal([pair[0], f"90={flat}"], align="auto")
    message = refusal([pair[0], f"90={backwards}", f"45={flat}"], align="auto")
    assert "view 90 cannot be aligned with view 0" in message
    assert "correlation" in message
    assert len(message.splitlines()) == 2  # a line a view
    write_png(tmp_path / "a.001.png", picture(1))
    write_png(tmp_path / "b.001.png", picture(1, angle=2))
    stills = [f"0={tmp_path / 'a.001.png'}", f"90={tmp_path / 'b.001.png'}"]
    assert "no two successive pictures" in refusal(stills, view_time="90=0.5")


def test_inspect_tells(pair, capsys):
    """In words with the flags that say the same by hand, and as JSON; without it there is a hint."""
    views = ["--view", pair[0], "--view", pair[1], "--no-picture"]
    assert run("inspect", *views) == 0
    assert "--align auto does it" in capsys.readouterr().out
    assert run("inspect", *views, "--align", "auto") == 0
    text = capsys.readouterr().out
    assert "align   view 90: 2 frames later, " in text
    assert "--view-time 90=2 --view-shift 90=" in text
    assert run("inspect", *views, "--align", "auto", "--json") == 0
    (found,) = json.loads(capsys.readouterr().out)["alignments"]
    assert found["alignment"]["time"] == 2
    assert found["disagreement_after"] < 0.1 < found["disagreement"]


def test_a_run_keeps_what_was_found(pair, tmp_path, monkeypatch):
    """run.toml has fixed numbers: continued or repeated, nothing is searched and the bits are the same."""
    flags = quick("--view", pair[0], "--view", pair[1], *BARE, "--frames", "5-7")
    assert run("reconstruct", *flags, "--align", "auto", "-o", tmp_path / "found") == 0
    table = Run(tmp_path / "found").settings()["input"]
    assert table["view_time"] == "90=2"
    assert table["align"] == "none"

    def fail(*_, **__):
        raise AssertionError("searched again")

    monkeypatch.setattr("warpfluid.footage.aligning.match_row_sums", fail)
    whole = volumes(tmp_path / "found")
    (tmp_path / "found" / "density.0006.vdb").unlink()
    assert run("reconstruct", *flags, "--align", "auto", "-o", tmp_path / "found", "--resume") == 0
    assert volumes(tmp_path / "found") == whole
    assert run("reconstruct", "--config", tmp_path / "found" / "run.toml", "-o", tmp_path / "again") == 0
    assert volumes(tmp_path / "again") == whole
    given = [f"--view-{name}={table[f'view_{name}']}" for name in OFF]
    assert run("reconstruct", *flags, *given, "-o", tmp_path / "given") == 0
    assert volumes(tmp_path / "given") == whole
    assert run("reconstruct", *flags, "--view-time", "90=1", "-o", tmp_path / "found", "--resume") == 2
