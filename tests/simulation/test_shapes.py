"""Signed distances against closed forms, and a mesh of a sphere against the sphere."""

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st

from warpfluid.simulation.placed import Placed, rotation_of_degrees, signed_distance
from warpfluid.simulation.shapes import Box, Cylinder, Mesh, Plane, Sphere
from warpfluid.simulation.triangles import box_surface, check_closed, cover, weigh

GRID = (20, 22, 18)
CENTRE = np.array([9.3, 8.1, 11.2])  # (x, y, z)


def points(first=(0.0, 0.0, 0.0)):
    """Where the voxels are, (x, y, z) along the last axis, in an array (x, z, y)."""
    x, z, y = np.meshgrid(*(np.arange(n) + f for n, f in zip(GRID, first, strict=True)), indexing="ij")
    return np.stack([x, y, z], axis=-1)


def measured(solids, device, **options):
    return signed_distance(solids, GRID, wp.get_device(device), **options).numpy()


def ball_surface(radius, rings=24):
    """A sphere of triangles between rings of points and two poles."""
    polar, around = np.meshgrid(
        np.pi * np.arange(1, rings) / rings, np.pi * np.arange(2 * rings) / rings, indexing="ij"
    )
    ring = np.stack([np.sin(polar) * np.cos(around), np.cos(polar), np.sin(polar) * np.sin(around)], axis=-1)
    vertices = np.concatenate([ring.reshape(-1, 3), [[0, 1, 0], [0, -1, 0]]]) * radius
    n, at = 2 * rings, lambda i, j: i * 2 * rings + j % (2 * rings)
    triangles = [(at(0, j + 1), at(0, j), len(vertices) - 2) for j in range(n)]
    triangles += [(at(rings - 2, j), at(rings - 2, j + 1), len(vertices) - 1) for j in range(n)]
    for i in range(rings - 2):
        for j in range(n):
            a, b, c, d = at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)
            triangles += [(a, b, c), (a, c, d)]
    return vertices, np.array(triangles)


def test_sphere(device):
    """Distance to the centre minus the radius, at voxels' centres and corners."""
    for first in ((0.0, 0.0, 0.0), (-0.5, -0.5, -0.5)):
        expected = np.linalg.norm(points(first) - CENTRE, axis=-1) - 5.5
        found = measured([Placed(Sphere(5.5), CENTRE)], device, first=first)
        np.testing.assert_allclose(found, expected, atol=1e-5)


def test_box_turned(device):
    """Distance to the nearest point of the box, and to the nearest side inside."""
    rotation = rotation_of_degrees((20, 35, -50))
    half = np.array([4.0, 2.5, 3.0])
    local = (points() - CENTRE) @ rotation
    beyond = np.abs(local) - half
    expected = np.linalg.norm(np.maximum(beyond, 0), axis=-1) + np.minimum(beyond.max(axis=-1), 0)
    np.testing.assert_allclose(measured([Placed(Box(2 * half), CENTRE, rotation)], device), expected, atol=1e-5)


def test_cylinder_is_upright(device):
    """Its distance does not change along y between its ends."""
    found = measured([Placed(Cylinder(4.0, 6.0), CENTRE)], device)
    offset = points() - CENTRE
    aside, above = np.hypot(offset[..., 0], offset[..., 2]) - 4.0, np.abs(offset[..., 1]) - 3.0
    expected = np.hypot(np.maximum(aside, 0), np.maximum(above, 0)) + np.minimum(np.maximum(aside, above), 0)
    np.testing.assert_allclose(found, expected, atol=1e-5)


def test_plane_is_height(device):
    """Above its middle."""
    np.testing.assert_allclose(measured([Placed(Plane(), (0, 3.25, 0))], device), points()[..., 1] - 3.25, atol=1e-5)


def test_nothing_is_far(device):
    """No shape is nearer than anything."""
    assert measured([], device).min() > 1e5


def test_union_is_the_nearest(device):
    """The lowest distance of all."""
    one, two = Placed(Sphere(3.0), CENTRE), Placed(Box((2, 9, 4)), CENTRE + 3)
    both = measured([one, two], device)
    np.testing.assert_array_equal(both, np.minimum(measured([one], device), measured([two], device)))


def test_mesh_of_a_sphere(device):
    """Inside and outside, to the error of its flat triangles."""
    placed = Placed(Mesh(*ball_surface(5.5)), CENTRE, rotation_of_degrees((10, 20, 30)))
    error = measured([placed], device) - measured([Placed(Sphere(5.5), CENTRE)], device)
    assert error.min() > -1e-4
    assert error.max() < 5.5 * (1 - np.cos(np.pi / 24) ** 2)


def test_mesh_beyond_its_band(device):
    """The same near the mesh, never too far away from it."""
    placed = Placed(Mesh(*ball_surface(4.0)), CENTRE)
    exact, banded = measured([placed], device), measured([placed], device, band=2.0)
    near = exact < 2.0
    np.testing.assert_array_equal(banded[near], exact[near])
    assert (banded <= exact + 1e-5).all()
    assert (banded[~near] > 0).all()


def test_mesh_turned_inside_out_is_the_same(device):
    """Triangles that look inwards are turned around."""
    vertices, triangles = ball_surface(5.5)
    there, back = (Placed(Mesh(vertices, faces), CENTRE) for faces in (triangles, triangles[:, ::-1]))
    np.testing.assert_allclose(measured([there], device), measured([back], device), atol=1e-5)


def test_mesh_of_a_box(device):
    """Exactly the box."""
    size = (7.0, 4.0, 5.0)
    error = measured([Placed(Mesh(*box_surface(size)), CENTRE)], device) - measured([Placed(Box(size), CENTRE)], device)
    assert np.abs(error).max() < 1e-4


@given(degrees=st.tuples(*[st.floats(-180, 180)] * 3))
@settings(max_examples=10)
def test_bounds_hold_the_shape(degrees):
    """No voxel outside the block lies inside the shape, however it is turned."""
    placed = Placed(Box((9, 3, 5)), CENTRE, rotation_of_degrees(degrees))
    first, size = placed.block(GRID, margin=0)
    inside = measured([placed], "cpu") < 0
    inside[tuple(slice(f, f + n) for f, n in zip(first, size, strict=True))] = False
    assert not inside.any()


def test_a_shape_outside_has_no_block():
    """Neither far away nor just beyond the side."""
    assert Placed(Sphere(2.0), (-9, 5, 5)).block(GRID) is None
    assert Placed(Sphere(2.0), (5, 30, 5)).block(GRID) is None


def test_weight_of_a_box():
    """Volume, centre and inertia in closed form, also away from the origin."""
    vertices, triangles = box_surface((2.0, 3.0, 5.0))
    volume, centre, inertia = weigh(vertices + np.array([7, -1, 2]), triangles)
    assert volume == pytest.approx(30)
    np.testing.assert_allclose(centre, [7, -1, 2])
    np.testing.assert_allclose(inertia, 30 / 12 * np.diag([9 + 25, 4 + 25, 4 + 9]), atol=1e-9)


def test_weight_of_a_ball():
    """Two fifths of mass times radius squared."""
    volume, _, inertia = weigh(*ball_surface(2.0, rings=40))
    assert volume == pytest.approx(4 / 3 * np.pi * 8, rel=0.01)
    np.testing.assert_allclose(inertia, np.eye(3) * 0.4 * volume * 4, rtol=0.01, atol=0.01)


def test_cover_is_even():
    """Points lie on the box, about as many as wanted, of shares that are near each other and sum to 1."""
    points, normals, shares = cover(*box_surface((4.0, 2.0, 6.0)), 200)
    assert 100 < len(points) < 500
    assert shares.sum() == pytest.approx(1)
    assert shares.max() < 4.1 * shares.min()
    np.testing.assert_allclose((np.abs(points) / [2, 1, 3]).max(axis=1), 1)
    assert (np.einsum("pi,pi->p", points, normals) > 0).all()
    np.testing.assert_allclose(shares @ points, 0, atol=1e-12)


def test_refuses_a_mesh_with_a_hole():
    """And says how large it is."""
    vertices, triangles = box_surface((1, 1, 1))
    with pytest.raises(ValueError, match=r"not closed: 3 of its edges"):
        Mesh(vertices, triangles[1:])
    check_closed(vertices, triangles)


def test_refuses_triangles_that_disagree():
    """One of them turned around."""
    vertices, triangles = box_surface((1, 1, 1))
    triangles[0] = triangles[0, ::-1]
    with pytest.raises(ValueError, match="different ways"):
        Mesh(vertices, triangles)


@pytest.mark.parametrize("vertex", [np.nan, np.inf])
def test_refuses_vertices_that_are_nowhere(vertex):
    """Before they reach a kernel."""
    vertices, triangles = box_surface((1, 1, 1))
    vertices[0, 0] = vertex
    with pytest.raises(ValueError, match="finite"):
        Mesh(vertices, triangles)


@pytest.mark.parametrize(
    ("shape", "options"),
    [
        (Sphere(0.0), {}),
        (Box((1, -1, 1)), {}),
        (Sphere(1.0), {"centre": (0, 0)}),
        (Sphere(1.0), {"velocity": (0, np.nan, 0)}),
        (Sphere(1.0), {"rotation": np.diag([1, 1, -1])}),
        (Sphere(1.0), {"rotation": 2 * np.eye(3)}),
    ],
)
def test_refuses_senseless_places(shape, options):
    """Extents that are not positive, vectors that are none, mirrors."""
    with pytest.raises(ValueError, match=r"extent|expected"):
        Placed(shape, **options)
