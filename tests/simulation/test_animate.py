"""Frames that follow volumes: what the footage asks for, whatever its weight, and who is blamed when it fails."""

import numpy as np
import pytest

from warpfluid.device import pick_device
from warpfluid.files.npz import write_npz
from warpfluid.options import THINGS, OutputOptions, Scene, SimulateOptions
from warpfluid.options.scene import parse_thing
from warpfluid.run import Run
from warpfluid.simulation.animate import Animator
from warpfluid.simulation.animation import Animation
from warpfluid.simulation.checkpoint import load_state, save_state
from warpfluid.simulation.source import fill_box
from warpfluid.volumes import open_volumes

SHAPE = (16, 16, 24)


@pytest.fixture
def blobs(tmp_path):
    """A blob that rises two voxels a frame."""
    x, z, y = np.ogrid[: SHAPE[0], : SHAPE[1], : SHAPE[2]]
    for frame in (1, 2, 3):
        far = (x - 7.5) ** 2 + (z - 7.5) ** 2 + (y - 6 - 2 * frame) ** 2
        write_npz(tmp_path / f"blob.{frame}.npz", np.exp(-far / 8).astype(np.float32).transpose(0, 2, 1))
    return fill_box(open_volumes(tmp_path))


def animator(source, device, *, frames=(1, 2, 3), things=None, **options) -> Animator:
    scene = {kind: tuple(parse_thing(kind, line) for line in (things or {}).get(kind, ())) for kind in THINGS}
    plan = Animation(
        source=source,
        options=SimulateOptions(**options),
        scene=Scene(**scene),
        output=OutputOptions(),
        device=pick_device(device),
    )
    return Animator(plan, frames)


UNPULLED = [{"fidelity": 0.0}, {"fidelity": 0.05, "guide_weight": "0"}]


@pytest.mark.parametrize("options", [{}, {"fps": 12.0}, *UNPULLED])
def test_it_starts_with_the_motion_of_the_footage(blobs, device, options):
    """psi = omega at the first frame, in voxels a second, however little the footage counts afterwards."""
    state = animator(blobs, device, **options).state
    inside = blobs.volume(1) > 0.3 * blobs.volume(1).max()
    rise = (state.velocity.y.numpy()[..., 1:] + state.velocity.y.numpy()[..., :-1])[inside].mean() / 2
    assert rise / options.get("fps", 24.0) == pytest.approx(2, abs=0.7)
    usual = animator(blobs, device, **({"fps": options["fps"]} if "fps" in options else {})).state
    np.testing.assert_array_equal(state.velocity.y.numpy(), usual.velocity.y.numpy())


@pytest.mark.parametrize("options", UNPULLED)
def test_an_unpulled_fluid_is_carried_away(blobs, device, options):
    """Without the footage's pull on the motion, wind takes the blob along, and the volume is moved there to follow."""
    moved = animator(blobs, device, wind="40,0,0", wind_drag=20.0, **options)
    assert moved.advance(1, 2) > 0
    density = moved.state.density.numpy()
    middle = (density.sum(axis=(1, 2)) * np.arange(SHAPE[0])).sum() / density.sum()
    assert middle > 7.5 + 0.3
    assert moved.state.away[0].numpy()[density > 0.3 * density.max()].mean() > 0.5


def test_nothing_is_carried_away_without_an_edit(blobs, device):
    """The fluid goes where the footage goes."""
    still = animator(blobs, device)
    still.advance(1, 2)
    assert still.state.away is None


@pytest.mark.parametrize(
    ("options", "things", "blamed"),
    [
        ({"density_buoyancy": 20.0, "swirl": 5.0}, {}, "lower --density-buoyancy, or raise --max-substeps"),
        ({"swirl": 5.0, "substeps": 3}, {}, "lower --swirl, or raise --substeps"),
        ({"turbulence_strength": 4.0}, {}, "lower --turbulence-strength"),
        ({}, {"force": ["uniform strength=500 direction=1,0,0"]}, "lower the strength of the forces"),
        ({}, {"emitter": ["sphere center=0,2,0 velocity=0,90,0 drive=1"]}, "lower the velocity of the emitters"),
        ({}, {"obstacle": ["sphere center=1:0,2,0;2:40,2,0 radius=3"]}, "lower the speed of the obstacles"),
        ({}, {}, "raise --max-substeps, or lower --guide-weight"),
    ],
)
def test_who_is_blamed(blobs, device, options, things, blamed):
    """The setting that drives the fluid most."""
    fluid = animator(blobs, device, things=things, **options)
    assert blamed in fluid._cause(1, 2)


SLAB = {"obstacle": ["box center=0,5,0 size=6.7,0.9,6.7"]}


def test_an_obstacle_is_empty_from_the_first_frame(blobs, device):
    """What the volume has there is taken away before anything is written."""
    state = animator(blobs, device, things=SLAB, combustion=True).state
    inside = animator(blobs, device, things=SLAB).scenery.solids(1, 2, 1.0).fluid.numpy() == 0
    assert blobs.volume(1)[inside].max() > 0
    for field in (state.density, state.temperature, state.fuel):
        assert field.numpy().max() > 0
        assert field.numpy()[inside].max() == 0


def test_an_obstacle_keeps_the_footage_from_what_lies_behind(blobs, device):
    """The blob rises against a slab as wide as the box: what the volumes show above it is hardly made anew."""
    above = {}
    for name, things in (("free", {}), ("stopped", SLAB)):
        fluid = animator(blobs, device, things=things, fidelity=0.05)
        fluid.advance(1, 2)
        fluid.advance(2, 3)
        above[name] = fluid.state.density.numpy()[..., 15:].sum()
    assert above["stopped"] < 0.5 * above["free"]


def test_a_shadow_goes_on_after_a_stop(blobs, device, tmp_path):
    """It is stored with the state."""
    fluid, run = animator(blobs, device, things=SLAB), Run(tmp_path)
    fluid.advance(1, 2)
    save_state(run, 2, fluid.state, [])
    other = animator(blobs, device, things=SLAB)
    assert load_state(run, other.state, []) == 2
    np.testing.assert_array_equal(other.state.shadow.numpy(), fluid.state.shadow.numpy())
