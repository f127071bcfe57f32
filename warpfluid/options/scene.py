"""What an artist puts into the box: emitters, obstacles, forces, bodies.

A line such as ``sphere center=0,1,0 radius=0.5 density=4`` on the command line and a table in a file say the same.
Lengths are in tenths of the box's height, positions x right, y up, z towards the viewer, from the middle of the floor.
"""

import shlex
from dataclasses import dataclass, field, fields
from typing import Annotated, Literal, get_args, get_type_hints

from warpfluid.options.checks import check_options

SHAPES = ("sphere", "box", "cylinder", "mesh")
EVERYWHERE = ("uniform", "wind", "drag")  # kinds of force that act everywhere unless they have a radius
Shape = Literal["sphere", "box", "cylinder", "mesh"]


@dataclass(frozen=True, kw_only=True)
class EmitterOptions:
    """A source of density, heat, fuel and motion."""

    shape: Annotated[Shape, "Its shape"] = "sphere"
    center: Annotated[str, "Where it is"] = "0,1,0"
    radius: Annotated[float | str, "Of a sphere or cylinder"] = 0.5
    size: Annotated[str, "Of a box; a cylinder's height is its second number"] = "1,1,1"
    rotation: Annotated[str, "Of a box or mesh, about x, then y, then z [degree]"] = "0,0,0"
    mesh: Annotated[str | None, "File of a closed mesh, .obj, .stl or .ply"] = None
    soft_edge: Annotated[float | str, "Width over which it fades out"] = 0.2
    density: Annotated[float | str, "Full densities a second"] = 0.0
    temperature: Annotated[float | str, "What it heats to"] = 0.0
    fuel: Annotated[float | str, "Full densities of fuel a second"] = 0.0
    velocity: Annotated[str, "Velocity it gives the fluid"] = "0,0,0"
    drive: Annotated[float | str, "Rate at which the fluid takes it [1/s]"] = 0.0
    noise: Annotated[float | str, "How much it flickers, 0-1"] = 0.0
    noise_frequency: Annotated[float, "Spots of the flicker a unit of length"] = 1.0
    noise_speed: Annotated[float, "How fast it flickers [1/s]"] = 2.0
    seed: Annotated[int, "Of the flicker"] = 0

    def __post_init__(self):
        check_options(self)


@dataclass(frozen=True, kw_only=True)
class ObstacleOptions:
    """A solid that the fluid flows around."""

    shape: Annotated[Shape, "Its shape"] = "sphere"
    center: Annotated[str, "Where it is; keyed, it moves and pushes"] = "0,3,0"
    radius: Annotated[float, "Of a sphere or cylinder"] = 1.0
    size: Annotated[str, "Of a box; a cylinder's height is its second number"] = "1,1,1"
    rotation: Annotated[str, "About x, then y, then z [degree]"] = "0,0,0"
    mesh: Annotated[str | None, "File of a closed mesh, .obj, .stl or .ply"] = None

    def __post_init__(self):
        check_options(self)


@dataclass(frozen=True, kw_only=True)
class ForceOptions:
    """A field of force."""

    kind: Annotated[
        Literal["uniform", "radial", "attractor", "vortex", "wind", "drag"],
        "uniform along direction, radial from center, attractor to center, vortex about direction, wind, drag",
    ] = "uniform"
    strength: Annotated[float | str, "Acceleration; of wind and drag the rate [1/s]"] = 1.0
    center: Annotated[str | None, "Where it is, 0,3,0 by default; a wind or drag that is local needs a radius, too"] = (
        None
    )
    radius: Annotated[
        float | str | None,
        "How far it reaches, 2 by default; uniform, wind and drag everywhere; a wind with it is a fan",
    ] = None
    direction: Annotated[str, "Of a uniform force and a vortex; of wind its velocity"] = "0,1,0"

    def __post_init__(self):
        check_options(self)
        if self.kind in EVERYWHERE and self.center is not None and self.radius is None:
            raise ValueError(
                f"center is {self.center} without a radius, and a {self.kind} force without one acts everywhere: "
                "add radius=2, or leave the center out"
            )


@dataclass(frozen=True, kw_only=True)
class BodyOptions:
    """A rigid body that the fluid carries, as the car of Fig. 12c."""

    shape: Annotated[Literal["box", "mesh"], "Its shape"] = "box"
    center: Annotated[str, "Where it starts"] = "0,2,0"
    size: Annotated[str, "Of a box; a mesh is scaled to fit its greatest number"] = "1,1,1"
    rotation: Annotated[str, "How it starts, about x, then y, then z [degree]"] = "0,0,0"
    mesh: Annotated[str | None, "File of a closed mesh, .obj, .stl or .ply"] = None
    velocity: Annotated[str, "How it starts"] = "0,0,0"
    spin: Annotated[str, "How it starts [degree/s]"] = "0,0,0"
    weight: Annotated[float, "Its mass density; the heavier, the less the fluid moves it"] = 1.0
    carry: Annotated[float, "Rate at which full density carries a body of weight 1 along [1/s]"] = 8.0
    restitution: Annotated[float, "Share of the speed that a bounce keeps"] = 0.3
    friction: Annotated[float, "Coulomb friction on the ground"] = 0.5
    obstacle: Annotated[bool, "Whether the fluid flows around it"] = True

    def __post_init__(self):
        check_options(self)


THINGS = {"emitter": EmitterOptions, "obstacle": ObstacleOptions, "force": ForceOptions, "body": BodyOptions}


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Everything in the box."""

    emitter: tuple[EmitterOptions, ...] = field(default=())
    obstacle: tuple[ObstacleOptions, ...] = field(default=())
    force: tuple[ForceOptions, ...] = field(default=())
    body: tuple[BodyOptions, ...] = field(default=())


def parse_thing(kind: str, text: str):
    """Return what a line of the command line puts into the box.

    Args:
        kind: One of ``THINGS``.
        text: Its shape (of a force its kind), then ``name=value`` for all that is not as usual.

    Raises:
        ValueError: If a name or a value is wrong; one line each.
    """
    try:
        first, *rest = shlex.split(text) or [""]
    except ValueError as error:
        raise ValueError(f"--{kind} {text!r}: a quotation mark is not closed") from error
    table = {"kind" if kind == "force" else "shape": first}
    for part in rest:
        name, equals, value = part.partition("=")
        if not equals:
            raise ValueError(f"--{kind} {text!r}: {part!r} has no value, write {part}=...")
        table[name] = value
    return make_thing(kind, table, where=f"--{kind}: ")


def make_thing(kind: str, table: dict, *, where: str):
    """Return what a table puts into the box; numbers may be text.

    Raises:
        ValueError: If a name or a value is wrong; one line each, begun with ``where``.
    """
    options = THINGS[kind]
    kinds = {name: get_args(hint) or (hint,) for name, hint in get_type_hints(options).items()}
    unknown = sorted(set(table) - set(kinds))
    if unknown:
        known = ", ".join(f.name for f in fields(options))
        raise ValueError(f"{where}{unknown[0]!r} is unknown; expected are {known}")
    try:
        return options(**{name: _typed(value, kinds[name]) for name, value in table.items()})
    except ValueError as error:
        raise ValueError("\n".join(where + line for line in str(error).splitlines())) from error


def _typed(value, kinds: tuple):
    """Return text as the number or truth that an option wants; anything else is checked later."""
    if isinstance(value, str) and bool in kinds:
        return {"true": True, "false": False}.get(value.lower(), value)
    for kind in (int, float):
        if isinstance(value, str) and kind in kinds:
            try:
                return kind(value)
            except ValueError:
                continue
    return value
