"""
What the options of simulate do
===============================

Draws the pictures of ``docs/simulating.md``: the same small plume, or the packaged fire, with a low and a high value of
one option. Takes some minutes.
"""

# %%
# Words on the command line become options, so each picture is labelled with what was typed.

import shlex
import subprocess
import sys
import tempfile
from dataclasses import replace
from importlib.resources import files
from itertools import pairwise
from pathlib import Path

import numpy as np
from gallery import panel, save
from scipy.ndimage import zoom

from warpfluid.device import pick_device
from warpfluid.options import OutputOptions, SimulateOptions
from warpfluid.options.scene import THINGS, Scene, parse_thing
from warpfluid.rendering.ramps import apply_ramp
from warpfluid.rendering.surfaces import Surface
from warpfluid.rendering.turntable import render_turntable
from warpfluid.settings import make_simulate_settings
from warpfluid.simulation.animate import Animator
from warpfluid.simulation.animation import Animation
from warpfluid.simulation.detail import Detail
from warpfluid.simulation.source import Source, empty_box, fill_box
from warpfluid.volumes import open_volumes

SIZE, FRAMES, ZOOM = (24, 36), 36, 5.0
PLUME = "sphere center=0,1,0 radius=0.8 density=4 temperature=1 velocity=0,5,0 drive=4 noise=0.7"
BLAST = "sphere center=0,2,0 radius=0.8 density=2 fuel=1:12;6:12;7:0 temperature=1:1;6:1;7:0 noise=0.7"
CLOUD = "sphere center=0,3.5,0 radius=1.6 density=1:12;4:12;5:0 noise=0.6"
JET = "cylinder center=0,0.5,0 radius=0.8 density=1:20;8:20;9:0 velocity=2,11,0 drive=1:30;8:30;9:0 noise=0.8"


def options_of(words: str) -> SimulateOptions:
    """Return the options of ``name=value`` words."""
    found = {}
    for word in shlex.split(words):
        name, _, value = word.partition("=")
        usual = getattr(SimulateOptions(), name.replace("-", "_"))
        vector = isinstance(usual, str) and usual != "auto"
        typed = value == "on" if isinstance(usual, bool) else value if vector else number(value)
        found[name.replace("-", "_")] = int(typed) if type(usual) is int else typed
    return SimulateOptions(**found)


def number(text: str) -> float | str:
    """Return text as a number, if it is one."""
    try:
        return float(text)
    except ValueError:
        return text


def animate(words: str, source: Source | None = None, frames: int = FRAMES, **things: list[str]) -> Animator:
    """Simulate some frames; things are lines by kind."""
    scene = Scene(**{kind: tuple(parse_thing(kind, line) for line in things.get(kind, ())) for kind in THINGS})
    animation = Animation(
        source=source or empty_box(SIZE),
        options=options_of(words),
        scene=scene,
        output=OutputOptions(),
        device=pick_device("cpu"),
    )
    animator = Animator(animation, tuple(range(1, frames + 1)))
    for frame, later in pairwise(animator.frames):
        animator.advance(frame, later)
    return animator


def picture(animator: Animator, ramp: str = "smoke") -> np.ndarray:
    """Return how the fluid looks from the front, enlarged before it is coloured."""
    image = animator.state.density.numpy().sum(axis=1)
    factor = ZOOM * SIZE[0] / len(image)
    return cut(apply_ramp(zoom(image.T[::-1], factor, order=3, mode="nearest", grid_mode=True), ramp))


def cut(picture: np.ndarray) -> np.ndarray:
    """Return a picture without its upper quarter, where little happens."""
    return picture[len(picture) // 4 :]


def draw(name: str, values: tuple[str, ...], also: str = "", *, ramp: str = "smoke", **how) -> None:
    """Save the pictures of one option at some values, side by side."""
    how = {"emitter": [PLUME], **how}
    row = {value: picture(animate(f"{also} {name}={value}", **how), ramp) for value in values}
    save(f"simulate-{name}.png", panel(row))


# %%
# What stirs and lifts.

RISE = "temperature-buoyancy=14"
draw("turbulence-strength", ("0", "0.5", "2"), RISE)
draw("turbulence-frequency", ("0.2", "0.6", "1.5"), f"{RISE} turbulence-strength=1")
draw("swirl", ("0", "3", "8"), RISE)
draw("temperature-buoyancy", ("4", "14", "40"))
draw("density-buoyancy", ("-10", "0", "10"), emitter=[CLOUD], frames=16)
draw("wind", ("0,0,0", "2,0,0", "6,0,0"), RISE)

# %%
# What calms and fades.

draw("velocity-damp", ("0", "2", "8"), RISE)
draw("viscosity", ("0", "2", "10"), f"{RISE} swirl=3")
draw("density-dissipation", ("0", "1", "4"), RISE)
draw("density-diffusion", ("0", "2", "10"), RISE)

# %%
# Fire that swells, and a liquid that falls.

BURN = "combustion=on temperature-buoyancy=12 density-dissipation=0.3 swirl=3"
draw("expansion", ("0", "4", "12"), BURN, emitter=[BLAST], ramp="fire", frames=14)
draw("liquid-weight", ("0", "2", "20"), emitter=[JET], ramp="gray", frames=34)

# %%
# Files finer than the simulation: the preset explosion, lit from above through the smoke.


def lit(density: np.ndarray, full: float) -> np.ndarray:
    """Return smoke as it looks under a light above it, shape (rows, columns); a voxel of ``full`` takes a third."""
    taken = 0.4 * density / full
    light = 0.1 + 0.9 * np.exp(-np.cumsum(taken[..., ::-1], axis=2)[..., ::-1])
    passed = np.exp(taken - np.cumsum(taken[:, ::-1], axis=1)[:, ::-1])
    return (taken * passed * light).sum(axis=1).T[::-1].clip(0, 1) ** 0.45


blast = make_simulate_settings(None, None, None, {}, size=(48, 72), preset="explosion")
plan = Animation(
    source=empty_box(blast.size),
    options=replace(blast.simulate, detail=2),
    scene=blast.scene,
    output=blast.output,
    device=pick_device("cpu"),
)
run = Animator(plan, tuple(range(1, 23)))
for frame, later in pairwise(run.frames):
    run.advance(frame, later)
full, row = run.placing.reference, {}
for factor in (1, 2, 4):
    density = run.state.density.numpy()
    if factor > 1:
        detail = Detail(factor, density.shape, run.solver.sides, 0, plan.device)
        detail.restore(run.detail.state())
        density = detail.refine(run.state, full, strength=1.0).cells["density"]
    image = lit(density, full)
    shown = zoom(image, 336 / image.shape[1], order=1, mode="nearest", grid_mode=True)
    row[f"detail {factor}"] = np.repeat((255 * shown[200:480, 20:-20, None]).astype(np.uint8), 3, axis=2)
save("simulate-detail.png", panel(row))

# %%
# Things in the box. Obstacles and bodies are drawn as surfaces.

CUBE = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
ORANGE = (0.95, 0.5, 0.15)
CORNERS = np.array([part for a, b, c, d in SIDES for part in ((a, b, c), (a, c, d))])


def with_boxes(animator: Animator, boxes: list[Surface]) -> np.ndarray:
    """Return the fluid with boxes in it."""
    small = render_turntable(animator.state.density.numpy(), [0.0], "smoke", surfaces=boxes)[0]
    return cut(zoom(small, (ZOOM / 2, ZOOM / 2, 1), order=1, mode="nearest", grid_mode=True))


def box_at(animator: Animator, centre, size, rotation=None) -> Surface:
    """Return a box whose centre is in voxels and whose size is in tenths of the height."""
    turned = CUBE * np.multiply(size, animator.placing.unit) @ (np.eye(3) if rotation is None else rotation).T
    return Surface(turned + centre, CORNERS, ORANGE)


row = {}
for centre in ("", "0,5,0", "1,5,0"):
    run = animate(RISE, emitter=[PLUME], obstacle=[f"box center={centre} size=2,0.5,2"] if centre else [])
    boxes = [box_at(run, run.placing.point(centre, 1), (2, 0.5, 2))] if centre else []
    row[f"center={centre}" if centre else "none"] = with_boxes(run, boxes)
save("simulate-obstacle.png", panel(row))

row = {}
for kind in (
    "uniform direction=1,0,0 strength=3",
    "radial center=0,4,0 strength=40",
    "attractor center=1.5,4,0 strength=16",
    "vortex center=0,4,0 direction=0,0,1 strength=2.5",
    "wind direction=-2,0,0 strength=3",
    "wind direction=-6,0,0 strength=8 center=1,4,0 radius=0.8",
    "drag strength=4",
):
    name = "fan" if "wind" in row and "wind" in kind else kind.split()[0]
    row[name] = picture(animate(RISE, emitter=[PLUME], force=[kind]))
save("simulate-force.png", panel(row))

row = {}
for frames in (1, 12, 18, 24):
    push = "box center=-2,0.6,0 size=1,1,2 density=3 velocity=10,2,0 drive=20 noise=0.5"
    run = animate("", emitter=[push], body=["box center=-0.6,0.4,0 size=1.2,0.6,0.8 weight=0.5"], frames=frames)
    (body,) = run.scenery.bodies
    row[f"frame {frames}"] = with_boxes(run, [box_at(run, body.position, (1.2, 0.6, 0.8), body.rotation)])
save("simulate-body.png", panel(row))

# %%
# Following footage: the packaged fire, reconstructed small, with a strong side wind as the artist's edit.

run_folder = Path(tempfile.mkdtemp()) / "fire"
samples = files("warpfluid") / "samples"
command = f"reconstruct --view 0={samples}/front.####.png --view 90={samples}/side.####.png --resolution 48 --angles 60"
quiet = f"--no-turntable --no-report --quiet -o {run_folder}"
subprocess.run([sys.executable, "-m", "warpfluid", *shlex.split(f"{command} {quiet}")], check=True)
fire = fill_box(open_volumes(str(run_folder)))
EDIT = "wind=10,0,0 wind-drag=6"
same = {"ramp": "fire", "source": fire, "frames": len(fire.frames), "emitter": []}
draw("fidelity", ("0", "0.1", "1"), EDIT, **same)
draw("blend", ("0", "0.1", "0.4"), f"{EDIT} fidelity=0 order=blend-first", **same)
draw("guide-weight", ("0", "0.5", "1"), f"{EDIT} fidelity=0.05", **same)
