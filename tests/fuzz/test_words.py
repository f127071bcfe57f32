"""What people type, gone wrong: frame sets, patterns, keyed numbers, things of a scene, tables of settings."""

import contextlib

import pytest
import tomli_w
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from warpfluid.files.sequences import (
    before_number,
    find_sequence,
    format_frames,
    has_number,
    insert_word,
    numbered_path,
    parse_frames,
)
from warpfluid.footage.matting import parse_crop, parse_resolution
from warpfluid.footage.sources import parse_view
from warpfluid.options.keys import Keyed, Ramp
from warpfluid.options.scene import THINGS, parse_thing
from warpfluid.settings import read_settings
from warpfluid.volumes.find import find_volumes

EXAMPLES = settings(max_examples=150, suppress_health_check=list(HealthCheck))
NUMBERS = st.sampled_from(["0", "1", "-1", "97", "1e999", "nan", "inf", "9" * 30, "1" * 5000, "0x10", "1_0", "½", "٣"])
SIGNS = st.sampled_from(
    [",", "-", "x", ":", ";", "=", " ", ".", "#", "%", "$F", "@", "*", "[", "]", "?", "~", "\n", "'", '"', "\\"]
)


def words(*more: str):
    """Return texts of numbers, signs, some words and anything at all."""
    return st.lists(NUMBERS | SIGNS | st.sampled_from(more or ("a",)) | st.text(max_size=3), max_size=8).map("".join)


@EXAMPLES
@given(words("1-97x4", "1001-1100"))
def test_frame_sets(text):
    """A list of few numbers, or an error; what is listed comes back."""
    with contextlib.suppress(ValueError):
        frames = parse_frames(text)
        assert len(frames) <= 100_000
        assert not frames or frames[0] < 0 or parse_frames(format_frames(frames)) == frames


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Files whose names hold the signs of patterns."""
    folder = tmp_path_factory.mktemp("odd")
    for name in ("a.0001.png", "a.####.png", "[a].1.png", "a%d.png", "é 1.vdb", "a.2.vdb", "a\n1.png", "<b>.3.npz"):
        (folder / name).touch()
    return folder


@EXAMPLES
@given(
    words("a.", "####", "%04d", "$F4", "$F999999999", "%0999999999d", ".png", ".vdb", "**", "[!a]", "1001-1100#", "\0")
)
def test_patterns(folder, text):
    """Files of the folder, or an error."""
    for find in (find_sequence, find_volumes):
        with contextlib.suppress(ValueError, OSError):
            found = find(folder / text.replace("/", ""))
            assert all(folder in path.parents for path in found.values())
    for name in (text, f"{text}.png"):
        with contextlib.suppress(ValueError):
            assert len(str(numbered_path(name, 7))) < len(name) + 30
            has_number(name), before_number(name), insert_word(name, "left")


def test_a_home_that_nobody_has():
    """It is a folder that does not exist, and no fault of ours."""
    with pytest.raises(OSError, match="nobody-of-this-name"):
        find_sequence("~nobody-of-this-name/a.####.png")


@EXAMPLES
@given(words("density ", "speed ", "1:0,0,0", "24:1"), st.sampled_from([1, 3]))
def test_keyed_numbers(text, size):
    """A finite number at every frame, or an error."""
    with contextlib.suppress(ValueError):
        assert (
            abs(Keyed(text, size).at(12.5)).max() < float("inf")
            if size == 3
            else Keyed(text).at(3) == Keyed(text).at(3)
        )
    with contextlib.suppress(ValueError):
        Ramp(text)


@EXAMPLES
@given(
    st.sampled_from(sorted(THINGS)),
    words("sphere ", "wind ", "center=", "radius=", "strength=", "0,1,0", "mesh=a.obj "),
)
def test_things_of_a_scene(kind, text):
    """An emitter, an obstacle, a force or a body, or an error that names the flag."""
    with pytest.raises(ValueError, match=f"--{kind}") if not _is_thing(kind, text) else contextlib.nullcontext():
        parse_thing(kind, text)


def _is_thing(kind: str, text: str) -> bool:
    try:
        parse_thing(kind, text)
    except ValueError:
        return False
    return True


@EXAMPLES
@given(words("0=", "90=side.mp4", "640x480", "+10+10"))
def test_views_and_boxes(text):
    """Parts of the size that is said, or an error."""
    for parse in (parse_view, parse_crop, parse_resolution):
        with contextlib.suppress(ValueError):
            parse(text)


VALUES = st.recursive(
    st.booleans() | st.integers(-(2**63), 2**63 - 1) | st.floats() | st.text(max_size=5) | st.dates() | words(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner, max_size=3),
    max_leaves=6,
)
NAMES = st.sampled_from(
    ["views", "source", "size", "input", "reconstruct", "simulate", "output", "emitter", "force", "made-with", "x"]
)
KEYS = st.sampled_from(
    ["frames", "threshold", "iterations", "fps", "swirl", "shape", "kind", "center", "strength", "voxel_size", "y"]
)
TABLES = st.dictionaries(KEYS, VALUES, max_size=3)


@EXAMPLES
@given(st.dictionaries(NAMES, VALUES | TABLES | st.lists(TABLES, max_size=2), max_size=3))
def test_tables_of_settings(tmp_path, document):
    """Settings, or an error that names the file."""
    path = tmp_path / "run.toml"
    path.write_bytes(tomli_w.dumps(document).encode("utf-8", "surrogatepass"))
    error = ""
    try:
        read_settings(path)
    except ValueError as found:
        error = str(found)
    assert all("run.toml" in line for line in error.splitlines()[:1])


@pytest.mark.parametrize("text", ["a = " + "[" * 100_000, "a = " + "1" * 5000, "a = {b = " * 3000, "\ufeff[x"])
def test_deep_and_long_tables(tmp_path, text):
    """They are no TOML, and that is all."""
    (tmp_path / "a.toml").write_text(text)
    with pytest.raises(ValueError, match=r"a\.toml is not TOML"):
        read_settings(tmp_path / "a.toml")
