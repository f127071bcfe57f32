"""Bodies and obstacles in a page: each once, and where the run has it in every frame."""

import base64
import zlib
from types import SimpleNamespace

import numpy as np
import pytest

from warpfluid.options import PreviewOptions
from warpfluid.preview.page import write_page
from warpfluid.preview.scene import SOLID_COLOURS, open_scene
from warpfluid.preview.solids import find_pose, pack_solids
from warpfluid.simulation.outlines import Outline
from warpfluid.simulation.triangles import box_surface


def unpack(part):
    """Places, triangles and normals of a packed surface."""
    data, n = zlib.decompress(base64.b64decode(part["mesh"])), part["vertices"]
    places = np.frombuffer(data, "<f4", 3 * n).reshape(n, 3)
    normals = np.frombuffer(data[-3 * n :], np.int8).reshape(n, 3)
    return places, np.frombuffer(data[12 * n : -3 * n], "<u4").reshape(-1, 3), normals


def rows(points):
    """Points in an order of their own."""
    return points[np.lexsort(np.round(points, 2).T)]


def test_every_surface_is_there_once_and_where_the_run_has_it(solid_run):
    """Three frames of a falling box, a ball and a cylinder."""
    scene = open_scene(solid_run)
    shape = scene.volumes.density(1).shape
    parts = pack_solids(scene, shape)
    for part, kind in zip(parts, ("obstacle", "obstacle", "body"), strict=True):
        expected = np.frombuffer(bytes.fromhex(SOLID_COLOURS[kind][1:]), "u1") / 255
        np.testing.assert_allclose(part["color"], expected, atol=1e-4)
    middle = (np.array(shape)[[0, 2, 1]] - 1) / 2
    for index, frame in enumerate(scene.frames):
        for part, solid in zip(parts, scene.solids(frame, shape), strict=True):
            places, triangles, normals = unpack(part)
            pose = np.reshape(part["poses"][index], (4, 3))
            moved = places @ pose[:3] + pose[3] + middle
            np.testing.assert_allclose(moved[triangles], solid.vertices[solid.triangles], atol=5e-3)
            a, b, c = np.moveaxis(places[triangles], 1, 0)
            flat = np.cross(b - a, c - a)
            assert (np.einsum("ij,ikj->ik", flat, normals[triangles].astype(float)) > 0).all()


def scene_of(*surfaces):
    """A scene with a list of surfaces a frame."""
    return SimpleNamespace(frames=range(len(surfaces)), solids=lambda frame, _: surfaces[frame])


def outline(points, triangles, kind="body"):
    return Outline(points, triangles, kind)


def test_things_come_and_go():
    """Two equal boxes are two parts, what has other triangles is another one."""
    points, triangles = box_surface(np.array([2.0, 1, 1]))
    one, two, other = outline(points, triangles), outline(points + 5, triangles), outline(points, triangles[1:])
    parts = pack_solids(scene_of([one, two], [two, one], [other], [two], []), (8, 8, 8))
    there = [[i for i, pose in enumerate(part["poses"]) if pose is not None] for part in parts]
    assert there == [[0, 1, 3], [0, 1], [2]]


def test_a_pose_turns_and_shifts():
    """Found again from the corners; other kinds and forms have none."""
    points, triangles = box_surface(np.array([2.0, 1, 3]))
    points = np.concatenate([points, points[:1] * 1.5])  # nine points that no linear map bends
    turn = np.linalg.qr(np.random.default_rng(1).standard_normal((3, 3)))[0]
    middle = np.array([1.0, 2, 3])
    pose = find_pose(outline(points, triangles), outline(points @ turn + [4, 5, 6], triangles), middle)
    np.testing.assert_allclose(pose, [*turn, [3, 3, 3]], atol=1e-9)
    assert find_pose(outline(points, triangles), outline(points, triangles, "obstacle"), middle) is None
    assert find_pose(outline(points, triangles), outline(points**3, triangles), middle) is None
    assert find_pose(outline(points, triangles), outline(points, triangles[1:]), middle) is None


def test_a_page_too_small_for_them_is_refused(solid_run, tmp_path):
    """With what to do."""
    scene = open_scene(solid_run, PreviewOptions())
    with pytest.raises(ValueError, match="html-size"):
        write_page(tmp_path / "page.html", scene, budget=0.06)
