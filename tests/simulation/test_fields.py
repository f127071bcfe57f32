"""Numbers that depend on the fluid, that are keyed, and forces that act somewhere only."""

import numpy as np
import pytest
import warp as wp

from warpfluid.kernels.forces.swirl import add_swirl
from warpfluid.options import THINGS, ForceOptions, Scene, SimulateOptions
from warpfluid.options.scene import parse_thing
from warpfluid.simulation.animation import Animation, fidelity_at
from warpfluid.simulation.fields import mark_fluid, number_or_field
from warpfluid.simulation.forces import SWIRL_UNITS, add_forces, place_force
from warpfluid.simulation.guidance import follow
from warpfluid.simulation.physics import Physics
from warpfluid.simulation.placing import Placing
from warpfluid.simulation.solver import Solver, Surroundings
from warpfluid.simulation.state import Faces, FluidState, face_shape, six_sides

SHAPE, FULL = (16, 16, 40), 2.0
PLACING = Placing(SHAPE, FULL)
SIDES = six_sides("open", "open", "closed-low")


def physics(**choices) -> Physics:
    return Physics(SimulateOptions(**choices), PLACING, SIDES)


def stirred(device, *, density=FULL) -> FluidState:
    """Return a fluid of random motion, with density in its lower half."""
    rng = np.random.default_rng(1)
    faces = [rng.normal(size=face_shape(SHAPE, axis)) for axis in range(3)]
    cells = [np.zeros(SHAPE) for _ in range(4)]
    cells[0][..., :20] = density
    arrays = [wp.array(array, dtype=float, device=device) for array in (*faces, *cells)]
    return FluidState(Faces(*arrays[:3]), *arrays[3:])


def pushed(state: FluidState, **choices) -> list[np.ndarray]:
    """Return what forces add to the velocity in a tenth of a second."""
    before = [part.numpy().copy() for part in state.velocity]
    add_forces(physics(**choices), state, 1, 0.1, ())
    return [part.numpy() - old for part, old in zip(state.velocity, before, strict=True)]


def test_a_constant_ramp_swirls_as_a_number(device):
    """Bit for bit as vorticity confinement of that strength without a mask."""
    expected, found = stirred(device), stirred(device)
    strength = 3.0 * SWIRL_UNITS * PLACING.unit
    add_swirl(*expected.velocity, strength=strength, sides=SIDES, time_step=0.1)
    add_forces(physics(swirl="density 0:3"), found, 1, 0.1, ())
    for one, other in zip(expected.velocity, found.velocity, strict=True):
        np.testing.assert_allclose(other.numpy(), one.numpy(), rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("swirl", [3.0, "density 0:0;1:3"])
def test_clear_air_is_not_swirled(device, swirl):
    """A number acts where there is fluid, a ramp where it is not 0; at full density both are the same."""
    change = pushed(stirred(device), swirl=swirl)
    whole = pushed(stirred(device), swirl="density 0:3")
    for part, all_of_it in zip(change, whole, strict=True):
        assert not part[:, :, 22:].any()
        np.testing.assert_allclose(part[:, :, :19], all_of_it[:, :, :19], rtol=1e-5, atol=1e-6)


def test_heat_and_fuel_are_fluid(device):
    """What is hot swirls, smoke or not; what is cold does not by that alone."""
    state = stirred(device, density=0.5 * FULL)
    temperature, fuel = np.zeros(SHAPE), np.zeros(SHAPE)
    temperature[:8], temperature[8:, :8], fuel[0] = 0.25, -5, FULL
    state.temperature, state.fuel = (wp.array(a, dtype=float, device=device) for a in (temperature, fuel))
    mask = mark_fluid(state, FULL).numpy()
    assert mask[0, 0, 30] == 1
    np.testing.assert_allclose(mask[4, 0, [5, 30]], [0.75, 0.25])
    np.testing.assert_allclose(mask[12, 0, [5, 30]], [0.5, 0])


def test_fields_come_in_their_units(device):
    """Full density is 1, speed is in units, a tenth of the height, a second."""
    state = stirred(device)
    for part, speed in zip(state.velocity, (0.0, 12.0, 0.0), strict=True):
        part.fill_(speed)
    density = number_or_field("density 0:0;1:1", 1, state, PLACING).numpy()
    np.testing.assert_allclose(density[0, 0, [5, 30]], [1, 0])
    speed = number_or_field("speed 0:0;10:10", 1, state, PLACING).numpy()
    np.testing.assert_allclose(speed, 3, rtol=1e-6)
    assert number_or_field("1:0;3:4", 2, state, PLACING) == 2


@pytest.mark.parametrize("subtract", [0.0, 0.5])
def test_blending_by_a_field(device, subtract):
    """A constant one is the number; 0 somewhere leaves it alone there."""
    rng = np.random.default_rng(2)
    density, volume = (wp.array(rng.random(SHAPE), dtype=float, device=device) for _ in range(2))
    expected, found, none = wp.clone(density), wp.clone(density), wp.clone(density)
    follow(expected, volume, weight=0.3, subtract=subtract)
    follow(found, volume, weight=wp.full(SHAPE, 0.3, dtype=float, device=device), subtract=subtract)
    np.testing.assert_allclose(found.numpy(), expected.numpy(), rtol=1e-6)
    follow(none, volume, weight=wp.zeros(SHAPE, dtype=float, device=device), subtract=subtract)
    np.testing.assert_array_equal(none.numpy(), density.numpy())


@pytest.mark.parametrize("name", ["guide_radius", "max_temperature", "swirl", "blend"])
def test_keyed_numbers_hit_their_keys(name):
    """At their frames, and between them on a line."""
    made = physics(**{name: "10:0.5;20:1"})
    assert [made.number(name, frame) for frame in (1, 10, 15, 20, 30)] == [0.5, 0.5, 0.75, 1, 1]


def test_keyed_fidelity_hits_its_keys():
    """The footage lets go over the frames."""
    options = SimulateOptions(fidelity="1:1;5:0")
    animation = Animation(source=None, options=options, scene=None, output=None, device=None)
    assert [animation.fidelity(frame) for frame in (1, 3, 5)] == [1, 0.5, 0]


@pytest.mark.parametrize(
    ("options", "things", "expected"),
    [
        ({}, {}, 1),
        ({"resolution_scale": 0.5}, {}, 1),
        ({"turbulence_strength": 0.5}, {}, 0.3),
        ({}, {"emitter": "sphere"}, 0.3),
        ({}, {"body": "box obstacle=false"}, 1),
        ({}, {"body": "box"}, 0.1),
        ({"wind": "2,0,0"}, {}, 0.3),
        ({"turbulence_strength": 0.5}, {"obstacle": "box"}, 0.1),
        ({}, {"force": "vortex"}, 0.3),
        ({"fidelity": 0.7}, {"obstacle": "box"}, 0.7),
    ],
)
def test_how_far_the_footage_gives_way(options, things, expected):
    """Not without an edit, most where matter is stopped; what is asked for counts."""
    scene = {kind: (parse_thing(kind, things[kind]),) if kind in things else () for kind in THINGS}
    assert fidelity_at(SimulateOptions(**options), Scene(**scene), 1) == expected


def blown(kind, device, sides="open", **choices):
    """Return the acceleration of resting, mostly clear air along x and y by a wind of 2 units a second, over it."""
    state = stirred(device)
    state.velocity = Faces.zeros(SHAPE, wp.get_device(device))
    state.velocity.y.fill_(1.0)
    options = ForceOptions(kind=kind, strength=1.0, direction="2,0,0", **choices)
    box = Physics(SimulateOptions(), PLACING, six_sides(sides, "open", "closed-low"))
    add_forces(box, state, 2, 1e-3, (place_force(options, PLACING, 2),))
    return state.velocity.x.numpy()[8] / (8.0 * 1e-3), (1 - state.velocity.y.numpy()[8]) / 1e-3


def test_a_fan_blows_where_it_is(device):
    """Fully in its centre, as a Gaussian around it, in clear air too; its radius is keyed."""
    along, _ = blown("wind", device, radius="1:1;3:3", center="0,7.625,0")
    expected = np.exp(-0.5 * (8 / 8) ** 2) * np.exp(-0.5 * (0.5 / 8) ** 2)
    np.testing.assert_allclose(along[7:9, 38].mean(), expected, rtol=2e-2)


def test_a_wind_moves_the_whole_box(device):
    """Clear air too, and what rises goes on rising; between two walls only the fluid, and drag never clear air."""
    along, rising = blown("wind", device)
    np.testing.assert_allclose(along, 1, rtol=2e-3)
    assert not rising.any()
    assert not blown("wind", device, "closed")[0][7:9, 38].any()
    assert not blown("drag", device)[1][7:9, 38].any()
    assert blown("drag", device)[1].max() > 0.1


def test_more_steps_move_farther(device):
    """What 8 steps a frame cannot follow, 80 may."""
    state = stirred(device)
    state.velocity.x.fill_(24 * 2.5 * max(SHAPE))
    with pytest.raises(FloatingPointError, match="voxels a frame"):
        Solver(physics())._substeps(state, 1 / 24, Surroundings())
    assert Solver(physics(substeps=24))._substeps(state, 1 / 24, Surroundings()) == 24
