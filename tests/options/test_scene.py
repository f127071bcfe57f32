"""What an artist puts into the box: a line and a table say the same, and errors name the thing."""

import dataclasses
import re

import pytest

from warpfluid.options import THINGS, BodyOptions, EmitterOptions, ForceOptions, ObstacleOptions
from warpfluid.options.scene import make_thing, parse_thing


@pytest.mark.parametrize(
    ("kind", "text", "expected"),
    [
        ("emitter", "sphere", EmitterOptions()),
        (
            "emitter",
            "box center=0,2,0 size=2,1,2 density=4 temperature=1:1;5:0 seed=7",
            EmitterOptions(shape="box", center="0,2,0", size="2,1,2", density=4.0, temperature="1:1;5:0", seed=7),
        ),
        ("obstacle", "mesh mesh='a b.obj' size=2,2,2", ObstacleOptions(shape="mesh", mesh="a b.obj", size="2,2,2")),
        ("force", "vortex strength=-20 radius=3", ForceOptions(kind="vortex", strength=-20.0, radius=3.0)),
        ("body", "box weight=2 obstacle=False", BodyOptions(weight=2.0, obstacle=False)),
    ],
)
def test_a_line_is_a_thing(kind, text, expected):
    """The first word is the shape or kind, the rest is as usual unless it is said; numbers become numbers."""
    made = parse_thing(kind, text)
    assert made == expected
    assert {name: type(value) for name, value in dataclasses.asdict(made).items()} == {
        name: type(value) for name, value in dataclasses.asdict(expected).items()
    }


@pytest.mark.parametrize("kind", THINGS)
def test_a_table_comes_back(kind):
    """What a run writes down makes the same thing."""
    usual = THINGS[kind]()
    table = {name: value for name, value in dataclasses.asdict(usual).items() if value is not None}
    assert make_thing(kind, table, where="") == usual
    assert make_thing(kind, {name: str(value) for name, value in table.items()}, where="") == usual


@pytest.mark.parametrize(
    ("kind", "text", "words"),
    [
        ("emitter", "", "--emitter: shape is '', expected one of sphere, box, cylinder, mesh"),
        ("emitter", "'sphere", '--emitter "\'sphere": a quotation mark is not closed'),
        ("emitter", "sphere dense", "--emitter 'sphere dense': 'dense' has no value, write dense=..."),
        ("emitter", "sphere colour=red", "--emitter: 'colour' is unknown; expected are shape, center, radius"),
        ("emitter", "sphere density=much", "--emitter: density is 'much', expected a number, or keys"),
        ("emitter", "sphere seed=1.5", "--emitter: seed is '1.5', expected a whole number"),
        ("obstacle", "ball", "--obstacle: shape is 'ball', expected one of sphere, box"),
        ("obstacle", "box size=1,1", "--obstacle: size is '1,1', expected three numbers"),
        ("obstacle", "box size=0,1,1", "--obstacle: size is 0, expected 0.001 to 1000"),
        ("force", "spin", "--force: kind is 'spin', expected one of uniform, radial, attractor, vortex, wind, drag"),
        ("force", "wind strength=2000", "--force: strength is 2000, expected -1000 to 1000"),
        ("body", "box obstacle=yes", "--body: obstacle is 'yes', expected true or false"),
        ("body", "sphere", "--body: shape is 'sphere', expected one of box, mesh"),
    ],
)
def test_what_is_no_thing(kind, text, words):
    """The message names the thing, what was found and what is expected."""
    with pytest.raises(ValueError, match=re.escape(words)):
        parse_thing(kind, text)


def test_all_that_is_wrong_with_a_thing():
    """A line each, each with its name."""
    with pytest.raises(ValueError, match=r"^--emitter: radius [^\n]*\n--emitter: density [^\n]*$"):
        parse_thing("emitter", "sphere radius=0 density=-1")
