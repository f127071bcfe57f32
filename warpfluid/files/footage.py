"""Footage: a video or an image sequence, read by frame number."""

import difflib
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from warpfluid.files.images import IMAGE_SUFFIXES, Depth, decode_image, is_of_views
from warpfluid.files.sequences import find_sequence, format_frames
from warpfluid.files.video import VIDEO_SUFFIXES, Video

MOST_NAMES = 5  # of what there is in place of what is not
ALIKE = 0.7  # of 1, names that may be meant


@dataclass(frozen=True)
class Footage:
    """What one camera saw: pictures by frame number.

    It can be sent to another process; a video is read from one thread at a time.

    Attributes:
        source: What the user named.
        frames: The frame numbers there are, rising.
        size: Width and height of every picture [pixel].
        kind: ``video`` or ``images``.
        depth: ``8 bit``, ``16 bit`` or ``float``, of the first picture.
        rate: Frames a second, or None where nothing tells.
        linear: Whether pixel values are linear light, as float files hold.
        paths: The video, or one image a frame.
    """

    source: str
    frames: tuple[int, ...]
    size: tuple[int, int]
    kind: Literal["video", "images"]
    depth: Depth
    rate: float | None
    linear: bool
    paths: tuple[Path, ...]
    _video: Video | None = field(default=None, repr=False, compare=False)

    def read(self, frame: int) -> np.ndarray:
        """Read the picture of a frame.

        Args:
            frame: One of ``frames``.

        Returns:
            Light, float32, shape (rows, columns, 1 or 3), top row first; 0..1 unless the files are float.

        Raises:
            OSError: If a file cannot be opened.
            ValueError: If there is no such frame, or its picture is damaged, not of the size of the first,
                or has values that are not finite.
        """
        if frame not in self.frames:
            raise ValueError(f"{self.source} has no frame {frame}: {self._nearest(frame)}")
        index = self.frames.index(frame)
        if self._video is not None:
            picture, name = self._video.read(index), f"{self.source}, frame {frame},"
        else:
            picture, name = decode_image(self.paths[index])[0], str(self.paths[index])
        self._check(picture, name)
        return picture

    def _nearest(self, frame: int) -> str:
        """Say which frames there are about one that is missing."""
        below = [number for number in self.frames if number < frame][-1:]
        above = [number for number in self.frames if number > frame][:1]
        nearest = " and ".join(str(number) for number in below + above)
        return f"nearest to it {'are' if below and above else 'is'} {nearest}, of {format_frames(self.frames)}"

    def _check(self, picture: np.ndarray, name: str) -> None:
        """Refuse a picture that does not belong to the others or holds no light."""
        rows, columns = picture.shape[:2]
        if (columns, rows) != self.size:
            width, height = self.size
            raise ValueError(f"{name} is {columns} x {rows} pixels, but the first picture is {width} x {height}")
        wrong = picture.size - np.count_nonzero(np.isfinite(picture))
        if wrong:
            raise ValueError(f"{name} holds {wrong} values that are infinite or not numbers: replace them, say by 0")


def open_footage(source: str | Path, *, first_frame: int = 1) -> Footage:
    """Open a video or an image sequence and look at its first frame.

    Args:
        source: A video file, or what ``find_sequence`` takes: a folder, a pattern, an image.
        first_frame: Number of a video's first frame; images keep the numbers in their names.

    Raises:
        OSError: If nothing is there.
        ValueError: If it is no video, no sequence of images, or damaged.
    """
    path = Path(os.path.expanduser(source))
    suffix = path.suffix.lower()
    if not path.exists() and (not suffix or suffix in VIDEO_SUFFIXES):
        raise FileNotFoundError(f"{source} does not exist: {_nearest_names(path)}")
    if not path.is_dir() and suffix not in IMAGE_SUFFIXES + VIDEO_SUFFIXES:
        known = f"images ({' '.join(IMAGE_SUFFIXES)}), videos ({' '.join(VIDEO_SUFFIXES)})"
        raise ValueError(f"{source} is neither a folder nor of a known kind: {known}")
    if not path.is_dir() and suffix in VIDEO_SUFFIXES:
        return _open_video(path, str(source), first_frame)
    return _open_images(find_sequence(source), str(source))


def _nearest_names(path: Path) -> str:
    """Say what there is in place of footage that there is not: first what is spelt alike."""
    if not path.parent.is_dir():
        return f"there is no folder {path.parent}"
    known = IMAGE_SUFFIXES + VIDEO_SUFFIXES
    there = sorted(
        file.name
        for file in path.parent.iterdir()
        if not (file.name.startswith(".") or is_of_views(file)) and (file.is_dir() or file.suffix.lower() in known)
    )
    alike = difflib.get_close_matches(path.name, there, 3, ALIKE)
    if alike:
        return f"did you mean {' or '.join(alike)}?"
    more = f" and {len(there) - MOST_NAMES} more" if len(there) > MOST_NAMES else ""
    where = "this folder" if path.parent == Path() else path.parent
    return f"{where} has {', '.join(there[:MOST_NAMES])}{more}" if there else "check its name"


def _open_video(path: Path, source: str, first_frame: int) -> Footage:
    """Return the footage in a video file."""
    video = Video(path)
    return Footage(
        source=source,
        frames=tuple(range(first_frame, first_frame + video.count)),
        size=video.size,
        kind="video",
        depth=video.depth,
        rate=video.rate,
        linear=False,
        paths=(path,),
        _video=video,
    )


def _open_images(files: dict[int, Path], source: str) -> Footage:
    """Return the footage in image files."""
    picture, depth = decode_image(next(iter(files.values())))
    rows, columns = picture.shape[:2]
    return Footage(
        source=source,
        frames=tuple(files),
        size=(columns, rows),
        kind="images",
        depth=depth,
        rate=None,
        linear=depth == "float",
        paths=tuple(files.values()),
    )
