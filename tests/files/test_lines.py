"""Records as lines, and tables of settings: every byte that changes is noticed."""

import tomllib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warpfluid.files.lines import append_line, read_lines
from warpfluid.files.tables import check_table, write_table

RECORD = {"frame": 7, "energies": [1.5, 0.1 + 0.2, 1e-300], "note": "é \u2028", "nested": {"1": [None, True, -0.0]}}


def test_what_is_written_comes_back(tmp_path):
    """Floats to the last bit, and without the checksum."""
    for frame in (1, 2):
        append_line(tmp_path / "a.jsonl", RECORD | {"frame": frame})
    assert read_lines(tmp_path / "a.jsonl") == [RECORD | {"frame": 1}, RECORD | {"frame": 2}]


def test_lines_without_a_checksum_are_taken(tmp_path):
    """Those of an earlier version."""
    (tmp_path / "a.jsonl").write_text('{"frame": 3}\n')
    assert read_lines(tmp_path / "a.jsonl") == [{"frame": 3}]


@settings(max_examples=200)
@given(place=st.integers(0, 10**6), bit=st.integers(0, 7))
def test_no_flip_changes_a_record(tmp_path_factory, place, bit):
    """A flipped bit takes the line away, or is in the name of the checksum, or between the words."""
    path = tmp_path_factory.mktemp("lines") / "a.jsonl"
    append_line(path, RECORD)
    data = bytearray(path.read_bytes())
    data[place % len(data)] ^= 1 << bit
    path.write_bytes(data)
    for found in read_lines(path):
        assert {name: found.get(name) for name in RECORD} == RECORD


@settings(max_examples=100)
@given(place=st.integers(0, 10**6), bit=st.integers(0, 7))
def test_no_flip_changes_settings(tmp_path_factory, place, bit):
    """It is refused, or it was in the words of the first line."""
    path = tmp_path_factory.mktemp("tables") / "run.toml"
    document = {"views": ["0=é.mp4"], "input": {"frames": "1-9", "white": 0.1}}
    write_table(path, document)
    check_table(path)
    assert tomllib.loads(path.read_text("utf-8")) == document
    data = bytearray(path.read_bytes())
    data[place % len(data)] ^= 1 << bit
    path.write_bytes(data)
    same = tomllib.loads(path.read_bytes().partition(b"\n")[2].decode(errors="replace")) if _is_good(path) else document
    assert same == document


def test_a_line_that_ends_elsewhere_is_refused(tmp_path):
    """A flip in its end would make the first setting a part of the comment."""
    write_table(tmp_path / "run.toml", {"a": 1, "b": 2})
    data = (tmp_path / "run.toml").read_bytes()
    (tmp_path / "run.toml").write_bytes(data.replace(b"\n", b"\t", 1))
    with pytest.raises(ValueError, match="checksum does not fit"):
        check_table(tmp_path / "run.toml")


def _is_good(path) -> bool:
    try:
        check_table(path)
    except ValueError:
        return False
    return True


@pytest.mark.parametrize("text", ["", "\n", "# crc32 of the lines below: 0000"])
def test_empty_settings(tmp_path, text):
    """A file of nothing is no table of nothing."""
    (tmp_path / "run.toml").write_text(text)
    with pytest.raises(ValueError, match=r"run\.toml is empty or cut off"):
        check_table(tmp_path / "run.toml")
