"""Fire, smoke, explosion and splash behave as what they are called, in a small box."""

from functools import cache

import numpy as np
import pytest
import warp as wp

from warpfluid.presets import preset_names, preset_settings
from warpfluid.projector import Projector
from warpfluid.settings import make_simulate_settings
from warpfluid.simulation.animate import Animator
from warpfluid.simulation.animation import Animation
from warpfluid.simulation.source import empty_box

SIZE = (24, 36)
UNIT = SIZE[1] / 10  # voxels of a tenth of the box's height
FRAMES = {"fire": 36, "smoke": 48, "explosion": 36, "splash": 36}
SECOND = 24  # frames
HEIGHTS = (np.arange(SIZE[1]) + 0.5) / UNIT


def play(name, last, **changes):
    """Return the densities of frames 2 to ``last``, and the totals of density and fuel together."""
    settings = make_simulate_settings(None, None, None, {}, size=SIZE, preset=name)
    options = settings.simulate
    for option, value in changes.items():
        object.__setattr__(options, option, value)
    source = empty_box(SIZE)
    animation = Animation(
        source=source, options=options, scene=settings.scene, output=settings.output, device=wp.get_device("cpu")
    )
    animator, volumes, matter = Animator(animation, (1,)), [], []
    for frame in range(1 - options.preroll, last):
        animator.advance(frame, frame + 1, follows=False)
        if frame >= 1:
            volumes.append(animator.state.density.numpy())
            matter.append(volumes[-1].sum(dtype=float) + animator.state.fuel.numpy().sum(dtype=float))
    return np.stack(volumes), np.array(matter)


@cache
def volumes(name):
    """Return a preset's densities of frames 2 and on, shape (frame, x, z, y)."""
    return play(name, FRAMES[name])[0]


def middles(name):
    """Return the height of the middle of a preset's density, by frame [unit]."""
    profiles = volumes(name).sum(axis=(1, 2))
    return profiles @ HEIGHTS / profiles.sum(axis=1)


def widths(name):
    """Return the standard deviation of a preset's density across, by frame [unit]."""
    profiles = volumes(name).sum(axis=(2, 3))
    x = (np.arange(SIZE[0]) + 0.5) / UNIT
    middle = profiles @ x / profiles.sum(axis=1)
    return np.sqrt((profiles * (x - middle[:, None]) ** 2).sum(axis=1) / profiles.sum(axis=1))


@pytest.mark.parametrize("name", preset_names())
def test_exposure(name):
    """Seen as footage is, a preset is neither dark nor white all over."""
    images = Projector([0.0], volumes(name)[0].shape, device="cpu").project(volumes(name)[len(volumes(name)) // 2])
    lit = images[images > 10]
    assert 100 < lit.max() < 600
    assert 30 < np.median(lit) < 200


@pytest.mark.parametrize("name", preset_names())
def test_finite_and_never_negative(name):
    """No preset leaves its bounds."""
    assert np.isfinite(volumes(name)).all()
    assert volumes(name).min() >= 0


def test_fire_ends_below_the_top_and_flickers():
    """The light is at the foot, little of it is left high up, and it never stands still."""
    fire = volumes("fire")
    profile = fire.sum(axis=(0, 1, 2))
    assert profile[HEIGHTS > 9].sum() < 0.02 * profile.sum()
    assert profile[HEIGHTS < 4].sum() > 0.6 * profile.sum()
    x = np.arange(SIZE[0]) / UNIT
    upper = fire[..., (HEIGHTS > 3) & (HEIGHTS < 7)].sum(axis=(2, 3))
    assert (upper @ x / upper.sum(axis=1)).std() > 0.05
    totals = fire.sum(axis=(1, 2, 3))
    assert totals.max() < 2 * totals.min()


def test_smoke_rises_and_grows():
    """The column climbs, and there is more of it every frame while it is let in."""
    totals = volumes("smoke").sum(axis=(1, 2, 3))
    assert (np.diff(totals) > 0).all()
    assert (np.diff(middles("smoke")[4:]) > 0).all()
    assert middles("smoke")[-1] > 2.5


def test_explosion_swells_then_rises_and_fades():
    """It swells within a third of a second, then grows slowly, rises, and fades into smoke."""
    width, totals = widths("explosion"), volumes("explosion").sum(axis=(1, 2, 3))
    assert width[8] > 1.3 * width[2]
    assert (width[8] - width[2]) / 6 > 2 * (width[-1] - width[8]) / (len(width) - 9)
    assert middles("explosion")[-1] > middles("explosion")[8] + 1
    assert totals.argmax() < SECOND
    assert totals[-1] < 0.9 * totals.max()


def test_burning_makes_room_but_no_matter():
    """Smoke and fuel together stay what was let in, however much the burning swells."""
    still = {"density_dissipation": 0.0, "turbulence_strength": 0.0, "smoke": 1.0}
    swollen = play("explosion", 12, expansion=1.5, **still)[1]
    compact = play("explosion", 12, expansion=0.0, **still)[1]
    assert swollen[-1] == pytest.approx(compact[-1], rel=0.1)


def test_splash_rises_and_falls():
    """It is thrown up for a third of a second at least, falls back and spreads; nothing is lost."""
    height, width = middles("splash"), widths("splash")
    totals = volumes("splash").sum(axis=(1, 2, 3))
    np.testing.assert_allclose(totals[6:], totals[6], rtol=1e-4)
    top = int(height.argmax())
    assert 4 < top < 12
    assert height[top] > height[0] + 0.15
    assert (np.diff(height[top : top + 10]) < 0).all()
    assert height[top + 9] < height[top] - 0.15
    assert width[top + 9] > 1.5 * width[0]


def test_a_thrown_liquid_flies_as_a_stone_does():
    """The middle of a ball slows by gravity, turns and falls, and stays a ball."""
    ball = "sphere center=0,3,0 radius=1.2 density=1:24;2:0 velocity=0,7,0 drive=1:200;2:200;3:0"
    flags = {"liquid_weight": 300.0, "boundary_x": "closed", "boundary_y": "closed", "boundary_z": "closed"}
    settings = make_simulate_settings(None, None, None, {"emitter": [ball]}, document={"simulate": flags})
    source = empty_box(SIZE)
    choices = {"options": settings.simulate, "scene": settings.scene, "output": settings.output}
    animator, height, full = Animator(Animation(source=source, device=wp.get_device("cpu"), **choices), (1,)), [], []
    for frame in range(1, 22):
        animator.advance(frame, frame + 1)
        profile = animator.state.density.numpy().sum(axis=(0, 1))
        height.append(profile @ HEIGHTS / profile.sum())
        full.append(animator.state.density.numpy().max() / animator.placing.reference)
    seconds = np.arange(21) / SECOND
    assert 2 * np.polyfit(seconds[4:], height[4:], 2)[0] == pytest.approx(-9.8, rel=0.15)
    assert min(full[2:]) > 0.8


def test_keys_count_from_the_first_frame():
    """A blast that begins with frame 1001 is the one of frame 1; ramps over a field stay."""
    one, late = (preset_settings("explosion", first=first) for first in (1, 1001))
    assert one["emitter"][0]["fuel"] == "0:46;3:46;4:0"
    assert late["emitter"][0]["fuel"] == "1000:46;1003:46;1004:0"
    assert late["emitter"][0]["center"] == one["emitter"][0]["center"]
    made = make_simulate_settings(None, None, None, {}, preset="explosion", first=1001)
    assert made.simulate.temperature_buoyancy == "1000:20;1009:12;1023:6"


@pytest.mark.parametrize("name", preset_names())
def test_the_first_frame_shows_something(name):
    """No preset begins with an empty box."""
    assert volumes(name)[0].max() > 0
    assert make_simulate_settings(None, None, None, {}, preset=name).simulate.preroll > 0


def test_followed_volumes_need_no_preroll():
    """What a fire needs to begin with in an empty box must not disturb a run that is edited."""
    assert make_simulate_settings(None, None, None, {}, preset="fire").simulate.preroll > 0
    assert make_simulate_settings("run", None, None, {}, preset="fire").simulate.preroll == 0
