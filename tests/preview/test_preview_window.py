"""The window: it looks like the turntable, every part can be seen, and keys do what they say."""

import numpy as np
import pytest

from warpfluid.doctor import drawing
from warpfluid.files.npz import write_npz
from warpfluid.options import PreviewOptions
from warpfluid.preview import parts
from warpfluid.preview.controls import Controls
from warpfluid.preview.scene import open_scene
from warpfluid.rendering.turntable import render_turntable

SIZE = "480x400"


@pytest.fixture(scope="module")
def folder(tmp_path_factory, fire) -> str:
    """Two frames of a fire, the second mirrored."""
    folder = tmp_path_factory.mktemp("window")
    for frame, volume in ((1, fire), (2, fire[::-1])):
        write_npz(folder / f"fire.{frame}.npz", volume.swapaxes(1, 2), frame=frame)
    return str(folder)


@pytest.fixture
def window(folder):
    """Make a window in memory, or skip where nothing draws."""
    if drawing() == "nothing":
        pytest.skip("there is no OpenGL library")
    import pyvista

    from warpfluid.preview.window import Window

    made = []

    def make(**choices):
        options = PreviewOptions(window=SIZE, **choices)
        with pyvista.vtk_verbosity("off"):
            made.append(Window(open_scene(folder, options), options, off_screen=True))
        return made[-1]

    yield make
    for one in made:
        one.plotter.close()


@pytest.mark.gl
@pytest.mark.parametrize(("look", "exposure"), [("fire", 0), ("gray", -1), ("smoke", 1)])
def test_the_volume_looks_like_the_turntable(window, look, exposure):
    """Light adds up along the rays and is coloured, at any exposure."""
    made = window(show="volume", angle=0, elevation=0, look=look, exposure=exposure)
    made.plotter.remove_actor("title")
    made.plotter.set_background("black")
    camera = made.plotter.camera
    away = camera.position - np.array(camera.focal_point)
    camera.focal_point = parts.box_middle(made.density.shape)
    camera.position = camera.focal_point + away
    camera.parallel_scale = 20  # half the box's height: 10 pixels a voxel
    seen = made.picture().astype(float).reshape(40, 10, 48, 10, 3).mean(axis=(1, 3))
    wanted = render_turntable(made.density, [0], look, white=255 / 2**exposure)[0]
    wanted = wanted.reshape(40, 2, 48, 2, 3).mean(axis=(1, 3))
    lit = wanted.max(axis=-1) > 8
    assert np.abs(seen - wanted)[lit].mean() < 4
    assert seen[~lit].mean() < 3


@pytest.mark.gl
def test_the_grey_levels_do_not_hang_on_what_else_is_there(window):
    """A box that is full of light to its edges, and one voxel in it, are as bright as they are."""
    made = window(show="volume", angle=0, elevation=0, look="gray")
    for density, level in ((np.full((9, 9, 9), 10.0), 90), (np.pad(np.full((1, 1, 1), 200.0), 4), 200)):
        made.density = density.astype(np.float32)
        made.draw()
        made.plotter.set_background("black")
        made.plotter.camera.focal_point = (4, 4, 4)
        made.plotter.camera.position = (4, 4, 50)
        made.plotter.camera.parallel_scale = 0.2
        assert made.picture()[190:210, 230:250].mean() == pytest.approx(level, abs=4)


@pytest.mark.gl
def test_frames_and_parts_change_the_picture(window):
    """Another frame is another picture, and so is one without a part; back again it is the same."""
    made = window(show="volume", angle=0, elevation=0)
    first, shown = made.picture(), made.frame
    made.show_frame(made.index + 1)
    assert made.frame != shown
    assert np.abs(first.astype(int) - made.picture()).max() > 40
    made.show_frame(made.index + 1)
    np.testing.assert_array_equal(made.picture(), first)
    for part in ("slices", "box"):
        made.toggle(part)
        assert np.abs(first.astype(int) - made.picture()).max() > 40, part
        made.toggle(part)
        np.testing.assert_array_equal(made.picture(), first)


@pytest.mark.gl
def test_what_files_lack_is_said_once(window, capsys):
    """Volumes of another program may have no velocity; the rest is shown."""
    made = window(show="volume,arrows,streamlines,pictures,bodies")
    made.show_frame(0)
    assert capsys.readouterr().out.count("no arrows: ") == 1
    assert made.picture().max() > 100


@pytest.mark.gl
def test_keys_have_actions(window):
    """Each that the help names does something, and the views have a number each."""
    made = window(show="volume", angle=20, elevation=10)
    controls = Controls(made)
    actions = controls.actions()
    for key, change in (("Right", lambda: made.index), ("Up", lambda: made.exposure), ("c", lambda: made.look),
                        ("Prior", lambda: made.slice_height), ("space", lambda: controls.playing)):  # fmt: skip
        before = change()
        actions[key]()
        assert change() != before, key
    actions["2"]()
    np.testing.assert_allclose(made.plotter.camera.direction, [1, 0, 0], atol=1e-6)  # 90 degrees look along x
    actions["r"]()
    towards = parts.facing(20, 10)[0]
    np.testing.assert_allclose(made.plotter.camera.direction, -towards, atol=1e-6)
    for part in "vsalibo":
        actions[part]()


def test_arrows_follow_the_motion():
    """They start in lit voxels, point along the flow (x, y, z), and the fast are long."""
    density = np.zeros((12, 10, 14), np.float32)
    density[4:8, 3:7, 2:12] = 1
    velocity = np.zeros((*density.shape, 3), np.float32)
    velocity[..., 2] = np.arange(14)  # upwards, faster above
    made = parts.arrows(density, velocity)
    low, high = np.array(made.bounds).reshape(3, 2).T
    assert low[1] >= 2
    assert (low[[0, 2]] > [3, 2]).all()
    assert (high[[0, 2]] < [8, 7]).all()
    assert made["speed"].min() >= 2
    assert parts.arrows(0 * density, velocity) is None
    assert parts.arrows(density, 0 * velocity) is None


def test_streamlines_follow_the_motion():
    """In a flow around the middle they stay at their distance from it and at their height."""
    x, z = np.meshgrid(np.arange(40) - 19.5, np.arange(40) - 19.5, indexing="ij")
    velocity = np.zeros((40, 40, 20, 3), np.float32)
    velocity[..., 0], velocity[..., 1] = -z[..., None], x[..., None]
    density = np.zeros((40, 40, 20), np.float32)
    density[30, 19, 10] = 1
    made = parts.streamlines(density, velocity)
    radius = np.hypot(made.points[:, 0] - 19.5, made.points[:, 2] - 19.5)
    np.testing.assert_allclose(radius, 10.5, atol=0.3)
    np.testing.assert_allclose(made.points[:, 1], 10, atol=0.3)
    assert np.ptp(made.points[:, 0]) > 20
    assert parts.streamlines(0 * density, velocity) is None


@pytest.mark.parametrize(("angle", "behind", "right"), [(0, [0, 0, -1], [1, 0, 0]), (90, [1, 0, 0], [0, 0, 1])])
def test_pictures_stand_behind_the_box(angle, behind, right):
    """As the camera throws them there: upright, as large as the box, not mirrored."""
    image = np.arange(6 * 9, dtype=np.float32).reshape(6, 9)
    plane, texture = parts.picture(image, angle, (6, 6, 9))
    middle = np.array([2.5, 4, 2.5])
    np.testing.assert_allclose(
        plane.points.mean(axis=0) - middle, parts.PICTURE_DISTANCE * 6 * np.array(behind), atol=1e-5
    )
    lower_left, lower_right, _, upper_left = np.array(plane.points)
    np.testing.assert_allclose(lower_right - lower_left, 6 * np.array(right), atol=1e-5)
    np.testing.assert_allclose(upper_left - lower_left, [0, 9, 0], atol=1e-5)
    assert texture.to_array()[-1, 0, 0] == 0  # the darkest is at the bottom left


def test_solids_and_slices_keep_their_places():
    """A mesh keeps its points; slices lie where they should and hide what is dark."""
    made = parts.solid(np.eye(4, 3) * 3.0, np.array([[0, 1, 2], [0, 2, 3]]))
    assert made.n_cells == 2
    np.testing.assert_allclose(made.points, np.eye(4, 3) * 3.0)
    density = np.random.default_rng(0).random((5, 5, 9)).astype(np.float32)
    cut, colours = parts.slices(density, 0.5, 1.0)
    flat = [block for block in cut if np.ptp(block.points[:, 1]) < 1e-6]
    assert len(flat) == 1
    expected = density[:, :, 4]
    found = {tuple(p[[0, 2]].astype(int)): v for p, v in zip(flat[0].points, flat[0]["density"], strict=True)}
    assert found == {(x, z): expected[x, z] for x in range(5) for z in range(5)}
    assert colours.values[0, 3] == 0
