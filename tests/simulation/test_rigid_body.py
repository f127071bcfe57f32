"""Bodies against closed forms: fall, bounce, slide, rest, and be carried; energy never grows at the ground."""

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st

from warpfluid.simulation.drag import flow_around
from warpfluid.simulation.placed import rotation_of_degrees
from warpfluid.simulation.rigid_body import RigidBody
from warpfluid.simulation.rigid_motion import advance
from warpfluid.simulation.shapes import Box, Mesh, Sphere
from warpfluid.simulation.solids import build_solids
from warpfluid.simulation.state import Faces, FluidState
from warpfluid.simulation.triangles import box_surface

GRAVITY, GROUND, FRAME = 141.0, -0.5, 1 / 24
BOX = Box((6.0, 4.0, 8.0))


def body(**options):
    return RigidBody(**{"shape": BOX, "position": (3.0, 1.5, 5.0)} | options)


def run(thing, frames, **options):
    """Positions after every frame."""
    places = []
    for _ in range(frames):
        advance(thing, FRAME, gravity=GRAVITY, **options)
        places.append(thing.position.copy())
    return np.array(places)


def total_energy(thing):
    return thing.energy + thing.mass * GRAVITY * (thing.position[1] - GROUND)


def lowest(thing):
    return thing.surface()[0][:, 1].min() - GROUND


def test_free_fall_is_exact():
    """Position and speed after any number of steps; a turning about a main axis goes on."""
    thing = body(position=(0, 900, 0), velocity=(10, 20, -5), spin=(0, 3, 0))
    places = run(thing, 48)
    t = FRAME * np.arange(1, 49)[:, None]
    expected = [0, 900, 0] + t * [10, 20, -5] - 0.5 * GRAVITY * t**2 * [0, 1, 0]
    np.testing.assert_allclose(places, expected, atol=1e-7)
    np.testing.assert_allclose(thing.spin, [0, 3, 0], atol=1e-9)
    np.testing.assert_allclose(thing.rotation, rotation_of_degrees((0, np.rad2deg(6.0), 0)), atol=1e-9)


def test_tumbling_keeps_energy_and_nearly_its_momentum():
    """Torque-free turning about no main axis (Euler's equations)."""
    thing = body(position=(0, 1e4, 0), spin=(4.0, 0.5, 1.0))
    rotation = thing.rotation
    momentum, energy = rotation @ thing.inertia @ rotation.T @ thing.spin, thing.energy
    for _ in range(24):
        advance(thing, FRAME)
    rotation = thing.rotation
    after = rotation @ thing.inertia @ rotation.T @ thing.spin
    assert thing.energy == pytest.approx(energy, rel=1e-12)
    np.testing.assert_allclose(after, momentum, atol=0.002 * np.linalg.norm(momentum))
    assert np.linalg.norm(thing.spin - [4.0, 0.5, 1.0]) > 0.5


@pytest.mark.parametrize("restitution", [0.3, 0.7])
def test_bounces_return_the_square_of_restitution(restitution):
    """Each top is that share of the one before."""
    thing = body(position=(0, 201.5, 0), restitution=restitution)
    heights = []
    for _ in range(1500):
        advance(thing, 1 / 240, gravity=GRAVITY)
        heights.append(thing.position[1] - 1.5)
    h = np.array(heights)
    tops = h[1:-1][(h[1:-1] > h[:-2]) & (h[1:-1] >= h[2:])]
    assert tops[0] == pytest.approx(200 * restitution**2, rel=0.01)
    assert tops[1] == pytest.approx(200 * restitution**4, rel=0.01)


@pytest.mark.parametrize("friction", [0.2, 0.6])
def test_sliding_stops(friction):
    """After v^2 / (2 friction gravity), straight ahead and upright."""
    thing = body(velocity=(30, 0, 40), friction=friction)
    start = thing.position.copy()
    way = (run(thing, 72) - start)[-1]
    assert np.linalg.norm(way) == pytest.approx(50**2 / (2 * friction * GRAVITY), rel=0.02)
    np.testing.assert_allclose(way / np.linalg.norm(way), [0.6, 0, 0.8], atol=1e-3)
    np.testing.assert_allclose(thing.rotation, np.eye(3), atol=1e-3)
    assert thing.asleep


def test_no_friction_slides_on():
    """Without losing speed."""
    thing = body(velocity=(7, 0, 0), friction=0.0)
    run(thing, 24)
    np.testing.assert_allclose(thing.velocity, [7, 0, 0], atol=1e-6)


def test_rests_without_jitter():
    """Laid on the ground it does not move by a hundredth of a voxel, and falls asleep."""
    thing = body()
    places = run(thing, 24)
    assert np.abs(places - [3, 1.5, 5]).max() < 0.01
    assert thing.asleep
    assert (places[-1] == places[-6]).all()


@given(
    degrees=st.tuples(*[st.floats(-180, 180)] * 3),
    velocity=st.tuples(*[st.floats(-80, 80)] * 3),
    spin=st.tuples(*[st.floats(-9, 9)] * 3),
    restitution=st.floats(0, 1),
    friction=st.floats(0, 1),
)
@settings(max_examples=12)
def test_energy_never_grows_at_the_ground(degrees, velocity, spin, restitution, friction):
    """However it meets the ground, and no corner sinks into it."""
    thing = body(
        position=(0, 12, 0),
        rotation=rotation_of_degrees(degrees),
        velocity=velocity,
        spin=spin,
        restitution=restitution,
        friction=friction,
    )
    energy = total_energy(thing)
    for _ in range(30):
        advance(thing, FRAME, gravity=GRAVITY)
        now = total_energy(thing)
        assert now <= energy * (1 + 1e-9) + 1e-9
        assert lowest(thing) > -0.01
        energy = now


def test_a_tipped_box_falls_on_a_side():
    """It ends flat on one of its sides, asleep."""
    thing = body(position=(0, 20, 0), rotation=rotation_of_degrees((25, 10, 40)), restitution=0.2)
    run(thing, 96)
    assert thing.asleep
    assert min(abs(thing.position[1] - GROUND - half) for half in (3, 2, 4)) < 0.02


def uniform(speed, density=1.0):
    """A flow that is the same everywhere."""
    return lambda points: (np.broadcast_to(speed, points.shape), np.full(len(points), density))


@pytest.mark.parametrize(("coupling", "mass_density", "density"), [(2.0, 1.0, 1.0), (2.0, 4.0, 0.5), (1e6, 1.0, 1.0)])
def test_reaches_the_speed_of_the_flow(coupling, mass_density, density):
    """Exponentially, slower if heavy or if the air is thin, stable however strong."""
    thing = body(position=(0, 500, 0), coupling=coupling, mass_density=mass_density)
    for _ in range(24):
        advance(thing, FRAME, flow=uniform([8, 0, -4], density))
    share = 1 - np.exp(-coupling * density / mass_density)
    np.testing.assert_allclose(thing.velocity, np.array([8, 0, -4]) * share, atol=0.03)
    np.testing.assert_allclose(thing.spin, 0, atol=1e-6)


def test_a_vortex_turns_it():
    """To the vortex's own turning, the right way round."""
    thing = body(position=(0, 500, 0), coupling=5.0)

    def vortex(points):
        return np.cross([0, 2.0, 0], points - [0, 500, 0]), np.ones(len(points))

    for _ in range(60):
        advance(thing, FRAME, flow=vortex)
    np.testing.assert_allclose(thing.spin, [0, 2, 0], atol=0.02)


def test_empty_air_does_not_push():
    """Where the density is 0."""
    thing = body(position=(0, 500, 0), coupling=100.0)
    advance(thing, 1.0, flow=uniform([50, 0, 0], 0.0))
    np.testing.assert_array_equal(thing.velocity, 0)


def test_a_gust_wakes_it():
    """A breeze does not."""
    thing = body(coupling=1.0)
    run(thing, 24)
    advance(thing, FRAME, gravity=GRAVITY, flow=uniform([1.0, 0, 0]))
    assert thing.asleep
    advance(thing, FRAME, gravity=GRAVITY, flow=uniform([400.0, 300.0, 0]))
    assert not thing.asleep
    assert thing.velocity[0] > 0


def test_flow_is_read_from_the_fluid(device):
    """Each component at its own faces, density against the reference, nothing outside of the box."""
    shape = (10, 12, 14)
    faces = Faces.zeros(shape, wp.get_device(device))
    for axis, part in enumerate(faces):  # a velocity that grows linearly: interpolation is exact
        at = np.indices(part.shape).astype(np.float32)
        at[axis] -= 0.5
        part.assign((axis + 1) * at[0] - at[1] + 2 * at[2])
    cells = [wp.full(shape, value, dtype=float, device=device) for value in (3.0, 0.0, 0.0, 0.0)]
    points = np.array([[4.3, 7.1, 5.8], [2.0, 3.0, 4.0], [-3.0, 3.0, 4.0]])
    speeds, shares = flow_around(FluidState(faces, *cells), 6.0)(points)
    x, y, z = points[:2].T
    np.testing.assert_allclose(
        speeds[:2], np.stack([x - z + 2 * y, 3 * x - z + 2 * y, 2 * x - z + 2 * y], 1), rtol=1e-5
    )
    np.testing.assert_allclose(shares, [0.5, 0.5, 0])


def test_a_body_is_an_obstacle(device):
    """Its place, its turning and its speeds reach the grid."""
    thing = body(position=(12, 11, 13), rotation=rotation_of_degrees((0, 30, 0)), velocity=(1, 2, 3), spin=(0, 1, 0))
    solids = build_solids([thing.placed()], (26, 26, 24), wp.get_device(device))
    assert (1 - solids.fluid.numpy()).sum() == pytest.approx(thing.volume, rel=0.08)
    assert solids.velocity.y.numpy()[12, 13, 11] == 2


def test_a_mesh_is_the_same_as_its_box():
    """Wherever its file has the origin: bodies turn about their centre of mass."""
    vertices, triangles = box_surface(BOX.size)
    mesh = body(shape=Mesh(vertices + np.array([7, 8, 9]), triangles), position=(0, 30, 0), spin=(1, 2, 3))
    box = body(position=(0, 30, 0), spin=(1, 2, 3))
    assert mesh.mass == pytest.approx(box.mass, rel=1e-5)
    np.testing.assert_allclose(run(mesh, 20), run(box, 20), atol=1e-3)


def test_a_restored_body_goes_on_to_the_bit():
    """From plain arrays, as a checkpoint stores them."""
    options = {"position": (0, 9, 0), "spin": (3, 1, 2), "velocity": (20, 0, 0)}
    thing, other = body(**options), body()
    run(thing, 7)
    state = thing.state()
    assert all(isinstance(array, np.ndarray) for array in state.values())
    other.restore(state)
    np.testing.assert_array_equal(run(thing, 9), run(other, 9))


@pytest.mark.parametrize(
    "options",
    [{"mass_density": 0}, {"restitution": 1.5}, {"friction": -1}, {"coupling": np.inf}, {"position": (0, np.nan, 0)}],
)
def test_refuses_senseless_numbers(options):
    """The message says what is needed."""
    with pytest.raises(ValueError, match=r"needs|finite"):
        body(**options)


def test_refuses_other_shapes():
    """Only boxes and meshes have corners to stand on."""
    with pytest.raises(ValueError, match="Box or a Mesh"):
        body(shape=Sphere(3.0))


def test_refuses_a_flow_that_is_not_finite():
    """Before the body is nowhere."""
    with pytest.raises(FloatingPointError, match="fluid"):
        advance(body(), FRAME, flow=uniform([np.nan, 0, 0]))
    with pytest.raises(ValueError, match="time_step"):
        advance(body(), 0.0)
