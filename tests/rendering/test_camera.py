"""Cameras: where they see points, and keys from a file."""

import json

import numpy as np
import pytest

from warpfluid.options.keys import Keyed
from warpfluid.rendering.camera import middle, orthographic, perspective
from warpfluid.rendering.camera_path import read_camera_path
from warpfluid.rendering.stereo import stereo_pair

SHAPE = (20, 14, 9)
CAMERAS = [
    orthographic(SHAPE),
    orthographic(SHAPE, 35, 20, size=(31, 22), zoom=1.5),
    perspective(SHAPE, -52, 10, distance=30, field_of_view_deg=40, size=(33, 24)),
    perspective((20, 20, 14), 8, -20, distance=42, field_of_view_deg=70, size=(25, 14), target=(1, 2, 3)),
]


@pytest.mark.parametrize("camera", CAMERAS)
def test_axes_are_a_right_handed_frame(camera):
    """Unit vectors at right angles, backward towards the viewer."""
    frame = np.array([camera.right, camera.up, -camera.forward])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(frame) == pytest.approx(1)


@pytest.mark.parametrize("camera", CAMERAS)
def test_points_along_a_ray_are_seen_at_its_pixel(camera):
    """Rays and projection are inverse, depths along forward."""
    origins, directions = camera.rays()
    for row, column, depth in ((0, 0, 7.0), (3, 8, 12.0), (camera.size[1] - 1, camera.size[0] - 1, 31.5)):
        point = origins[row, column] + depth * directions[row, column]
        np.testing.assert_allclose(camera.project(point)[0], [column, row, depth], atol=1e-9)


@pytest.mark.parametrize("angle", [0, 30, 90, 127, -52])
def test_a_level_camera_sees_what_the_projector_sees(angle):
    """The point (x, z) at u = x cos t + z sin t from the middle, its height upwards."""
    camera = orthographic((20, 20, 9), angle)
    x, y, z = 4.0, 2.0, 13.0
    t = np.deg2rad(angle)
    column, row, _ = camera.project([x, y, z])[0]
    assert column == pytest.approx((x - 9.5) * np.cos(t) + (z - 9.5) * np.sin(t) + 9.5)
    assert row == pytest.approx(8 - y)


def test_the_camera_from_the_left_looks_along_x():
    """At 90 degrees; and at 90 degrees of elevation straight down."""
    np.testing.assert_array_equal(orthographic(SHAPE, 90).forward, [1, 0, 0])
    np.testing.assert_array_equal(orthographic(SHAPE, 0, 90).forward, [0, -1, 0])


@pytest.mark.parametrize("camera", CAMERAS)
def test_eyes_agree_at_the_convergence_only(camera):
    """What is nearer is seen further right by the left eye."""
    left, right = stereo_pair(camera, 2.0, 20.0)
    on_screen, nearer = camera.eye + 20 * camera.forward, camera.eye + 10 * camera.forward
    np.testing.assert_allclose(left.project(on_screen), right.project(on_screen), atol=1e-9)
    (at_left, row, _), (at_right, other_row, _) = left.project(nearer)[0], right.project(nearer)[0]
    assert at_left > at_right + 0.1
    assert row == pytest.approx(other_row)


def test_perspective_keeps_the_height_of_the_target():
    """The field of view spans the picture's height at the target."""
    camera = perspective(SHAPE, 0, 0, distance=30, field_of_view_deg=40, size=(33, 24))
    top = middle(SHAPE) + np.array([0, 30 * np.tan(np.deg2rad(20)), 0])
    assert camera.project(top)[0, 1] == pytest.approx(-0.5)


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda: orthographic((1, 2)), "shape"),
        (lambda: orthographic(SHAPE, float("nan")), "angle_deg"),
        (lambda: orthographic(SHAPE, 0, 91), "elevation_deg"),
        (lambda: orthographic(SHAPE, zoom=0), "zoom"),
        (lambda: orthographic(SHAPE, size=(0, 5)), "size"),
        (lambda: perspective(SHAPE, distance=0, field_of_view_deg=40), "distance"),
        (lambda: perspective(SHAPE, distance=9, field_of_view_deg=180), "field_of_view_deg"),
        (lambda: stereo_pair(CAMERAS[0], 1, 0), "convergence"),
    ],
)
def test_refuses_nonsense(make, match):
    """With the name of what is wrong."""
    with pytest.raises(ValueError, match=match):
        make()


def test_reads_keys_from_a_file(tmp_path):
    """Each number has its own keys; they need not stand in order."""
    path = tmp_path / "camera.json"
    keys = [{"frame": 48, "angle": 90, "target": [0, 4, 0]}, {"frame": 1, "angle": 0, "zoom": 1.5}]
    path.write_text(json.dumps(keys))
    found = read_camera_path(path)
    assert set(found) == {"angle", "target", "zoom"}
    assert Keyed(found["angle"]).at(24.5) == pytest.approx(45)
    np.testing.assert_array_equal(Keyed(found["target"], 3).at(7), [0, 4, 0])
    assert Keyed(found["zoom"]).at(100) == 1.5


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("{", "no JSON"),
        ("{}", "no list"),
        ("[]", "no list"),
        ("[1]", "key 1 has no frame"),
        ('[{"angle": 3}]', "no frame"),
        ('[{"frame": 1, "angel": 3}]', "'angel'"),
        ('[{"frame": 1, "angle": "x"}]', "expected a number"),
        ('[{"frame": 1, "angle": NaN}]', "expected a number"),
        ('[{"frame": 1, "target": [1, 2]}]', "list of 3"),
        ('[{"frame": 1, "angle": 3}, {"frame": 1, "angle": 4}]', "another value"),
    ],
)
def test_refuses_other_files(text, match, tmp_path):
    """With the file's name and the key."""
    path = tmp_path / "camera.json"
    path.write_text(text)
    with pytest.raises(ValueError, match=match):
        read_camera_path(path)
