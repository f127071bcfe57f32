"""Video files: frames as light, and turntables to look at."""

import itertools
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator
from contextlib import suppress
from fractions import Fraction
from pathlib import Path

import numpy as np

from warpfluid.files.atomic import replacing
from warpfluid.files.images import Depth, to_light
from warpfluid.files.limits import MOST_PIXELS, check_sides

VIDEO_SUFFIXES = (
    *(".avi", ".flv", ".gif", ".m2ts", ".m4v", ".mkv", ".mov", ".mp4", ".mpeg", ".mpg"),
    *(".mts", ".mxf", ".ogv", ".ts", ".webm", ".wmv"),
)
# FFmpeg goes by what is in a file, which may be a list of other files and addresses: kinds that hold pictures only.
KINDS = "asf,avi,flv,gif,matroska,webm,mov,mp4,m4a,3gp,3g2,mj2,mpeg,mpegts,mpegvideo,mxf,ogg"
SAFE = {"protocol_whitelist": "file", "format_whitelist": KINDS}
HD_ROWS = 720  # from here on, untagged colours are those of BT.709
UNSPECIFIED, BT709, LIMITED_RANGE = 2, 1, 1  # as H.273 numbers them, and FFmpeg
QUALITY = "16"  # constant rate factor of x264: no difference to be seen


class Video:
    """A video, read frame by frame; from one thread at a time.

    Attributes:
        path: The file.
        size: Width and height as shown, after any rotation that the file asks for [pixel].
        count: Number of frames.
        rate: Frames a second, or None where the file does not tell.
        depth: ``8 bit``, or ``16 bit`` for all that has more.

    Raises:
        OSError: If the file cannot be opened.
        ValueError: If it is no video, or is cut off; the error tells how many frames are good.
    """

    path: Path
    size: tuple[int, int]
    count: int
    rate: float | None
    depth: Depth

    def __init__(self, path: str | Path):
        self.path = Path(path)
        self._decoder: Iterator | None = None
        self._next = 0  # the frame that the decoder gives next
        self._survey()

    def read(self, index: int) -> np.ndarray:
        """Read a frame; the next one is cheap, any other is decoded from the key frame before it.

        Args:
            index: Number of the frame, from 0.

        Returns:
            Light, float32, shape (rows, columns, 3), 0..1, top row first; colours multiplied by alpha.

        Raises:
            OSError: If the file is gone.
            ValueError: If there is no such frame or the file is damaged.
        """
        if not 0 <= index < self.count:
            raise ValueError(f"{self.path} has frames 0 to {self.count - 1}, not {index}")
        return self._picture(self._frame(index))

    def close(self) -> None:
        """Close the file; the next read opens it again."""
        if self._decoder is not None:
            self._decoder.close()
        self._decoder = None

    def __getstate__(self) -> dict:
        """Leave the open file behind when going to another process."""
        return self.__dict__ | {"_decoder": None}

    def _survey(self) -> None:
        """Look at the first frame; walk through the file without decoding to count and time the others."""
        with self._open() as container:
            stream = container.streams.video[0]
            rate, promised = stream.average_rate or stream.guessed_rate, stream.frames
            packets = list(_packets(container))
        with self._open() as container:
            first = next(_good_frames(container), None)
        if first is None or len(packets) < promised:
            raise self._damage(promised)
        # what comes before the first frame that can be decoded was cut from its key frame, or is not for show
        times = [time for time, _, is_shown in packets if is_shown]
        timed = first.pts is not None and None not in times and len(set(times)) == len(times)
        self._times = sorted(time for time in times if time >= first.pts) if timed else []
        self._keys = [0, *sorted({self._position(time) for time, is_key, _ in packets if is_key} - {-1, 0})]
        self.count = len(self._times or times)
        self.rate = float(rate) if rate else None
        self.depth = "16 bit" if first.format.components[0].bits > 8 else "8 bit"
        rows, columns = self._picture(first).shape[:2]
        self.size = (columns, rows)

    def _open(self):
        """Return the open file, with a video in it."""
        import av

        with self.path.open("rb"):  # what cannot be opened at all is Python's error
            pass
        try:
            container = av.open(f"file:{self.path}", metadata_errors="ignore", options=SAFE)
        except av.FFmpegError as error:
            raise ValueError(f"{self.path} is no video, or is cut off: {error.strerror}") from error
        if not container.streams.video:
            container.close()
            raise ValueError(f"{self.path} holds no video, only sound or the like; or it is cut off")
        if container.streams.video[0].codec_context is None:
            container.close()
            raise ValueError(f"{self.path} holds video of an unknown kind: convert it to H.264 or ProRes")
        container.streams.video[0].codec_context.options = {"max_pixels": str(MOST_PIXELS)}
        container.streams.video[0].thread_type = "AUTO"
        return container

    def _frame(self, index: int):
        """Return a decoded frame, going on where the last read ended if no key frame is nearer."""
        import av

        key = self._keys[bisect_right(self._keys, index) - 1]
        if self._decoder is None or not key <= self._next <= index:
            self.close()
            self._decoder = self._decode(key)
        try:
            for position, frame in self._decoder:
                if position == index:
                    self._next = index + 1
                    return frame
                if position > index:
                    break
        except av.FFmpegError as error:
            self.close()
            raise self._damage(self.count) from error
        self.close()
        if not self._times:
            raise self._damage(self.count)
        self._times, self._keys = [], [0]  # the times in the file mislead: count from the start
        return self._frame(index)

    def _decode(self, key: int) -> Iterator:
        """Yield frames with their numbers, from a key frame on."""
        with self._open() as container:
            if key:
                container.seek(self._times[key], stream=container.streams.video[0])
            for count, frame in enumerate(container.decode(video=0)):
                yield self._position(frame.pts) if self._times else count, frame

    def _position(self, time: int | None) -> int:
        """Return the number of the frame that is shown at a time, -1 where none is."""
        position = -1 if time is None else bisect_left(self._times, time)
        return position if 0 <= position < len(self._times) and self._times[position] == time else -1

    def _picture(self, frame) -> np.ndarray:
        """Return a decoded frame as light, upright."""
        import av

        try:
            check_sides(frame.width, frame.height)
        except ValueError as error:
            raise ValueError(f"{self.path} cannot be read: {error}") from error
        parts = frame.format.components
        alpha = any(part.is_alpha for part in parts)
        deep, shallow = ("rgba64le", "rgba") if alpha else ("rgb48le", "rgb24")
        unsaid = frame.colorspace == UNSPECIFIED and frame.height >= HD_ROWS
        try:
            samples = frame.to_ndarray(
                format=deep if parts[0].bits > 8 else shallow, src_colorspace="ITU709" if unsaid else None
            )
        except av.FFmpegError as error:
            raise ValueError(f"{self.path} has colours of an unknown kind ({frame.format.name})") from error
        return np.ascontiguousarray(np.rot90(to_light(samples), round(frame.rotation / 90)))

    def _damage(self, promised: int) -> ValueError:
        """Return the error of a damaged file, which tells how much of it is good."""
        with self._open() as container:
            good = sum(1 for _ in _good_frames(container))
        frames = f"the first {good} of its {promised} frames" if promised else "no frames"
        way_out = f"; to use them: ffmpeg -i {self.path.name} -frames:v {good} good.mov" if good else ""
        return ValueError(f"{self.path} is cut off or damaged: {frames} can be read{way_out}")


def write_video(path: str | Path, pictures: Iterable[np.ndarray], rate: float) -> None:
    """Write an H.264 video that plays everywhere; an odd width or height grows by a line like its last.

    Args:
        path: The ``.mp4`` file; its folder must exist.
        pictures: uint8, shape (rows, columns, 3), top row first, all of one size.
        rate: Frames a second.

    Raises:
        OSError: If the file cannot be written.
        ValueError: If the suffix, the rate or a picture is wrong, or there is no picture.
    """
    import av

    _check_target(path, (".mp4",), rate)
    pictures = _alike(path, pictures)
    first = next(pictures)
    try:
        with replacing(path) as file, av.open(file, "w", format="mp4") as container:
            stream = _add_stream(container, first, rate)
            for picture in itertools.chain([first], pictures):
                padded = np.pad(picture, [(0, n % 2) for n in picture.shape[:2]] + [(0, 0)], mode="edge")
                frame = av.VideoFrame.from_ndarray(padded, format="rgb24")
                container.mux(stream.encode(frame.reformat(format="yuv420p", dst_colorspace="ITU709")))
            container.mux(stream.encode(None))
    except av.FFmpegError as error:
        raise OSError(f"{path} cannot be written: {error.strerror}") from error


def write_animation(path: str | Path, pictures: Iterable[np.ndarray], rate: float) -> None:
    """Write an animation for web pages that repeats forever.

    Args:
        path: The ``.webp`` file, or ``.gif``, which is larger, has 256 colours and counts time in 1/100 s;
            its folder must exist.
        pictures: uint8, shape (rows, columns, 3), top row first, all of one size.
        rate: Frames a second.

    Raises:
        OSError: If the file cannot be written.
        ValueError: If the suffix, the rate or a picture is wrong, or there is no picture.
    """
    from PIL import Image

    _check_target(path, (".webp", ".gif"), rate)
    first, *others = [Image.fromarray(picture) for picture in _alike(path, pictures)]
    kind = Path(path).suffix[1:].upper()
    tick = 10 if kind == "GIF" else 1  # ms
    ends = np.rint(np.arange(len(others) + 2) * (1000 / rate / tick)) * tick  # rounded so that none adds up
    options = {"quality": 90} if kind == "WEBP" else {}
    with replacing(path) as file:
        durations = np.diff(ends).astype(int).tolist()
        first.save(file, kind, save_all=True, append_images=others, duration=durations, loop=0, **options)


def _packets(container) -> Iterator[tuple[int | None, bool, bool]]:
    """Yield of each packet its time, if it is a key frame, and if it is shown, up to any damage."""
    import av

    with suppress(av.FFmpegError):
        for packet in container.demux(video=0):
            is_end = not packet.size and packet.dts is None
            if not (is_end or packet.is_corrupt):
                yield packet.pts, packet.is_keyframe, bool(packet.size) and not packet.is_discard


def _good_frames(container) -> Iterator:
    """Yield the frames up to any damage."""
    import av

    stream = container.streams.video[0]
    stream.thread_type = "NONE"  # threads would go on past the damage
    with suppress(av.FFmpegError):
        for packet in itertools.takewhile(lambda packet: not packet.is_corrupt, container.demux(stream)):
            yield from packet.decode()
    with suppress(av.FFmpegError):  # at the end of a whole file the decoder is empty, and says so
        yield from stream.codec_context.decode(None)


def _add_stream(container, picture: np.ndarray, rate: float):
    """Return a video stream for pictures of this size, its colours tagged as those of HD video."""
    try:
        stream = container.add_stream("libx264", rate=Fraction(rate).limit_denominator(1001))
    except ValueError as error:  # PyAV built without it
        raise ValueError("PyAV has no encoder libx264: install av from PyPI, or write .webp") from error
    rows, columns = picture.shape[:2]
    stream.width, stream.height = columns + columns % 2, rows + rows % 2
    stream.pix_fmt = "yuv420p"
    stream.options = {"crf": QUALITY, "mbtree": "0"}  # that tree reads memory beyond the picture: other bytes each time
    codec = stream.codec_context
    codec.thread_count = 1  # more threads, other bytes
    codec.colorspace = codec.color_primaries = codec.color_trc = BT709
    codec.color_range = LIMITED_RANGE
    return stream


def _check_target(path: str | Path, suffixes: tuple[str, ...], rate: float) -> None:
    """Refuse a file name or a rate that no file can be made of."""
    if Path(path).suffix not in suffixes:
        raise ValueError(f"{path} must end in {' or '.join(suffixes)}")
    if not 0.1 <= rate <= 1000:
        raise ValueError(f"rate is {rate} frames a second: choose one between 0.1 and 1000, such as 24")


def _alike(path: str | Path, pictures: Iterable[np.ndarray]) -> Iterator[np.ndarray]:
    """Yield the pictures, at least one, all uint8 RGB of one size."""
    shape = None
    for number, picture in enumerate(pictures):
        shape = shape or picture.shape
        if picture.dtype != np.uint8 or picture.ndim != 3 or picture.shape[2] != 3 or picture.shape != shape:
            raise ValueError(
                f"picture {number} of {path} is {picture.dtype} {picture.shape}: all must be uint8 "
                f"(rows, columns, 3) and of the size of the first, {shape}"
            )
        yield picture
    if shape is None:
        raise ValueError(f"{path} would have no pictures")
