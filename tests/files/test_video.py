"""Videos: reading any frame, and writing what browsers play."""

import pickle

import av
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from warpfluid.files.video import Video, write_animation, write_video

SIZE = (64, 48)


def gray_level(index):
    """Return the grey level of a test frame: no two alike."""
    return 20 + 7 * index


def encode(path, count=30, codec="libx264", pixel="yuv420p", size=SIZE, options=None, container=None, **settings):
    """Write frames whose grey level tells their number, with PyAV alone."""
    with av.open(str(path), "w", options=container or {}) as file:
        stream = file.add_stream(codec, rate=24)
        stream.width, stream.height = size
        stream.pix_fmt, stream.options, stream.bit_rate = pixel, options or {}, 8_000_000
        for name, value in settings.items():
            getattr(stream, name)(*value)
        for index in range(count):
            array = np.full((size[1], size[0], 3), gray_level(index), np.uint8)
            file.mux(stream.encode(av.VideoFrame.from_ndarray(array, format="rgb24")))
        file.mux(stream.encode(None))
    return path


def number(picture):
    """Return the number of the test frame that a picture shows."""
    return round((255 * float(picture.mean()) - gray_level(0)) / 7)


def pictures(count=5, rows=48, columns=64):
    """Return moving pictures: a bright square on a dark red ground."""
    made = np.zeros((count, rows, columns, 3), np.uint8)
    made[..., 0] = 60
    for index, picture in enumerate(made):
        picture[8:24, 4 * index : 4 * index + 16] = (230, 180, 90)
    return made


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("a.mp4", {"options": {"g": "8", "bf": "3"}}),
        ("a.mkv", {"options": {"g": "8", "bf": "3"}}),
        ("a.ts", {"options": {"g": "8", "bf": "3"}}),
        ("a.avi", {"codec": "mpeg4", "options": {"g": "8"}}),
        ("a.mpg", {"codec": "mpeg2video", "options": {"g": "8", "bf": "2"}}),
        ("a.mov", {"codec": "prores_ks", "pixel": "yuv422p10le"}),
        ("a.webm", {"codec": "libvpx-vp9", "options": {"g": "8"}}),
        ("a.gif", {"codec": "gif", "pixel": "gray"}),
    ],
)
def test_every_frame_is_found_from_everywhere(tmp_path, name, options):
    """Forwards, backwards and by leaps, in every common container: always the frame that was asked for."""
    path = encode(tmp_path / name, **options)
    with av.open(str(path)) as file:
        expected = [frame.to_ndarray(format="rgb24") for frame in file.decode(video=0)]
    video = Video(path)
    assert (video.count, video.size) == (30, SIZE)
    assert video.rate == pytest.approx(24, rel=0.05)
    for index in [*range(30), 5, 5, 4, 29, 0, 17, 18, 8, 7, 16]:
        assert number(video.read(index)) == index
        assert np.abs(video.read(index) - expected[index] / 255).max() < 3 / 255


@given(st.lists(st.integers(0, 29), min_size=1, max_size=8))
@settings(max_examples=15, deadline=None)
def test_reading_has_no_memory(tmp_path_factory, order):
    """What a read returns does not depend on the reads before it."""
    path = tmp_path_factory.getbasetemp() / "order.mp4"
    if not path.exists():
        encode(path, options={"g": "7"})
    video = Video(path)
    for index in order:
        assert np.array_equal(video.read(index), Video(path).read(index))


def test_a_key_frame_spares_decoding(tmp_path, monkeypatch):
    """A leap decodes from the nearest key frame, a step decodes one frame."""
    video = Video(encode(tmp_path / "a.mp4", options={"g": "10", "bf": "0", "sc_threshold": "0"}))
    decoded = []
    decode = Video._decode
    monkeypatch.setattr(
        Video, "_decode", lambda self, key: (decoded.append(pair[0]) or pair for pair in decode(self, key))
    )
    video.read(25)
    video.read(26)
    assert decoded == list(range(20, 27))


def test_depth_is_kept(tmp_path):
    """Ten bits are read as such: steps far below 1/255 survive."""
    with av.open(str(tmp_path / "a.mkv"), "w") as file:
        stream = file.add_stream("ffv1", rate=24)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "gbrp10le"
        ramp = np.tile(np.arange(48 * 64).reshape(48, 64, 1) * 20, 3).astype(np.uint16)
        file.mux(stream.encode(av.VideoFrame.from_ndarray(ramp, format="rgb48le")))
        file.mux(stream.encode(None))
    video = Video(tmp_path / "a.mkv")
    assert video.depth == "16 bit"
    light = video.read(0)
    assert np.abs(light - ramp / 65535).max() < 1.5 / 1023
    assert len(np.unique(light)) > 900


def test_alpha_is_multiplied_in(tmp_path):
    """What is transparent in a ProRes 4444 element is black."""
    with av.open(str(tmp_path / "a.mov"), "w") as file:
        stream = file.add_stream("prores_ks", rate=24)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuva444p10le"
        array = np.full((48, 64, 4), 200, np.uint8)
        array[:, :, 3] = np.repeat([255, 0], 32)
        file.mux(stream.encode(av.VideoFrame.from_ndarray(array, format="rgba")))
        file.mux(stream.encode(None))
    light = Video(tmp_path / "a.mov").read(0)
    assert light.shape == (48, 64, 3)
    assert np.allclose(light[:, :30], 200 / 255, atol=0.02)
    assert light[:, 34:].max() < 0.01


@pytest.mark.parametrize(("degrees", "turned"), [(90, 1), (180, 2), (-90, 3), (0, 0)])
def test_rotation_is_obeyed(tmp_path, degrees, turned):
    """A phone's video is turned the way its player turns it: degrees count against the clock."""
    pixels = pictures(1)
    with av.open(str(tmp_path / "a.mp4"), "w") as file:
        stream = file.add_stream("libx264", rate=24)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        stream.set_display_rotation(degrees)
        file.mux(stream.encode(av.VideoFrame.from_ndarray(pixels[0], format="rgb24")))
        file.mux(stream.encode(None))
    video = Video(tmp_path / "a.mp4")
    expected = np.rot90(pixels[0], turned) / 255
    assert video.size == expected.shape[1::-1]
    assert np.abs(video.read(0) - expected).mean() < 0.02


@pytest.mark.parametrize("tagged", [True, False])
def test_hd_colours_are_those_of_hd(tmp_path, tagged):
    """Untagged video of 720 rows and more is BT.709, as players take it."""
    with av.open(str(tmp_path / "a.mp4"), "w") as file:
        stream = file.add_stream("libx264", rate=24)
        stream.width, stream.height, stream.pix_fmt, stream.options = 1280, 720, "yuv420p", {"crf": "4"}
        if tagged:
            stream.codec_context.colorspace = 1
        array = np.full((720, 1280, 3), (200, 40, 10), np.uint8)
        frame = av.VideoFrame.from_ndarray(array, format="rgb24")
        file.mux(stream.encode(frame.reformat(format="yuv420p", dst_colorspace="ITU709")))
        file.mux(stream.encode(None))
    assert np.abs(255 * Video(tmp_path / "a.mp4").read(0)[100, 100] - (200, 40, 10)).max() < 3


def test_a_cut_off_video_tells_how_much_is_good(tmp_path):
    """The header promises 30 frames, the file ends before: the error has the number and the way out."""
    path = encode(tmp_path / "a.mp4", options={"g": "8"}, container={"movflags": "faststart"})
    content = path.read_bytes()
    path.write_bytes(content[: len(content) * 9 // 10])
    with pytest.raises(ValueError, match=r"a\.mp4 is cut off or damaged: the first (\d+) of its 30 frames") as caught:
        Video(path)
    good = int(str(caught.value).split("first ")[1].split()[0])
    assert 1 <= good < 30
    assert f"-frames:v {good}" in str(caught.value)


def test_a_damaged_frame_is_an_error_when_it_is_read(tmp_path):
    """Frames before the damage can be read."""
    path = encode(tmp_path / "a.mov", codec="png", pixel="rgb24", count=10)
    with av.open(str(path)) as file:
        packet = next(packet for packet in file.demux(video=0) if packet.pts and number_of(packet) == 6)
        position, size = packet.pos, packet.size
    content = bytearray(path.read_bytes())
    content[position : position + size] = bytes(size)
    path.write_bytes(content)
    video = Video(path)
    assert [number(video.read(index)) for index in range(6)] == list(range(6))
    with pytest.raises(ValueError, match=r"a\.mov is cut off or damaged: the first 6 of its 10 frames"):
        video.read(6)


@given(data=st.data())
@settings(max_examples=40, deadline=None)
def test_damaged_videos_end_in_a_value_error_if_at_all(tmp_path_factory, data):
    """Random damage never ends in a foreign exception."""
    folder = tmp_path_factory.getbasetemp()
    whole = folder / data.draw(st.sampled_from(["whole.mp4", "whole.mkv", "whole.ts"]))
    if not whole.exists():
        encode(whole, count=8)
    content = bytearray(whole.read_bytes())
    for _ in range(data.draw(st.integers(1, 9))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path = folder / f"damaged{whole.suffix}"
    path.write_bytes(content)
    error = None
    try:
        video = Video(path)
        assert video.read(video.count - 1).shape == (*video.size[::-1], 3)
    except ValueError as found:
        error = found
    assert type(error) in (type(None), ValueError)
    assert error is None or str(path) in str(error)


def test_odd_letters_in_a_title_do_not_matter(tmp_path):
    """Old programs write metadata in any encoding."""
    with av.open(str(tmp_path / "a.mkv"), "w") as file:
        file.metadata["title"] = "Feuer"
        stream = file.add_stream("ffv1", rate=24)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        file.mux(stream.encode(av.VideoFrame.from_ndarray(pictures(1)[0], format="rgb24")))
        file.mux(stream.encode(None))
    content = (tmp_path / "a.mkv").read_bytes()
    assert b"Feuer" in content
    (tmp_path / "a.mkv").write_bytes(content.replace(b"Feuer", b"F\xe4\xe4\xe4r"))
    assert Video(tmp_path / "a.mkv").count == 1


def number_of(packet):
    """Return which frame a packet of a video without reordering holds."""
    return round(packet.pts * packet.time_base * 24)


@pytest.mark.parametrize("content", [b"", b"no video at all" * 100])
def test_what_is_no_video_is_refused(tmp_path, capfd, content):
    """The error names the file, and nothing is printed."""
    (tmp_path / "a.mp4").write_bytes(content)
    with pytest.raises(ValueError, match=r"a\.mp4 is no video"):
        Video(tmp_path / "a.mp4")
    assert capfd.readouterr() == ("", "")


def test_a_short_flat_clip_of_6k_is_read(tmp_path):
    """Black frames take a few kilobytes, and no more is wrong with them."""
    with av.open(str(tmp_path / "a.mp4"), "w") as container:
        stream = container.add_stream("libx264", rate=24)
        stream.width, stream.height, stream.pix_fmt = 6016, 3392, "yuv420p"
        stream.options = {"preset": "veryfast"}
        black = av.VideoFrame(6016, 3392, "yuv420p")
        for plane, level in zip(black.planes, (16, 128, 128), strict=True):
            plane.update(bytes([level]) * plane.buffer_size)
        container.mux(stream.encode(black))
        container.mux(stream.encode(None))
    assert (tmp_path / "a.mp4").stat().st_size < 12_000
    assert Video(tmp_path / "a.mp4").size == (6016, 3392)


def test_a_missing_video_is_an_os_error(tmp_path):
    """The error names the file."""
    with pytest.raises(FileNotFoundError, match=r"a\.mp4"):
        Video(tmp_path / "a.mp4")


def test_sound_alone_is_refused(tmp_path):
    """A file may hold no picture."""
    with av.open(str(tmp_path / "a.mov"), "w") as file:
        stream = file.add_stream("pcm_s16le", rate=8000)
        frame = av.AudioFrame.from_ndarray(np.zeros((1, 1000), np.int16), layout="mono")
        frame.rate = 8000
        file.mux(stream.encode(frame))
    with pytest.raises(ValueError, match="holds no video"):
        Video(tmp_path / "a.mov")


@pytest.mark.parametrize("index", [-1, 30])
def test_frames_beyond_the_ends_are_refused(tmp_path, index):
    """The error names the frames there are."""
    with pytest.raises(ValueError, match="0 to 29"):
        Video(encode(tmp_path / "a.mp4")).read(index)


def test_a_video_goes_to_another_process(tmp_path):
    """The open file stays behind."""
    video = Video(encode(tmp_path / "a.mp4"))
    video.read(7)
    assert number(pickle.loads(pickle.dumps(video)).read(12)) == 12
    video.close()
    assert number(video.read(8)) == 8


@pytest.mark.parametrize(("rows", "columns"), [(48, 64), (47, 63), (144, 271)])
def test_written_video_is_what_went_in(tmp_path, rows, columns):
    """Odd sizes repeat their last line, colours come back, and the rate is kept."""
    made = pictures(6, rows, columns)
    write_video(tmp_path / "a.mp4", iter(made), 24)
    video = Video(tmp_path / "a.mp4")
    assert (video.count, video.rate, video.depth) == (6, 24.0, "8 bit")
    assert video.size == (columns + columns % 2, rows + rows % 2)
    for index, picture in enumerate(made):
        grown = np.pad(picture, [(0, rows % 2), (0, columns % 2), (0, 0)], mode="edge")
        assert np.abs(video.read(index) - grown / 255).mean() < 0.02


@pytest.mark.parametrize("rate", [23.976, 0.5, 60, 30000 / 1001])
def test_any_rate_is_kept(tmp_path, rate):
    """Rates of film and television are fractions."""
    write_video(tmp_path / "a.mp4", pictures(5), rate)
    assert Video(tmp_path / "a.mp4").rate == pytest.approx(rate, rel=1e-4)


@pytest.mark.parametrize(("name", "tick"), [("a.webp", 1), ("a.gif", 10)])
def test_written_animation_is_what_went_in(tmp_path, name, tick):
    """All frames are there, it repeats forever, and its length is right to one tick."""
    made = pictures(8)
    write_animation(tmp_path / name, iter(made), 24)
    with Image.open(tmp_path / name) as image:
        assert (image.n_frames, image.size, image.info["loop"]) == (8, SIZE, 0)
        length = 0
        for index, picture in enumerate(made):
            image.seek(index)
            shown = np.array(image.convert("RGB"))
            length += image.info["duration"]
            assert np.abs(shown / 255 - picture / 255).mean() < 0.03
    assert abs(length - 8 * 1000 / 24) <= tick


@pytest.mark.parametrize(
    ("write", "name"), [(write_video, "a.mp4"), (write_animation, "a.webp"), (write_animation, "a.gif")]
)
def test_wrong_pictures_leave_nothing_behind(tmp_path, write, name):
    """No pictures, other types and unlike sizes are errors; an old file stays as it was."""
    (tmp_path / name).write_bytes(b"old")
    for wrong, why in [
        ([], "no pictures"),
        ([np.zeros((4, 4, 3))], "picture 0 .*float64"),
        ([np.zeros((4, 4), np.uint8)], "picture 0"),
        ([*pictures(2), pictures(1, 46)[0]], "picture 2"),
    ]:
        with pytest.raises(ValueError, match=why):
            write(tmp_path / name, wrong, 24)
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [(name, b"old")]


@pytest.mark.parametrize(("write", "name"), [(write_video, "a.avi"), (write_animation, "a.mp4")])
def test_other_suffixes_and_rates_are_refused(tmp_path, write, name):
    """The error says what can be written."""
    with pytest.raises(ValueError, match=r"must end in \."):
        write(tmp_path / name, pictures(), 24)
    good = "a.mp4" if write is write_video else "a.gif"
    for rate in (0, -1, float("nan"), 1e6):
        with pytest.raises(ValueError, match="rate is"):
            write(tmp_path / good, pictures(), rate)


def test_an_unwritable_place_is_an_os_error(tmp_path):
    """The folder must exist."""
    for write, name in [(write_video, "a.mp4"), (write_animation, "a.gif")]:
        with pytest.raises(OSError, match=name):
            write(tmp_path / "nowhere" / name, pictures(), 24)
