"""What stands in a run, as surfaces: where the simulation has it."""

import numpy as np
import pytest

from warpfluid.files.bodies import write_bodies
from warpfluid.report.film import film_pictures
from warpfluid.run import BODIES, Run
from warpfluid.simulation.outlines import Outlines
from warpfluid.simulation.placing import Placing
from warpfluid.simulation.triangles import check_closed, turned_surface, weigh

SHAPE = (20, 24, 30)
SETTINGS = """
size = [20, 30]
[output]
voxel_size = 0.5
[[obstacle]]
shape = "sphere"
center = "1:0,2,0;3:2,2,0"
radius = 1.0
[[obstacle]]
shape = "cylinder"
radius = 0.5
size = "1,2,1"
rotation = "0,0,90"
[[body]]
size = "2,1,1"
"""


@pytest.fixture
def run(tmp_path):
    """A folder with settings and one frame of its body."""
    (tmp_path / "run.toml").write_text(SETTINGS)
    turned = [0, 0, np.sqrt(0.5), np.sqrt(0.5)]  # x to y
    state = {"position": [7, 8, 9], "quaternion": turned, "velocity": np.zeros(3), "spin": np.zeros(3)}
    origin = Placing(SHAPE, 1.0).origin
    write_bodies(tmp_path / BODIES, ["body1"], {2: [state]}, voxel=0.5, origin=origin)
    return Run(tmp_path)


def test_obstacles_and_bodies(run):
    """Their middles and extents [voxel], at their frame; closed, and turned outwards."""
    ball, cylinder, body = Outlines(run).at(2, SHAPE)
    unit, origin = SHAPE[2] / 10, Placing(SHAPE, 1.0).origin
    assert [thing.kind for thing in (ball, cylinder, body)] == ["obstacle", "obstacle", "body"]
    for thing, middle, extent in (
        (ball, origin + unit * np.array([1, 2, 0]), 2 * unit * np.ones(3)),
        (cylinder, origin + unit * np.array([0, 3, 0]), unit * np.array([2, 1, 1])),
        (body, [7, 8, 9], unit * np.array([1, 2, 1])),
    ):
        low, high = thing.vertices.min(axis=0), thing.vertices.max(axis=0)
        np.testing.assert_allclose((low + high) / 2, middle, atol=1e-6)
        np.testing.assert_allclose(high - low, extent, rtol=5e-3)
        check_closed(thing.vertices, thing.triangles)
        assert weigh(thing.vertices, thing.triangles).volume > 0


def test_in_finer_files(run):
    """Where files have more voxels than the simulation, everything is as much larger."""
    text = (run.folder / "run.toml").read_text()
    coarse = Outlines(run).at(2, SHAPE)
    (run.folder / "run.toml").write_text(f"{text}[simulate]\ndetail = 2\n")
    fine_shape = tuple(2 * n for n in SHAPE)
    origin, fine_origin = (Placing(shape, 1.0).origin for shape in (SHAPE, fine_shape))
    for before, after in zip(coarse, Outlines(run).at(2, fine_shape), strict=True):
        np.testing.assert_allclose(after.vertices - fine_origin, 2 * (before.vertices - origin), atol=1e-6)


def test_other_frames(run):
    """A keyed obstacle has moved on; a body without a record is not there."""
    outlines = Outlines(run)
    first, third = outlines.at(1, SHAPE), outlines.at(3, SHAPE)
    assert len(first) == len(third) == 2
    moved = third[0].vertices.mean(axis=0) - first[0].vertices.mean(axis=0)
    np.testing.assert_allclose(moved, [6, 0, 0], atol=1e-6)


def test_a_run_with_nothing_in_it(tmp_path):
    """As a reconstruction is."""
    (tmp_path / "run.toml").write_text("size = [20, 30]\n")
    assert Outlines(Run(tmp_path)).at(1, SHAPE) == []


def test_bodies_that_do_not_fit(run):
    """Settings of two bodies, and one in the file."""
    with (run.folder / "run.toml").open("a") as file:
        file.write("[[body]]\nsize = '1,1,1'\n")
    with pytest.raises(ValueError, match="1 bodies, the settings 2"):
        Outlines(run).at(2, SHAPE)


def test_volume_of_round_things():
    """A ball's and a cylinder's, nearly."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, 65)[1:-1]
    ball = turned_surface(np.cos(angles), np.sin(angles), (-1, 1))
    assert weigh(*ball).volume == pytest.approx(4 / 3 * np.pi, rel=5e-3)
    assert weigh(*turned_surface(np.ones(2), np.array([-1, 1]), (-1, 1))).volume == pytest.approx(2 * np.pi, rel=5e-3)


def test_film_of_a_run_shows_them(run, monkeypatch):
    """Brighter than an empty volume, where they are."""
    monkeypatch.setattr(Run, "records", lambda self: {2: {}})
    monkeypatch.setattr(Run, "volume", lambda self, frame: np.zeros((20, 20, 30), np.float32))
    front, *_ = film_pictures(run, "smoke", 4)
    assert front.shape == (240, 160, 3)  # eight pixels a voxel
    assert front[240 - 8 * 9 : 240 - 8 * 8, 48:64].max() > 60
    assert not front[:40].any()
