"""Forces of place against their closed forms."""

import numpy as np
import pytest
from mac import (
    ALL_CLOSED,
    ALL_OPEN,
    ALL_WRAP,
    SHAPE,
    SIDES,
    places,
    pushed,
    random_faces,
    six,
    still,
    without_walls,
    wraps,
)

from warpfluid.kernels.forces.pushes import KINDS, add_push

CENTRE, RADIUS, DIRECTION = (4.2, 2.9, 20.3), 6.0, (1.0, -2.0, 2.0)


def law(kind, d):
    """Acceleration at places d from the centre, (x, z, y)."""
    unit = np.array(DIRECTION) / 3
    r = np.linalg.norm(d, axis=-1, keepdims=True)
    if kind == "uniform":
        return np.exp(-(r**2) / 2 / RADIUS**2) * unit
    if kind == "radial":
        return d / RADIUS * np.exp((1 - r**2 / RADIUS**2) / 2)
    if kind == "attractor":
        return -(RADIUS**2) * d / (r**2 + RADIUS**2) ** 1.5
    swap = [0, 2, 1]  # to (x, y, z), which is right-handed
    around = np.cross(unit[swap], d[..., swap])[..., swap]
    off = np.linalg.norm(around, axis=-1, keepdims=True)
    return around / RADIUS * np.exp((1 - off**2 / RADIUS**2) / 2)


@pytest.mark.parametrize("sides", SIDES)
@pytest.mark.parametrize("kind", KINDS)
def test_is_the_law(kind, sides, device):
    """Every component at its own faces; the shortest way where the box wraps."""
    faces, changes = random_faces(sides=sides), []
    for axis, place in enumerate(places()):
        d = place - CENTRE
        for k in range(3):
            if wraps(sides, k):
                d[..., k] -= SHAPE[k] * np.round(d[..., k] / SHAPE[k])
        changes.append(0.1 * 5 * law(kind, d)[..., axis])
    changes = without_walls(changes, sides)
    others = {"kind": kind, "strength": 5.0, "centre": CENTRE, "radius": RADIUS, "direction": DIRECTION}
    got = pushed(add_push, faces, device, **others, time_step=0.1, sides=six(sides))
    for axis in range(3):
        np.testing.assert_allclose(got[axis], faces[axis] + changes[axis], atol=2e-6)
        if wraps(sides, axis):
            ends = np.moveaxis(got[axis], axis, 0)
            np.testing.assert_array_equal(ends[0], ends[-1])


def test_uniform_push_needs_no_radius(device):
    """Then it is the same everywhere, and closed walls let nothing through."""
    others = {"kind": "uniform", "strength": 6.0, "direction": DIRECTION, "time_step": 0.5}
    got = pushed(add_push, still(), device, **others, sides=six(ALL_OPEN))
    for face, expected in zip(got, (1, -2, 2), strict=True):
        np.testing.assert_allclose(face, expected, rtol=1e-6)
    got = pushed(add_push, still(), device, **others, sides=six(ALL_CLOSED))
    assert not got[0][[0, -1]].any()
    assert got[0][1:-1].all()


def test_vortex_turns_counterclockwise_from_above(device):
    """Right of an upright axis gas goes away from the viewer, who is at high z."""
    others = {"kind": "vortex", "strength": 1.0, "centre": (4, 3, 20), "radius": 2.0, "time_step": 1.0}
    got = pushed(add_push, still(), device, **others, sides=six(ALL_OPEN))
    assert (got[1][5:, 3:5] < 0).all()
    assert (got[1][:4, 3:5] > 0).all()
    assert not got[2].any()


def test_far_away_an_attractor_obeys_the_inverse_square(device):
    """Twice as far, a quarter of the pull."""
    others = {"kind": "attractor", "strength": 1.0, "centre": (0, 0, -0.5), "radius": 0.1, "time_step": 1.0}
    got = pushed(add_push, still((1, 1, 60)), device, **others, sides=six(ALL_OPEN))[2][0, 0]
    assert got[20] / got[40] == pytest.approx(4, rel=1e-3)
    assert got[40] == pytest.approx(-0.01 / 40**2, rel=1e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_no_strength_keeps_the_bits(kind, device):
    """Not even -0 becomes 0."""
    faces = [-face * (face > 0) for face in random_faces()]
    got = pushed(add_push, faces, device, kind=kind, strength=0.0, radius=2.0, time_step=0.1, sides=six(ALL_WRAP))
    for before, after in zip(faces, got, strict=True):
        np.testing.assert_array_equal(before.view(np.int32), after.view(np.int32))


@pytest.mark.parametrize(
    ("wrong", "word"),
    [
        ({"kind": "magic"}, "kind"),
        ({"kind": "radial"}, "radius"),
        ({"kind": "uniform", "radius": -1.0}, "radius"),
        ({"kind": "uniform", "direction": (0, 0, 0)}, "direction"),
    ],
)
def test_refuses_senseless_arguments(wrong, word, device):
    """Each is named."""
    with pytest.raises(ValueError, match=word):
        pushed(add_push, still(), device, strength=1.0, time_step=0.1, sides=six(ALL_OPEN), **wrong)
