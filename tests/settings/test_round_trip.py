"""Whatever can be chosen can be written to TOML, and comes back the same."""

import tomllib
from dataclasses import fields
from pathlib import Path
from typing import Literal, get_args, get_origin, get_type_hints

import pytest
import tomli_w
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from warpfluid.options import RANGES, THINGS, Scene
from warpfluid.options.checks import VECTORS
from warpfluid.settings import (
    SECTIONS,
    Settings,
    SimulateSettings,
    make_options,
    make_settings,
    make_simulate_settings,
    read_settings,
)
from warpfluid.settings.tables import to_table

FORMS = {  # texts of a form of their own
    "show": st.sampled_from(["volume", "slices,box"]),
    "window": st.sampled_from(["640x480", "1280x800"]),
    "resolution": st.sampled_from(["256x144", "960x540"]),
    "jobs": st.sampled_from([1, 8, "4", "auto"]),
    "background": st.sampled_from(["median", '/plates/empty "2".exr']),
    "mesh": st.just("/bodies/car.obj"),
}


def numbers(name: str, kind: type):
    """Return a strategy for the numbers of an option."""
    low, high = RANGES.get(name, (0.5, 2))
    return st.integers(int(low), int(high)) if kind is int else st.floats(low, high)


def values(name: str, hint):
    """Return a strategy for all that an option may be."""
    kinds = get_args(hint) or (hint,)
    none = st.none() if type(None) in kinds else st.nothing()
    if name in FORMS:
        return none | FORMS[name]
    literals = [kind for kind in (hint, *kinds) if get_origin(kind) is Literal]
    if literals:
        return none | st.sampled_from(get_args(literals[0]))
    if bool in kinds:
        return none | st.booleans()
    number = int if int in kinds else float if float in kinds else None
    if name in VECTORS:
        vector = st.tuples(*[numbers(name, float)] * 3).map(lambda found: ",".join(map(repr, found)))
        return none | vector | st.tuples(vector, vector).map(lambda keys: f"1:{keys[0]};9.5:{keys[1]}")
    if number:
        keyed = numbers(name, number).map(lambda value: f"1:{value!r}") if str in kinds else st.nothing()
        return none | numbers(name, number) | keyed
    return none | st.text(st.characters(codec="utf-8", exclude_characters="\0"), min_size=1)


@st.composite
def options(draw, kind: type):
    """Draw options, of which one alone may exclude another."""
    hints = get_type_hints(kind)
    chosen = draw(st.sets(st.sampled_from([field.name for field in fields(kind)])))
    drawn = {name: draw(values(name, hints[name])) for name in sorted(chosen)}
    try:
        return kind(**drawn)
    except ValueError as error:
        assume("expected" in str(error))  # a value by itself is wrong, not two that exclude each other
        raise


def written(folder: Path, document: dict) -> dict:
    """Return a document as a file gives it back."""
    (folder / "run.toml").write_bytes(tomli_w.dumps(document).encode())
    return read_settings(folder / "run.toml")


sampled = settings(max_examples=40, suppress_health_check=list(HealthCheck))


@pytest.mark.parametrize("name", SECTIONS)
def test_options(name, tmp_path_factory):
    """Those of each table."""

    @sampled
    @given(options(SECTIONS[name]))
    def check(made):
        table = written(tmp_path_factory.mktemp("table"), {name: to_table(made)}).get(name, {})
        assert make_options(SECTIONS[name], table) == made

    check()


@sampled
@given(st.data())
def test_a_reconstruction(tmp_path_factory, data):
    """The settings of a run repeat it."""
    names = ("input", "reconstruct", "output")
    parts = {name: data.draw(options(SECTIONS[name])) for name in names}
    made = Settings(views=("0=/a.mp4", "-60.25=/b ü.mp4"), **parts)
    document = written(tmp_path_factory.mktemp("run"), made.to_dict())
    assert make_settings([], None, None, None, document=document) == made


@sampled
@given(st.data())
def test_a_simulation(tmp_path_factory, data):
    """With all that stands in the box."""
    scene = Scene(**{kind: tuple(data.draw(st.lists(options(THINGS[kind]), max_size=2))) for kind in THINGS})
    place = data.draw(st.sampled_from([{"source": "/fire", "size": None}, {"source": None, "size": (16, 24)}]))
    parts = {name: data.draw(options(SECTIONS[name])) for name in ("simulate", "output")}
    made = SimulateSettings(scene=scene, **place, **parts)
    document = written(tmp_path_factory.mktemp("run"), made.to_dict())
    assert make_simulate_settings(None, None, None, {}, document=document) == made


def test_what_is_written_is_toml_of_everyone():
    """It holds no value that TOML has not."""
    made = make_settings(["0=/a"], None, None, None).to_dict()
    assert tomllib.loads(tomli_w.dumps(made)) == made
