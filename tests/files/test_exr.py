"""OpenEXR pictures."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import OpenEXR
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warpfluid.files import limits
from warpfluid.files.exr import read_exr, write_exr


def picture(rows=7, columns=11, channels=3):
    """Return light of all sizes, different in every pixel."""
    shape = (rows, columns, channels) if channels else (rows, columns)
    return np.random.default_rng(0).lognormal(size=shape).astype(np.float32)


def write_windows(path, pixels, data_corner, display):
    """Write an RGB file whose data and display windows differ, with the library alone."""
    x, y = data_corner
    window = (
        np.array([x, y], np.int32),
        np.array([x + pixels.shape[1] - 1, y + pixels.shape[0] - 1], np.int32),
    )
    header = {"dataWindow": window, "displayWindow": tuple(np.array(corner, np.int32) for corner in display)}
    OpenEXR.File(header, {"RGB": pixels}).write(str(path))


@given(rows=st.integers(1, 20), columns=st.integers(1, 20))
@settings(max_examples=20, deadline=None)
def test_a_picture_comes_back_exactly(tmp_path_factory, rows, columns):
    """Float32 RGB survives writing and reading, whatever its size."""
    path, pixels = tmp_path_factory.mktemp("exr") / "a.exr", picture(rows, columns)
    write_exr(path, {"RGB": pixels})
    assert np.array_equal(read_exr(path), pixels)


@pytest.mark.parametrize(
    "view",
    [
        lambda a: a[::-1],
        lambda a: a[:, ::2],
        lambda a: a.T,
        np.asfortranarray,
        lambda a: np.broadcast_to(a[:1], a.shape),
        lambda a: a.astype(np.float64),
        lambda a: a > 1,
    ],
)
def test_any_array_is_written_right(tmp_path, view):
    """The library alone writes wrong pixels of arrays that are not C-contiguous; read it with the library."""
    array = view(picture(channels=0))
    write_exr(tmp_path / "a.exr", {"Y": array})
    with OpenEXR.File(str(tmp_path / "a.exr")) as file:
        assert np.array_equal(file.channels()["Y"].pixels, array.astype(np.float32))
    assert np.array_equal(read_exr(tmp_path / "a.exr")[..., 0], array.astype(np.float32))


def test_a_slice_of_colours_is_written_right(tmp_path):
    """Colours turned and mirrored are not contiguous either."""
    pixels = picture(channels=4)
    write_exr(tmp_path / "a.exr", {"RGB": pixels[::-1, :, 2::-1]})
    assert np.array_equal(read_exr(tmp_path / "a.exr"), pixels[::-1, :, 2::-1])


def test_half_floats_are_rounded(tmp_path):
    """Half the size, three digits."""
    pixels = picture()
    write_exr(tmp_path / "a.exr", {"RGB": pixels}, half=True)
    assert np.array_equal(read_exr(tmp_path / "a.exr"), pixels.astype(np.float16).astype(np.float32))


def test_too_large_for_half_is_an_error(tmp_path):
    """What would become infinite is not written."""
    with pytest.raises(ValueError, match=r"B holds 70000.*half=False"):
        write_exr(tmp_path / "a.exr", {"B": np.array([[1, -7e4, np.nan]])}, half=True)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("channels", "chosen"),
    [
        ("RGBA", "RGB"),
        ("RGBYZ", "RGB"),
        ("YAZ", "Y"),
        ("Y", "Y"),
        ("A", "A"),
        (("density",), ("density",)),
        (("fire.R", "fire.G", "fire.B", "Z"), ("fire.R", "fire.G", "fire.B")),
        (("R", "G", "B", "fire.R", "fire.G", "fire.B"), "RGB"),
    ],
)
def test_the_picture_is_found_among_channels(tmp_path, channels, chosen):
    """RGB goes before Y, and Y before a single channel; alpha is left out."""
    arrays = {name: picture(channels=0) + index for index, name in enumerate(channels)}
    OpenEXR.File({}, dict(arrays)).write(str(tmp_path / "a.exr"))
    assert np.array_equal(read_exr(tmp_path / "a.exr"), np.stack([arrays[name] for name in chosen], axis=-1))


@pytest.mark.parametrize("channels", [("u", "v"), ("a.R", "a.G", "a.B", "b.R", "b.G", "b.B"), ("R", "G")])
def test_unclear_channels_are_listed(tmp_path, channels):
    """Which channels are the picture is not guessed."""
    write_exr(tmp_path / "a.exr", {name: picture(channels=0) for name in channels})
    with pytest.raises(ValueError, match=rf"a\.exr .*{', '.join(sorted(channels))}"):
        read_exr(tmp_path / "a.exr")


def test_the_part_with_a_picture_is_read(tmp_path):
    """A part of vectors before the picture does not matter."""
    flow = OpenEXR.Part({}, {"u": picture(channels=0), "v": picture(channels=0)}, name="flow")
    beauty = OpenEXR.Part({}, {"RGB": picture()}, name="beauty")
    OpenEXR.File([flow, beauty]).write(str(tmp_path / "a.exr"))
    assert np.array_equal(read_exr(tmp_path / "a.exr"), picture())


def test_a_small_data_window_is_placed(tmp_path):
    """Light that was cropped is put back where it was, on black."""
    write_windows(tmp_path / "a.exr", picture(), (5, 2), ((0, 0), (29, 19)))
    expected = np.zeros((20, 30, 3), np.float32)
    expected[2:9, 5:16] = picture()
    assert np.array_equal(read_exr(tmp_path / "a.exr"), expected)


def test_overscan_is_cut_off(tmp_path):
    """What lies outside the display window is not part of the picture."""
    write_windows(tmp_path / "a.exr", picture(), (-3, -1), ((0, 0), (4, 3)))
    assert np.array_equal(read_exr(tmp_path / "a.exr"), picture()[1:5, 3:8])


def test_a_data_window_beside_the_display_is_black(tmp_path):
    """Nothing of the data is in the picture."""
    write_windows(tmp_path / "a.exr", picture(), (100, 100), ((0, 0), (4, 3)))
    assert np.array_equal(read_exr(tmp_path / "a.exr"), np.zeros((4, 5, 3), np.float32))


@pytest.mark.parametrize("share", [0.0, 0.001, 0.05, 0.5, 0.99])
def test_a_cut_off_file_is_one_quiet_error(tmp_path, capfd, share):
    """The error names the file, and the library's own prints are kept back."""
    path = tmp_path / "a.exr"
    write_exr(path, {"RGB": picture(60, 50)})
    path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
    with pytest.raises(ValueError, match=r"a\.exr"):
        read_exr(path)
    assert capfd.readouterr() == ("", "")


def test_damaged_pixels_are_named_as_such(tmp_path, capfd):
    """A file whose header is whole is not said to be without channels."""
    path = tmp_path / "a.exr"
    write_exr(path, {"RGB": np.ones((60, 50, 3))})
    content = path.read_bytes()
    path.write_bytes(content[:-40] + bytes(40))
    with pytest.raises(ValueError, match="pixels are damaged"):
        read_exr(path)
    assert capfd.readouterr() == ("", "")


def test_others_may_print_while_a_file_is_read(tmp_path, capfd):
    """Nothing on stderr is lost when a file is whole."""
    write_exr(tmp_path / "a.exr", {"RGB": picture()})
    read_exr(tmp_path / "a.exr")
    print("here")
    assert capfd.readouterr() == ("here\n", "")


@pytest.mark.parametrize("closed", ["2>&-", ">&- 2>&-", "2>/dev/null"])
def test_closed_streams_do_not_matter(tmp_path, closed):
    """Schedulers and services start programs without any."""
    write_exr(tmp_path / "a.exr", {"RGB": picture()})
    program = f"""
import sys
from warpfluid.files.exr import read_exr
sys.exit(0 if read_exr({str(tmp_path / "a.exr")!r}).shape == (7, 11, 3) else 3)
"""
    command = f'exec "$0" -c "$1" {closed}'
    assert subprocess.run(["sh", "-c", command, sys.executable, program], timeout=60, check=False).returncode == 0


def test_an_absurd_size_is_refused(tmp_path):
    """A display window of terapixels is refused before memory is taken."""
    write_windows(tmp_path / "a.exr", picture(), (0, 0), ((0, 0), (2_000_000, 2_000_000)))
    with pytest.raises(ValueError, match="displayWindow is 2000001 x 2000001"):
        read_exr(tmp_path / "a.exr")


def write_flat(path, size, names="RGBA", display=None, compression=OpenEXR.DWAA_COMPRESSION):
    """Write black channels of some size, which hardly take room."""
    header = {"compression": compression, "type": OpenEXR.scanlineimage}
    if display:
        header["displayWindow"] = tuple(np.array(corner, np.int32) for corner in ((0, 0), np.subtract(display, 1)))
    black = np.zeros(size[::-1], np.float16)
    OpenEXR.File(header, dict.fromkeys(names, black)).write(str(path))


def test_a_cropped_frame_fills_any_display(tmp_path):
    """Renderers crop black frames to one pixel, whatever else they hold."""
    names = ["R", "G", "B", "A", *(f"shadow.{number}" for number in range(20))]
    write_flat(tmp_path / "a.exr", (1, 1), names, (4096, 2160))
    found = read_exr(tmp_path / "a.exr")
    assert found.shape == (2160, 4096, 3)
    assert not found.any()


@pytest.mark.parametrize(("count", "allowed"), [(4, True), (80, False)])
def test_flat_frames_may_be_small_for_their_size(tmp_path, monkeypatch, count, allowed):
    """8K of RGBA is told from what no file of that size holds; the pixels are not read here."""
    header = {
        "dataWindow": ((0, 0), (7679, 4319)),
        "displayWindow": ((0, 0), (7679, 4319)),
        "channels": [None] * count,
    }
    parts = [SimpleNamespace(header=header)]
    (tmp_path / "a.exr").write_bytes(b"\x76\x2f\x31\x01")
    monkeypatch.setattr(OpenEXR, "File", lambda *_, **__: SimpleNamespace(parts=parts))
    monkeypatch.setattr("warpfluid.files.exr._picture", lambda parts: parts)
    if allowed:
        assert read_exr(tmp_path / "a.exr") is parts
    else:
        with pytest.raises(ValueError, match="it promises 10617 MB"):
            read_exr(tmp_path / "a.exr")


def test_the_parts_of_a_file_count_together(tmp_path, monkeypatch):
    """Each is allowed alone; all are read."""
    write_flat(tmp_path / "a.exr", (40, 30))
    part = OpenEXR.File(str(tmp_path / "a.exr")).parts[0]
    many = [OpenEXR.Part(dict(part.header), {"RGBA": np.zeros((30, 40, 4), np.float16)}, f"p{n}") for n in range(3)]
    OpenEXR.File(many).write(str(tmp_path / "b.exr"))
    monkeypatch.setattr(limits, "MOST_A_BYTE", 0)
    monkeypatch.setattr("warpfluid.files.exr.FLAT_PICTURE", 2 * 40 * 30 * 16)
    assert read_exr(tmp_path / "a.exr").shape == (30, 40, 3)
    with pytest.raises(ValueError, match="promises"):
        read_exr(tmp_path / "b.exr")


def test_what_is_no_exr_is_refused(tmp_path):
    """A missing file and a file of another kind are different errors."""
    (tmp_path / "a.exr").write_bytes(b"\x89PNG")
    with pytest.raises(ValueError, match="no OpenEXR file"):
        read_exr(tmp_path / "a.exr")
    with pytest.raises(FileNotFoundError, match=r"b\.exr"):
        read_exr(tmp_path / "b.exr")


@pytest.mark.parametrize(
    "channels",
    [
        {},
        {"Y": np.zeros(3)},
        {"Y": np.zeros((2, 2, 1))},
        {"Y": np.zeros((0, 2))},
        {"RGB": np.zeros((2, 2))},
        {"u": np.zeros((2, 2)), "v": np.zeros((2, 3))},
    ],
)
def test_wrong_shapes_are_refused(tmp_path, channels):
    """Channels must be pictures of one size."""
    with pytest.raises(ValueError, match=r"a\.exr needs channels of one shape"):
        write_exr(tmp_path / "a.exr", channels)
    assert not list(tmp_path.iterdir())


def test_an_unwritable_place_is_an_os_error(tmp_path):
    """The folder must exist."""
    with pytest.raises(OSError, match=r"a\.exr"):
        write_exr(tmp_path / "nowhere" / "a.exr", {"RGB": picture()})
