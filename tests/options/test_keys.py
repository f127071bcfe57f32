"""Numbers over frames: keys are hit, lines lie between, and nothing else is taken for one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from warpfluid.options.keys import FIELDS, Keyed, Ramp, is_ramp

numbers = st.floats(-1e6, 1e6)
frames = st.lists(st.integers(-1000, 10000), min_size=1, max_size=6, unique=True).map(sorted)


@st.composite
def keys(draw, size=1):
    """Return frames, and values of shape (key, size)."""
    found = draw(frames)
    rows = st.lists(st.lists(numbers, min_size=size, max_size=size), min_size=len(found), max_size=len(found))
    return np.array(found, float), np.array(draw(rows))


def spell(found: np.ndarray, values: np.ndarray) -> str:
    """Return keys as an artist writes them."""
    rows = (",".join(map(repr, row.tolist())) for row in values)
    return "; ".join(f"{int(frame)}:{row}" for frame, row in zip(found, rows, strict=True))


@given(numbers, st.floats(-1e5, 1e5))
def test_one_number_is_constant(value, frame):
    """As a number and as text."""
    assert Keyed(value).at(frame) == Keyed(repr(value)).at(frame) == value


@given(keys())
def test_keys_are_hit(found):
    """Each key's value at its frame, the first one before and the last one after."""
    keyed = Keyed(spell(*found))
    for frame, (value,) in zip(*found, strict=True):
        assert keyed.at(frame) == value
    assert keyed.at(found[0][0] - 7) == found[1][0, 0]
    assert keyed.at(found[0][-1] + 7) == found[1][-1, 0]


@given(keys(), st.floats(0, 1))
def test_lines_lie_between(found, share):
    """Part of the way in frames is the same part of the way in values."""
    keyed = Keyed(spell(*found))
    for k in range(len(found[0]) - 1):
        low, high = found[1][k, 0], found[1][k + 1, 0]
        at = keyed.at(found[0][k] + share * (found[0][k + 1] - found[0][k]))
        assert at == pytest.approx(low + share * (high - low), rel=1e-9, abs=1e-6)


@given(keys(size=3), st.floats(-1100, 10100))
def test_a_vector_is_three_numbers(found, frame):
    """Each of its components is keyed for itself."""
    at = Keyed(spell(*found), 3).at(frame)
    assert at.shape == (3,)
    for k in range(3):
        assert at[k] == Keyed(spell(found[0], found[1][:, k : k + 1])).at(frame)


@pytest.mark.parametrize(
    ("text", "size", "words"),
    [
        ("", 1, "could not convert"),
        ("fast", 1, "could not convert"),
        ("1,2", 1, "is 2 numbers"),
        ("1,2", 3, "is 2 numbers"),
        ("1:1;2", 1, "'2' has no frame"),
        ("1:1;", 1, "'' has no frame"),
        ("5:1;5:2", 1, "the frames of its keys must rise"),
        ("5:1;4:2", 1, "the frames of its keys must rise"),
        ("nan", 1, "nan is not finite"),
        ("inf:2;3:4", 1, "inf is not finite"),
        (float("inf"), 1, "inf is not finite"),
        ("1:1,2,3;2:1,2", 3, "is 2 numbers"),
    ],
)
def test_what_is_no_keyed_number(text, size, words):
    """Nothing is guessed."""
    with pytest.raises(ValueError, match=words):
        Keyed(text, size)


@given(keys(), st.sampled_from(FIELDS))
def test_a_ramp_is_a_field_and_its_keys(found, field):
    """What the keys say of frames a ramp says of values."""
    text = f"  {field} {spell(*found)}"
    assert is_ramp(text)
    ramp = Ramp(text)
    assert ramp.field == field
    np.testing.assert_array_equal(ramp.inputs, found[0])
    np.testing.assert_array_equal(ramp.values, found[1][:, 0])


@pytest.mark.parametrize("value", [3, 1.5, "3", "1:0;2:4", "auto", "", "dens 0:1", "nan", True, None])
def test_what_is_no_ramp(value):
    """Only a field's name begins one."""
    assert not is_ramp(value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("heat 0:0;1:2", "'heat' is no field, expected one of density, temperature, speed"),
        ("density", "could not convert"),
        ("density 1:0;0:2", "must rise"),
        ("speed 0:0;1", "'1' has no frame"),
        ("density 0:inf", "inf is not finite"),
        ("density 0:__import__('os')", "could not convert"),
    ],
)
def test_what_is_a_wrong_ramp(text, words):
    """Nothing is guessed, and nothing is run."""
    with pytest.raises(ValueError, match=words):
        Ramp(text)
