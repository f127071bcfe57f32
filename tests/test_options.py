"""Options: types, ranges, the paper's choices, and what is left to the footage."""

import dataclasses
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from warpfluid.options import PAPER, RANGES, InputOptions, OutputOptions, ReconstructOptions, default_angles

CLASSES = (InputOptions, ReconstructOptions, OutputOptions)


def test_every_number_has_a_range():
    """A range for each number, none for what is no number or does not exist."""
    fields = {field.name: str(field.type) for options in CLASSES for field in dataclasses.fields(options)}
    numbers = {name for name, kind in fields.items() if "[int" in kind or "[float" in kind}
    assert set(RANGES) <= numbers
    assert numbers - set(RANGES) <= {"white"}  # any positive value


def test_names_are_unlike():
    """One flag names one option, whatever class it belongs to; none is a flag of the commands."""
    names = [field.name for options in CLASSES for field in dataclasses.fields(options)]
    assert len(names) == len(set(names))
    assert not set(names) & {"view", "front", "side", "out", "paper", "config", "resume", "overwrite", "device"}


@pytest.mark.parametrize("name", RANGES)
def test_ranges(name):
    """Both ends are allowed, what lies beyond is refused with the range."""
    options = next(kind for kind in CLASSES if name in {field.name for field in dataclasses.fields(kind)})
    low, high = RANGES[name]
    for value in (low, high):
        assert getattr(options(**{name: value}), name) == value
    for value in (low - 1, high + 1):
        words = f"{name.replace('_', '-')} is {value:.10g}, expected {low:.10g} to {high:.10g}"
        with pytest.raises(ValueError, match=re.escape(words)):
            options(**{name: value})


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


def test_default_angles():
    """180, and enough for wide volumes to have no streaks."""
    assert [default_angles(width) for width in (8, 271, 720, 721, 1920)] == [180, 180, 180, 181, 480]
