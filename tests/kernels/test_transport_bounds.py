"""Native code of transport and diffusion never reads or writes what lies around its arrays in memory."""

import numpy as np
import pytest
import warp as wp

from warpfluid.simulation.state import Faces, face_shape, six_sides
from warpfluid.simulation.transport import SCHEMES, advect_scalar, advect_velocity, diffuse

GUARD = 4096
BOXES = {
    "open": six_sides("open", "open", "open"),
    "closed": six_sides("closed", "closed", "closed"),
    "wrap": six_sides("wrap", "wrap", "wrap"),
    "mixed": six_sides("wrap", "closed-high", "closed-low"),
}


def guarded(array, device):
    """A copy on the device, with NaN around it: the whole memory, and the part that holds the numbers."""
    memory = np.full(array.size + 2 * GUARD, np.nan, np.float32)
    memory[GUARD:-GUARD] = array.ravel()
    memory = wp.array(memory, device=device)
    return memory, memory[GUARD:-GUARD].reshape(array.shape)


def velocity_of(shape, name, speed, device):
    """Random, and at rest on walls; the faces that wrapping joins agree."""
    rng = np.random.default_rng(0)
    parts = []
    for axis in range(3):
        part = (speed * rng.standard_normal(face_shape(shape, axis))).astype(np.float32)
        ends = np.moveaxis(part, axis, 0)
        ends[-1] = ends[0]
        parts.append(guarded(part, device)[1])
    return Faces(*parts)


@pytest.mark.parametrize("name", BOXES)
@pytest.mark.parametrize("shape", [(1, 1, 1), (2, 1, 49), (1, 3, 96), (5, 4, 47), (3, 2, 2)])
def test_nothing_around_is_touched(shape, name, device):
    """Whatever the shape, near and far paths: NaN from around would spread, and stays where it is."""
    sides = BOXES[name]
    field = guarded(np.random.default_rng(1).random(shape).astype(np.float32), device)[1]
    for speed in (0.4, 30.0, 1e30):
        velocity = velocity_of(shape, name, speed, device)
        for scheme in SCHEMES:
            memory, out = guarded(np.zeros(shape), device)
            advect_scalar(field, velocity, sides, 0.5, scheme=scheme, out=out)
            assert np.isfinite(memory.numpy()[GUARD:-GUARD]).all()
            assert np.isnan(np.delete(memory.numpy(), np.s_[GUARD:-GUARD])).all()
            if speed < 1e30 or scheme == "semi-lagrangian":
                for part in advect_velocity(velocity, velocity, sides, 0.5, scheme=scheme):
                    assert np.isfinite(part.numpy()).all()
    for amount in (0.01, 20.0):
        memory, out = guarded(np.zeros(shape), device)
        diffuse(field, amount, sides, out=out)
        assert np.isfinite(memory.numpy()[GUARD:-GUARD]).all()
        assert np.isnan(np.delete(memory.numpy(), np.s_[GUARD:-GUARD])).all()
        for part in diffuse(velocity_of(shape, name, 1.0, device), amount, sides):
            assert np.isfinite(part.numpy()).all()


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_broken_velocity_stays_inside(value, device):
    """Where the velocity is no number some value of the field is read, or of the air outside."""
    shape = (3, 4, 50)
    field = guarded(np.full(shape, 2.0, np.float32), device)[1]
    for name, sides in BOXES.items():
        parts = [guarded(np.full(face_shape(shape, axis), value), device)[1] for axis in range(3)]
        for scheme in SCHEMES:
            out = advect_scalar(field, Faces(*parts), sides, 0.5, scheme=scheme).numpy()
            assert np.all((out >= 0) & (out <= 2)), name
