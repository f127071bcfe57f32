"""Options: types, ranges, the paper's choices, and what is left to the footage."""

import dataclasses
import re
from typing import get_args, get_type_hints

import pytest
from hypothesis import given
from hypothesis import strategies as st

from warpfluid import options
from warpfluid.options import (
    PAPER,
    RANGES,
    SIMULATE_PAPER,
    THINGS,
    BodyOptions,
    CameraOptions,
    CompareOptions,
    EmitterOptions,
    ExportOptions,
    ForceOptions,
    InputOptions,
    LightOptions,
    ObstacleOptions,
    OutputOptions,
    PreviewOptions,
    ReconstructOptions,
    RenderOptions,
    SimulateOptions,
    default_angles,
)
from warpfluid.options.checks import VECTORS, WORDS

PICTURE = (CameraOptions, LightOptions, RenderOptions)
COMMANDS = ((InputOptions, ReconstructOptions, OutputOptions), (SimulateOptions, OutputOptions), PICTURE)
LEAVING = (CompareOptions, ExportOptions, PreviewOptions)
CLASSES = [found for found in vars(options).values() if dataclasses.is_dataclass(found) and found is not options.Scene]
FREE = {"white", "jobs"}  # numbers that have no range: any positive value, and one that may be a word
OWNERS = [(owner, field.name) for owner in CLASSES for field in dataclasses.fields(owner)]


def is_number(options: type, name: str) -> bool:
    """Return whether an option is a number, keyed or not."""
    kind = get_type_hints(options)[name]
    return bool({int, float} & {kind, *get_args(kind)})


def test_every_number_has_a_range():
    """A range for each number, none for what is no number or does not exist."""
    numbers = {name for owner, name in OWNERS if is_number(owner, name)}
    assert set(RANGES) <= numbers | VECTORS
    assert numbers - set(RANGES) <= FREE


def test_every_vector_and_word_exists():
    """What is said of vectors and words is said of options."""
    assert {name for _, name in OWNERS} >= VECTORS
    assert set(WORDS) <= {name for _, name in OWNERS}


@pytest.mark.parametrize("classes", COMMANDS, ids=["reconstruct", "simulate", "render"])
def test_names_are_unlike(classes):
    """One flag names one option of a command, whatever class it belongs to; none is a flag of the command."""
    names = [field.name for options in classes for field in dataclasses.fields(options)]
    assert len(names) == len(set(names))
    assert not set(names) & {"view", "front", "side", "out", "paper", "config", "resume", "overwrite", "device"}
    assert not set(names) & {"source", "preset", "size", *THINGS}


@pytest.mark.parametrize(
    ("options", "name"),
    [(options, name) for options, name in OWNERS if name in RANGES and is_number(options, name)],
    ids=lambda part: part if isinstance(part, str) else part.__name__,
)
def test_ranges(options, name):
    """Both ends are allowed, what lies beyond is refused with the range, at any key."""
    low, high = RANGES[name]
    for value in (low, high):
        assert getattr(options(**{name: value}), name) == value
    keyed = str in get_args(get_type_hints(options)[name])
    for value in (low - 1, high + 1):
        words = f"{name.replace('_', '-')} is {value:.10g}, expected {low:.10g} to {high:.10g}"
        for said in (value, f"{value!r}", f"1:{low!r};5:{value!r}") if keyed else (value,):
            with pytest.raises(ValueError, match=re.escape(words)):
                options(**{name: said})


@pytest.mark.parametrize("options", CLASSES, ids=lambda options: options.__name__)
def test_defaults_are_allowed(options):
    """So that what a run writes down can be read again."""
    made = options()
    assert options(**dataclasses.asdict(made)) == made


@pytest.mark.parametrize(
    ("options", "values", "words"),
    [
        (ReconstructOptions, {"iterations": 3.0}, "iterations is 3.0, expected a whole number"),
        (ReconstructOptions, {"iterations": True}, "iterations is True, expected a whole number"),
        (ReconstructOptions, {"iterations": None}, "iterations is None"),
        (ReconstructOptions, {"blur": "1"}, "blur is '1', expected a number"),
        (ReconstructOptions, {"blur": float("nan")}, "blur is nan"),
        (ReconstructOptions, {"row_sums": 1}, "row-sums is 1, expected true or false"),
        (ReconstructOptions, {"hull": "square"}, "hull is 'square', expected one of auto, silhouette, round"),
        (InputOptions, {"frames": 7}, "frames is 7, expected text"),
        (OutputOptions, {"up": ["y"]}, r"up is \['y'\], expected one of y, z"),
        (SimulateOptions, {"swirl": "much"}, "swirl is 'much', expected a number, or keys such as 1:0.5;24:2"),
        (SimulateOptions, {"swirl": True}, "swirl is True, expected a number"),
        (SimulateOptions, {"swirl": None}, "swirl is None, expected a number"),
        (SimulateOptions, {"swirl": [1]}, r"swirl is \[1\], expected a number"),
        (SimulateOptions, {"swirl": "auto"}, "swirl is 'auto', expected a number, or keys"),
        (SimulateOptions, {"swirl": float("inf")}, "swirl is inf, expected a number"),
        (SimulateOptions, {"swirl": "9:1;1:2"}, "swirl is '9:1;1:2', expected a number, or keys"),
        (SimulateOptions, {"density_dissipation": "none"}, "is 'none', expected auto, a number, or keys"),
        (SimulateOptions, {"fidelity": "1:0;9:2"}, "fidelity is 2, expected 0 to 1"),
        (SimulateOptions, {"swirl": "density"}, r"expected .* or a field \(density, temperature, speed\) and its keys"),
        (SimulateOptions, {"swirl": "densty 0:0;1:2"}, "swirl is 'densty 0:0;1:2', expected"),
        (SimulateOptions, {"swirl": "density 1:0;0:2"}, "swirl is 'density 1:0;0:2', expected"),
        (SimulateOptions, {"swirl": "density 0:0;1:20"}, "swirl is 20, expected 0 to 10"),
        (SimulateOptions, {"blend": "speed 0:0;1:2"}, "blend is 2, expected 0 to 1"),
        (
            SimulateOptions,
            {"viscosity": "density 0:0;1:2"},
            "viscosity is 'density 0:0;1:2', expected a number, or keys",
        ),
        (SimulateOptions, {"wind": "1,2"}, "wind is '1,2', expected three numbers such as 0,1,0, or keys such as 1:0,"),
        (SimulateOptions, {"wind": 3}, "wind is 3, expected three numbers"),
        (SimulateOptions, {"wind": "a,b,c"}, "wind is 'a,b,c', expected three numbers"),
        (SimulateOptions, {"boundary_x": "shut"}, "boundary-x is 'shut', expected one of open, closed, closed-low"),
        (SimulateOptions, {"max_substeps": 2.5}, "max-substeps is 2.5, expected a whole number"),
        (EmitterOptions, {"shape": "plane"}, "shape is 'plane', expected one of sphere, box, cylinder, mesh"),
        (EmitterOptions, {"size": "1,-1,1"}, "size is -1, expected 0.001 to 1000"),
        (ObstacleOptions, {"mesh": 1}, "mesh is 1, expected text"),
        (ForceOptions, {"kind": "wind", "center": "1,2,0"}, "center is 1,2,0 without a radius, and a wind force"),
        (ForceOptions, {"kind": "drag", "center": "1,2,0"}, "add radius=2, or leave the center out"),
        (ForceOptions, {"radius": "1:0;9:2"}, "radius is 0, expected 0.001 to 1000"),
        (ForceOptions, {"kind": "push"}, "kind is 'push', expected one of uniform, radial"),
        (BodyOptions, {"obstacle": 1}, "obstacle is 1, expected true or false"),
        (BodyOptions, {"shape": "sphere"}, "shape is 'sphere', expected one of box, mesh"),
    ],
)
def test_wrong_values(options, values, words):
    """Each is refused by its name, with what was found and what is expected."""
    with pytest.raises(ValueError, match=words):
        options(**values)


def test_all_wrong_values_are_told_at_once():
    """A line each."""
    with pytest.raises(ValueError, match=r"^iterations .*\nblur .*\nhull [^\n]*$"):
        ReconstructOptions(iterations=-1, blur=-1, hull="x")


def test_the_papers_choices():
    """They are the paper's, and changes count on top."""
    paper = ReconstructOptions.paper(blur=1.0, angles=90)
    assert (paper.blur, paper.angles) == (1.0, 90)
    assert (paper.preconditioner, paper.stand_in, paper.hull) == ("none", "measured", "silhouette")
    left = dataclasses.asdict(ReconstructOptions())
    assert {name for name, value in dataclasses.asdict(ReconstructOptions.paper()).items() if value != left[name]} <= {
        *PAPER
    }
    assert ReconstructOptions.paper().settled(views=1, width=96, bright=1.0).start_noise == 0


@given(
    views=st.integers(1, 5),
    width=st.integers(8, 3000),
    bright=st.floats(0, 1),
    shoulder=st.none() | st.floats(0, 10),
    start_noise=st.none() | st.floats(0, 5),
    noise_grain=st.none() | st.floats(0.1, 100),
    noise_grain_y=st.none() | st.floats(0.1, 100),
    angles=st.none() | st.integers(2, 7200),
)
def test_choices_left_to_the_footage(views, width, bright, **asked):
    """What was asked for stays, everything else is decided once and for all."""
    settled = ReconstructOptions(**asked).settled(views=views, width=width, bright=bright)
    assert all(getattr(settled, name) == value for name, value in asked.items() if value is not None)
    assert None not in [getattr(settled, name) for name in asked]
    assert settled.settled(views=views, width=width, bright=1 - bright) == settled
    if asked["shoulder"] is None and (views > 1 or bright <= 1 / 3):
        assert settled.shoulder == 0


def test_what_simulate_takes():
    """Words where they are allowed, keyed numbers and vectors as text, and the paper's choices."""
    made = SimulateOptions(density_dissipation="auto", swirl="1:0;9:2", wind="1:0,0,0;9:1,0,0", blend="0.25")
    assert (made.density_dissipation, made.swirl) == ("auto", "1:0;9:2")
    paper = dataclasses.asdict(SimulateOptions(**SIMULATE_PAPER))
    usual = dataclasses.asdict(SimulateOptions())
    assert {name for name in paper if paper[name] != usual[name]} == {*SIMULATE_PAPER}


def test_default_angles():
    """180, and enough for wide volumes to have no streaks."""
    assert [default_angles(width) for width in (8, 271, 720, 721, 1920)] == [180, 180, 180, 181, 480]
