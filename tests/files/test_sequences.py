"""Frame sets as text, and image sequences on disk."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from warpfluid.files.sequences import (
    MOST_FRAMES,
    find_sequence,
    format_frames,
    has_number,
    insert_word,
    numbered_path,
    parse_frames,
)


def touch(folder, *names):
    """Make empty files."""
    folder.mkdir(exist_ok=True)
    for name in names:
        (folder / name).touch()


def names(found):
    """Return the names of found files by frame number."""
    return {frame: path.name for frame, path in found.items()}


@pytest.mark.parametrize(
    ("text", "frames"),
    [
        ("7", [7]),
        ("1001-1004", [1001, 1002, 1003, 1004]),
        ("1001-1100x25", [1001, 1026, 1051, 1076]),
        ("1,5,9", [1, 5, 9]),
        (" 9 , 1-3 ,2-4x2", [1, 2, 3, 4, 9]),
        ("-2-1", [-2, -1, 0, 1]),
        ("-5--3", [-5, -4, -3]),
        ("0010-0012", [10, 11, 12]),
    ],
)
def test_frames_are_read(text, frames):
    """Numbers, ranges and steps give the frames in order, each once."""
    assert parse_frames(text) == frames


@pytest.mark.parametrize("text", ["", " ", "a", "1-", "1,,2", "1-10:3", "1-10x", "1.5", "1–3", "1-2-3", "9" * 5000])
def test_other_forms_are_refused(text):
    """The error names the text and shows the forms that are read."""
    with pytest.raises(ValueError, match=re.escape(repr(text)) + r".*1001-1100x5"):
        parse_frames(text)


@pytest.mark.parametrize(("text", "why"), [("5-1", "backwards.*1-5"), ("1-5x0", "step of 0")])
def test_empty_ranges_are_refused(text, why):
    """A range that holds no frame is a slip."""
    with pytest.raises(ValueError, match=why):
        parse_frames(text)


@pytest.mark.parametrize("text", ["0-999999999", "1-60000,1-60000", ",".join(["-999999999-999999999"] * 9)])
def test_absurdly_long_sets_are_refused(text):
    """A set is counted before it is built."""
    with pytest.raises(ValueError, match=f"at most {MOST_FRAMES}"):
        parse_frames(text)


@given(st.sets(st.integers(-500, 500), min_size=1))
def test_frames_survive_being_text(frames):
    """What format_frames writes, parse_frames reads."""
    assert parse_frames(format_frames(frames)) == sorted(frames)


@pytest.mark.parametrize(
    "pattern",
    [
        "front.%04d.exr",
        "front.%d.exr",
        "front.####.exr",
        "front.#.exr",
        "front.@@@@.exr",
        "front.$F4.exr",
        "front.$F.exr",
        "front.*.exr",
        "front.10??.exr",
        "front.1001-1003#.exr",
        "front.1001-1003x2,1002@@@@.exr",
    ],
)
def test_every_pattern_finds_the_sequence(tmp_path, pattern):
    """All ways to write the frame number find the same files and none beside them."""
    touch(tmp_path, *(f"front.{frame}.exr" for frame in (1001, 1002, 1003)))
    touch(tmp_path, "back.1001.exr", "front.1001.png", "front.exr", ".front.1004.exr", "afront.1.exr")
    found = find_sequence(tmp_path / pattern)
    assert names(found) == {frame: f"front.{frame}.exr" for frame in (1001, 1002, 1003)}
    assert find_sequence(str(tmp_path / pattern)) == found


def test_a_folder_is_a_sequence(tmp_path):
    """Numbers without padding sort as numbers, holes stay, and what is no image does not matter."""
    touch(tmp_path, "fire_v2_10.png", "fire_v2_9.png", "fire_v2_100.PNG", "README.md", ".fire_v2_11.png")
    (tmp_path / "old").mkdir()
    found = find_sequence(tmp_path)
    assert list(found) == [9, 10, 100]
    assert names(found)[100] == "fire_v2_100.PNG"


@pytest.mark.parametrize(("name", "frame"), [("plate.png", 1), ("front.1001.exr", 1001), ("a[1]#2.####.jpg", 2)])
def test_one_image_is_a_sequence(tmp_path, name, frame):
    """A file that is there is never taken for a pattern; its number is its frame."""
    touch(tmp_path, name, "front.1002.exr")
    assert names(find_sequence(tmp_path / name)) == {frame: name}


def test_a_pattern_may_ask_for_some_frames(tmp_path):
    """The frames in a pattern choose from those there are."""
    touch(tmp_path, *(f"a.{frame:04d}.png" for frame in range(1, 10)))
    assert list(find_sequence(tmp_path / "a.1-7x3#.png")) == [1, 4, 7]
    with pytest.raises(ValueError, match="missing frames: 10-12; there are 1-9"):
        find_sequence(tmp_path / "a.8-12####.png")


@pytest.mark.parametrize("pattern", ["", "*.png"])
def test_several_sequences_are_listed(tmp_path, pattern):
    """Two sequences in one place are an error that names both, and how to name one."""
    touch(tmp_path, "front.1.png", "front.2.png", "side.1.png")
    with pytest.raises(ValueError, match=r"front\.####\.png \(2\), side\.####\.png \(1\); name one"):
        find_sequence(tmp_path / pattern)


def test_the_list_of_sequences_is_short(tmp_path):
    """A folder of a hundred pictures gives no page of names."""
    touch(tmp_path, *(f"{letter}.1.png" for letter in "abcdefghij"))
    with pytest.raises(ValueError, match=r"e\.####\.png \(1\) and 5 more; name one"):
        find_sequence(tmp_path)


def test_mixed_types_are_listed(tmp_path):
    """The same frames as PNG and EXR are two sequences."""
    touch(tmp_path, "front.1.png", "front.1.exr")
    with pytest.raises(ValueError, match=r"front\.####\.exr \(1\), front\.####\.png \(1\)"):
        find_sequence(tmp_path)


@pytest.mark.parametrize("pattern", ["", "a.#.png", "a.*.png"])
def test_one_number_twice_is_an_error(tmp_path, pattern):
    """Which of a.1.png and a.01.png is frame 1 cannot be known."""
    touch(tmp_path, "a.1.png", "a.01.png")
    with pytest.raises(ValueError, match=r"a\.01\.png and a\.1\.png are both frame 1"):
        find_sequence(tmp_path / pattern)


@pytest.mark.parametrize("pattern", ["front.%04d.exr", "front.exr", "front.*.exr", "back.*.exr"])
def test_what_is_not_there_is_an_error_that_helps(tmp_path, pattern):
    """The error says what the folder holds instead."""
    touch(tmp_path, "back.1.png", "back.2.png", "clip.mp4")
    with pytest.raises(FileNotFoundError, match=r"holds back\.####\.png \(2\) and other files \(\.mp4\)"):
        find_sequence(tmp_path / pattern)


def test_missing_or_empty_folders_are_errors(tmp_path):
    """The error names the folder."""
    with pytest.raises(FileNotFoundError, match=r"no folder .*nowhere"):
        find_sequence(tmp_path / "nowhere" / "a.####.png")
    with pytest.raises(FileNotFoundError, match="holds no files"):
        find_sequence(tmp_path)


@pytest.mark.parametrize("name", ["clip.mp4", "front.####", "notes.txt", "front.%04d.dpx"])
def test_other_kinds_are_refused(tmp_path, name):
    """What ends like no image is refused, with the endings that are read."""
    touch(tmp_path, "clip.mp4", "notes.txt")
    with pytest.raises(ValueError, match=r"\.exr .*\.png"):
        find_sequence(tmp_path / name)


def test_two_frame_numbers_are_refused(tmp_path):
    """A pattern has one place for the frame number."""
    with pytest.raises(ValueError, match="two places"):
        find_sequence(tmp_path / "a.####.%04d.png")


def test_folders_with_images_are_named(tmp_path):
    """The folder above the pictures is a slip: those below that have some are named, hidden and empty ones not."""
    for name in ("front", "side", ".cache", "empty"):
        (tmp_path / name).mkdir()
    for name in ("front/a.1.png", "front/a.2.png", "side/b.1.exr", ".cache/c.png", "empty/notes.txt"):
        (tmp_path / name).touch()
    with pytest.raises(FileNotFoundError, match=r"in it, front \(2\), side \(1\) hold images: name one"):
        find_sequence(tmp_path)
    (tmp_path / "side" / "b.1.exr").unlink()
    with pytest.raises(FileNotFoundError, match=r"in it, front \(2\) holds images"):
        find_sequence(tmp_path)


@pytest.mark.parametrize(
    ("pattern", "file", "left"),
    [
        ("a.####.png", "a.0007.png", "a.left.####.png"),
        ("a_%04d.exr", "a_0007.exr", "a.left.%04d.exr"),
        ("a.%d.png", "a.7.png", "a.left.%d.png"),
        ("a#.png", "a7.png", "a.left.#.png"),
        ("a.$F4.png", "a.0007.png", "a.left.$F4.png"),
        ("a.$F.png", "a.7.png", "a.left.$F.png"),
        ("a@@@.png", "a007.png", "a.left.@@@.png"),
        ("a.png", "a.png", "a.left.png"),
    ],
)
def test_names_to_write(tmp_path, pattern, file, left):
    """Each way to write the frame number that is read can be written."""
    path = numbered_path(tmp_path / pattern, 7)
    assert path.name == file
    assert insert_word(tmp_path / pattern, "left").name == left
    assert has_number(pattern) == (pattern != "a.png")
    path.touch()
    assert names(find_sequence(tmp_path / pattern)) == {7 if has_number(pattern) else 1: file}


@pytest.mark.parametrize("pattern", ["a.##.%d.png", "a.1-5#.png"])
def test_names_with_two_numbers_cannot_be_written(pattern):
    """Nor those that say which frames to read."""
    with pytest.raises(ValueError, match=r"one place for the frame number, such as name\.####\.png"):
        numbered_path(pattern, 1)
