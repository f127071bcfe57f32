"""Solids that touch, overlap and press out what is between them."""

import numpy as np
import pytest
import warp as wp

from warpfluid.kernels.poisson.squeeze import measure_squeeze
from warpfluid.simulation.placed import Placed, rotation_of_degrees
from warpfluid.simulation.pressure import make_incompressible
from warpfluid.simulation.shapes import Box, Cylinder, Sphere
from warpfluid.simulation.solids import build_solids
from warpfluid.simulation.state import Faces, six_sides

GRID = (20, 18, 22)
SIDES = six_sides("open", "open", "closed-low")
MIDDLE = (10.2, 10.7, 9.1)  # (x, y, z)
DOWN = (0.0, -1.0, 0.0)


def squeeze(placed, device):
    solids = build_solids(placed, GRID, wp.get_device(device))
    faces = {f"open_{axis}": getattr(solids.open, axis) for axis in "xzy"}
    faces |= {f"solid_{axis}": getattr(solids.velocity, axis) for axis in "xzy"}
    out = wp.full(GRID, np.nan, dtype=float, device=device)
    return measure_squeeze(**faces, fluid=solids.fluid, sides=SIDES, out=out).numpy()


def pressed(placed, device):
    """Return how fast still fluid becomes, measured by the fastest solid, and the share of the divergence left."""
    solids, velocity = build_solids(placed, GRID, wp.get_device(device)), Faces.zeros(GRID, wp.get_device(device))
    done = make_incompressible(velocity, SIDES, solids=solids)
    speeds = [np.abs(u.numpy()[o.numpy() > 0]).max() for u, o in zip(velocity, solids.open, strict=True)]
    return max(speeds) / max(np.abs(part.numpy()).max() for part in solids.velocity), done.relative


@pytest.mark.parametrize("seed", range(12))
def test_fluid_is_not_much_faster_than_what_squeezes_it(seed, device):
    """Two shapes at random places that often overlap, one of them moving and turning."""
    rng = np.random.default_rng(seed)
    shapes = [Box((9.0, 4.0, 6.0)), Sphere(4.4), Cylinder(3.7, 6.0)]
    one, other = (shapes[k] for k in rng.integers(3, size=2))
    turns = [rotation_of_degrees(rng.uniform(-180, 180, 3)) for _ in range(2)]
    still = Placed(one, MIDDLE, turns[0])
    beside = np.array(MIDDLE) + rng.uniform(-6, 6, 3)
    moving = Placed(other, beside, turns[1], rng.uniform(-1, 1, 3), rng.uniform(-0.1, 0.1, 3))
    faster, left = pressed([still, moving], device)
    assert faster < 6
    assert left < 1e-4


@pytest.mark.parametrize("height", np.arange(3.1, 4.5, 0.2))
def test_neither_is_what_the_floor_squeezes(height, device):
    """A ball that sinks through the floor's last voxel."""
    assert pressed([Placed(Sphere(3.9), (10.2, height, 9.1), velocity=DOWN)], device)[0] < 8


def test_a_solid_alone_asks_for_nothing(device):
    """However it moves and turns."""
    turned = rotation_of_degrees((20.0, 30.0, 40.0))
    found = squeeze([Placed(Box((7.0, 5.0, 6.0)), MIDDLE, turned, (3.0, -2.0, 1.0), (0.4, 0.3, -0.2))], device)
    np.testing.assert_allclose(found, 0, atol=1e-5)


@pytest.mark.parametrize("lift", [-0.05, -0.001, 0.001])
@pytest.mark.parametrize("gap", [-0.1, 0.02, 0.1, 0.4])
def test_a_slit_along_the_grid(lift, gap, device):
    """Level plates whose slit, finer than a voxel, lies where corners of voxels see it, or just not."""
    top = 8.5 + lift
    table = Placed(Box((10.0, 6.0, 9.0)), (10.0, top - 3.0, 9.0))
    press = Placed(Box((8.0, 6.0, 9.0)), (10.3, top + gap + 3.0, 9.2), velocity=DOWN)
    assert pressed([table, press], device)[0] < 12


@pytest.mark.parametrize("share", [0.05, 0.1, 0.3])
def test_plates_that_near_each_other(share, device):
    """Two voxels between, each with four sides as wide as its share; where they make a whole face, nothing is lost."""
    table = Placed(Box((40.0, 8.0, 40.0)), (10.0, 4.5 - share, 9.0))
    press = Placed(Box((40.0, 6.0, 40.0)), (10.0, 11.5 + share, 9.0), velocity=DOWN)
    found = squeeze([table, press], device)[5:-5, 5:-5].sum(axis=-1)
    closed = 1 - share  # what counts as closed of the face between
    np.testing.assert_allclose(found, -2 * closed / (1 + closed) * max(1 - 5 * share, 0), atol=1e-4)
