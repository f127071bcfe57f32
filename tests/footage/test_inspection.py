"""Inspection: row sums tell a known offset, shift and exposure, and the hints say what to do."""

import json
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warpfluid.files.images import read_image, write_png
from warpfluid.footage.estimate import estimate_cost, estimate_run, hull_share
from warpfluid.footage.hints import cost_hints
from warpfluid.footage.inspection import inspect_shot, write_views_picture
from warpfluid.footage.row_sums import compare_row_sums
from warpfluid.footage.shot import open_shot
from warpfluid.memory import memory_limit
from warpfluid.options import InputOptions, ReconstructOptions
from warpfluid.reconstruction.pieces import Pieces
from warpfluid.views import Views


def history(frames=30, heights=60):
    """Row sums of puffs that rise at their own speeds and fade."""
    rng = np.random.default_rng(3)
    t, v = np.mgrid[0:frames, 0:heights].astype(float)
    puffs = zip(rng.uniform(-20, 30, 12), rng.uniform(0.5, 2.5, 12), rng.uniform(0.5, 2, 12), strict=True)
    return sum(light * np.exp(-(((v - start - speed * t) / 4) ** 2)) for start, speed, light in puffs)


@settings(deadline=None, max_examples=15)
@given(st.integers(-6, 6), st.integers(-12, 12), st.floats(0.3, 3))
def test_known_remedy_is_found(offset, shift, scale):
    """A view that runs late, sits low and is dim is told to the frame and pixel."""
    light = history(46, 90)
    reference = light[8:38, 15:75]
    sums = light[8 + offset : 38 + offset, 15 + shift : 75 + shift] / scale
    remedy = compare_row_sums(reference, sums)
    assert (remedy.time_offset, remedy.vertical_shift) == (offset, shift)
    assert remedy.exposure_scale == pytest.approx(scale, rel=1e-6)
    assert remedy.disagreement_after == pytest.approx(0, abs=1e-6)


def test_equal_row_sums_need_no_remedy():
    """Views of one fluid agree, and so do two of nothing."""
    for sums in (history(), np.zeros((5, 20))):
        remedy = compare_row_sums(sums, sums)
        assert (remedy.disagreement, remedy.time_offset, remedy.vertical_shift) == (0, 0, 0)
        assert remedy.exposure_scale == 1


def test_a_steady_flame_fits_at_any_time():
    """Where every offset does as well the smallest remedy is given."""
    steady = np.broadcast_to(np.hanning(40), (20, 40))
    remedy = compare_row_sums(steady, steady * 2)
    assert (remedy.time_offset, remedy.vertical_shift) == (0, 0)
    assert remedy.exposure_scale == pytest.approx(0.5)


def test_hull_of_discs_is_their_cylinder():
    """Two views of a full-height bar leave the square they have in common, all angles of a disc the disc."""
    images = np.zeros((2, 40, 20), np.float32)
    images[:, 10:30] = 9
    assert hull_share(images, (0, 90), ReconstructOptions()) == pytest.approx(0.25)
    angles = tuple(np.arange(0, 180, 10.0))
    discs = np.repeat(images[:1], len(angles), axis=0)
    assert hull_share(discs, angles, ReconstructOptions()) == pytest.approx(np.pi / 16, rel=0.08)


def test_hull_of_one_view():
    """A bar becomes the round about its bulk, or with the silhouette a slab."""
    image = np.zeros((1, 40, 20), np.float32)
    image[:, 10:30] = 9
    assert hull_share(image, (0,), ReconstructOptions(hull="silhouette")) == pytest.approx(0.5)
    assert 0.15 < hull_share(image, (0,), ReconstructOptions()) < 0.4
    assert hull_share(image * 0, (0,), ReconstructOptions()) == 0


def test_cost_grows_with_the_volume():
    """Twice the size is about eight times the memory of the volume, and no iterations are cheaper."""
    small, large = (estimate_cost((n, n), 0.2, ReconstructOptions(angles=90)) for n in (256, 512))
    assert 4 < large[0] / small[0] < 9
    assert 4 < large[1] / small[1] < 9
    assert estimate_cost((256, 256), 0.2, ReconstructOptions(method="lsm", angles=90))[0] < small[0]


@pytest.mark.parametrize("overlap", [0, 2, 5])
def test_pieces_cost_what_leads_up_to_them(overlap):
    """As many frames that start anew, and that are carried, as the pieces ask for."""
    cut = Pieces(first=1, step=1, length=4, overlap=overlap, coherent=True)
    tasks = [cut.task(frame, range(1, 19), range(1, 19)) for frame in range(1, 19)]
    anew = sum(task.before is None for task in tasks)
    carried = sum(task.before is not None for task in tasks) + sum(len(task.lead) for task in tasks)
    whole, pieces = (
        estimate_run(18, 100.0, 1.0, ReconstructOptions(piece=piece, overlap=overlap)) for piece in (None, 4)
    )
    assert pieces - whole == pytest.approx(100 * anew + carried - 100 - 17)
    assert estimate_run(18, 3, 3, ReconstructOptions(piece=4, method="lsm")) == estimate_run(
        18, 3, 3, ReconstructOptions()
    )


def test_random_walks_cost_by_mutations():
    """Those that are asked for or those that the hull calls for; in an E-step by the angles, too."""

    def seconds(**options):
        return estimate_cost((96, 144), 0.1, ReconstructOptions(**options))[0]

    assert seconds(method="lsm") < seconds(method="convex") < seconds(method="stochastic")
    assert seconds(method="stochastic", mutations=4 * 10**9) > 60 > seconds(method="stochastic", mutations=1000)
    assert seconds(e_step="stochastic", angles=180) > 1.5 * seconds(e_step="stochastic", angles=90)
    assert seconds() < seconds(transfer="texture-optimization") < seconds(transfer="portilla-simoncelli", sweeps=4)
    assert seconds(method="lsm") == seconds(method="lsm", transfer="portilla-simoncelli")


def test_long_runs_are_given_a_width():
    """A run of hours or of too much memory gets a smaller width that takes minutes; a short one gets none."""
    options = ReconstructOptions(coherence="none")
    assert cost_hints((256, 256), 8, 0.1, options, 2) == []
    (hint,) = cost_hints((512, 512), 200, 0.2, options, 2)
    width = int(re.search(r"--resolution (\d+) ", hint)[1])
    seconds = estimate_cost((width, width), 0.2, options)[0]
    assert 64 <= width < 512
    assert 200 * seconds < 1300
    (huge,) = cost_hints((6000, 4000), 1, 0.01, options, 2)
    width = int(re.search(r"--resolution (\d+) ", huge)[1])
    assert estimate_cost((width, width * 2 // 3), 0.01, options)[1] < memory_limit() / 2 + 1e9
    assert cost_hints((80, 80), 10**7, 0.2, options, 1)[0].startswith("this is a long")


@pytest.mark.parametrize(("offset", "words"), [(1, "1 frame earlier"), (-1, "1 frame later"), (3, "3 frames earlier")])
def test_one_frame_is_no_frames(tmp_path, offset, words):
    """Hints count as people do."""
    front = write(tmp_path / "front", flame)
    side = write(tmp_path / "side", lambda frame: flame(frame - offset))
    (hint,) = [hint for hint in inspect_shot(open_shot([f"0={front}", f"90={side}"])).hints if "rows" in hint]
    assert f"play it {words}" in hint


def flame(frame, tall=32, wide=24):
    """A puff that rises, uint8 (rows, columns)."""
    rows, columns = np.mgrid[0:tall, 0:wide]
    middle = tall - 6 - 1.5 * frame
    bell = np.exp(-(((rows - middle) / 4) ** 2) - ((columns - wide / 2) / 4) ** 2)
    return (180 * bell).astype(np.uint8)


def write(folder, make, frames=range(1, 13)):
    folder.mkdir()
    for frame in frames:
        write_png(folder / f"{frame:03d}.png", make(frame))
    return str(folder)


def test_a_late_view_is_noticed(tmp_path):
    """A side that runs two frames late gets that as a hint, and everything goes into JSON."""
    front = write(tmp_path / "front", flame)
    side = write(tmp_path / "side", lambda frame: flame(frame - 2))
    found = inspect_shot(open_shot([f"0={front}", f"90={side}"]))
    assert found.pairs[0].remedy.time_offset == -2
    assert found.pairs[0].remedy.disagreement_after < 0.02
    assert any("2 frames earlier" in hint for hint in found.hints)
    data = json.loads(json.dumps(found.to_dict()))
    assert data == found.to_dict()
    assert data["pairs"][0]["remedy"]["time_offset"] == -2
    assert data["volume_size"] == [24, 32, 24]
    assert any("view 90 against view 0" in line for line in found.lines())


def test_one_view_is_described(tmp_path):
    """What stands in a file is reported as it is."""
    folder = write(tmp_path / "front", flame)
    found = inspect_shot(open_shot([f"0={folder}"], InputOptions(frames="1-6")))
    view = found.views[0]
    assert (view.footage_size, view.size, view.frames, view.kind) == ((24, 32), (24, 32), "1-12", "images")
    assert (view.brightest, view.background, view.saturated) == (pytest.approx(180, abs=2), 0, 0)
    assert (found.frames, found.frame_count, found.pairs) == ("1-6", 6, ())
    (hint,) = found.hints  # the puff begins at the lower edge
    assert "view 0: light crosses the bottom edge: the volume ends there in a flat cut" in hint
    assert inspect_shot(open_shot([f"0={folder}"], InputOptions(frames="4-8"))).hints == ()


def test_what_is_cut_at_the_top(tmp_path):
    """The volume ends where the picture does; a lit background has another way out."""
    folder = write(tmp_path / "high", lambda frame: flame(frame)[6:])
    assert any("crosses the bottom and top edge" in hint for hint in inspect_shot(open_shot([f"0={folder}"])).hints)
    grey = write(tmp_path / "grey", lambda frame: flame(frame)[6:] // 2 + 30)
    assert not any("flat cut" in hint for hint in inspect_shot(open_shot([f"0={grey}"])).hints)


def test_a_remedy_has_one_sign(tmp_path):
    """The row line, the hint and the flag agree; what is aligned is told before its rows, as they are now."""
    front = write(tmp_path / "front", flame)
    side = write(tmp_path / "side", lambda frame: flame(frame - 2))
    views = [f"0={front}", f"90={side}"]
    found = inspect_shot(open_shot(views))
    assert "apart; -2 frames, +0 pixels" in "\n".join(found.lines())
    assert any("play it 2 frames earlier" in hint for hint in found.hints)
    by_hand = inspect_shot(open_shot(views, InputOptions(view_time="90=-2")))
    assert by_hand.pairs[0].remedy.disagreement < 0.02
    lines = by_hand.lines()
    (align,), (rows,) = ([i for i, line in enumerate(lines) if line.startswith(name)] for name in ("align", "rows"))
    assert align < rows
    assert "apart now; +0 frames" in lines[rows]


def test_only_what_was_measured_is_promised(tmp_path):
    """Before the background is off the rows compare other light: no number is promised."""
    for name, grey in (("dark", 0), ("lit", 30)):
        (tmp_path / name).mkdir()
        front = write(tmp_path / name / "front", lambda frame, grey=grey: flame(frame) // 2 + grey)
        side = write(tmp_path / name / "side", lambda frame, grey=grey: flame(frame - 2) // 2 + grey)
        hints = "\n".join(inspect_shot(open_shot([f"0={front}", f"90={side}"])).hints)
        assert "play it 2 frames earlier" in hints
        assert ("is left; --align auto does it" in hints) is (grey == 0)
        assert ("take the background off, then look again with --align auto" in hints) is (grey > 0)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda frame: flame(frame) // 2 + 30, "--black-level 30"),
        (lambda frame: np.where(flame(frame) > 5, 240, 0).astype(np.uint8), "--shoulder"),
        (lambda frame: np.roll(flame(frame), 12, axis=1), "left and right edge"),
        (lambda frame: flame(frame) // 2 + 30, "hull fills"),
    ],
)
def test_hints(tmp_path, make, words):
    """Footage that an option would help gets that option as a hint."""
    found = inspect_shot(open_shot([f"0={write(tmp_path / 'a', make)}"]), ReconstructOptions(hull="silhouette"))
    assert any(words in hint for hint in found.hints)


def level_hints(view, **options):
    """Return the share of the hull and the black levels that the hints name."""
    found = inspect_shot(open_shot([view], InputOptions(**options)))
    return found.hull_share, [int(level) for level in re.findall(r"--black-level (\d+)", "\n".join(found.hints))]


@pytest.mark.parametrize("resolution", [None, "48"])
@pytest.mark.parametrize("background", [0, 5, 10])
def test_one_level_clears_noise(tmp_path, background, resolution):
    """On dark noisy footage the first level proposed is enough, whether or not pictures are reduced."""
    rng = np.random.default_rng(background)
    uneven = background * np.linspace(0, 1, 96)

    def make(frame):
        noisy = flame(frame, tall=120, wide=96) + uneven + rng.normal(0, 3, (120, 96))
        return noisy.clip(0, 255).round().astype(np.uint8)

    view = f"0={write(tmp_path / 'noisy', make, range(1, 7))}"
    share, levels = level_hints(view, resolution=resolution)
    assert share > 0.15
    assert len(levels) == 1
    share, levels = level_hints(view, resolution=resolution, black_level=levels[0])
    assert share < 0.05
    assert levels == []


def test_a_level_counts_on_top(tmp_path):
    """Where a black level is too low, the one proposed replaces it, in the footage's own grey levels."""
    view = f"0={write(tmp_path / 'grey', lambda frame: flame(frame) // 2 + 30)}"
    assert level_hints(view, black_level=20)[1] == [30]


def test_the_level_is_not_the_flame(tmp_path):
    """A flame that crosses an edge does not raise the level, and one that crosses all of them asks for none."""
    crossing = write(tmp_path / "crossing", lambda frame: np.roll(flame(frame) // 2 + 30, 12, axis=1))
    assert level_hints(f"0={crossing}")[1] == [30]
    cross = np.zeros((32, 24), np.uint8)
    cross[14:18], cross[:, 10:14] = 200, 200
    assert level_hints(f"0={write(tmp_path / 'cross', lambda frame: cross)}")[1] == []


def test_different_scenes_are_noticed(tmp_path):
    """Views that no shift brings together are called in question."""
    front = write(tmp_path / "a", flame)
    side = write(tmp_path / "b", lambda frame: np.roll(flame(12 - frame), 16, axis=0))
    found = inspect_shot(open_shot([f"0={front}", f"90={side}"]))
    assert any("no shift mends it" in hint for hint in found.hints)


@pytest.mark.parametrize("angles", [(0,), (0, 90), (52, 35, 0, -52, -66)])
def test_views_picture_shows_each_view(tmp_path, angles):
    """The picture holds light where the views do, for one view as for many, and for black ones."""
    images = np.repeat(flame(5)[None, ::-1].swapaxes(1, 2).astype(np.float32), len(angles), axis=0)
    write_views_picture(tmp_path / "lit.png", Views(images, angles))
    write_views_picture(tmp_path / "black.png", Views(images * 0, angles))
    lit, black = read_image(tmp_path / "lit.png"), read_image(tmp_path / "black.png")
    assert lit.shape == (800, 1280, 3)
    assert lit.mean() > black.mean()
    assert ((lit - black).max(axis=2) > 0.2).sum() > 500
