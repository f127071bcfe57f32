"""The footage of one view, and how its pictures become images."""

import hashlib
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from warpfluid.footage.alignment import Alignment
from warpfluid.footage.matting import SMALLEST, Matting, parse_crop, parse_resolution
from warpfluid.options import InputOptions

STRETCH = 0.02  # change of proportions that is worth a note
HASHED_BYTES = 1 << 20


@dataclass(frozen=True, kw_only=True)
class Source:
    """The footage of one view.

    Attributes:
        angle_deg: Angle of the view.
        footage: What ``open_footage`` returned.
        offset: Frame of the shot less frame of the footage: videos count from 1, sequences as their files do.
        alignment: How it is brought in line with the other views.
        matting: How its pictures become images.
    """

    angle_deg: float
    footage: object
    offset: int = 0
    alignment: Alignment = field(default_factory=Alignment)
    matting: Matting | None = None

    @property
    def name(self) -> str:
        """The view as the command line names it, ANGLE=PATH."""
        return f"{self.angle_deg:g}={self.footage.source}"

    @property
    def step(self) -> int:
        """Frames from one picture of the footage to the next: 2 for a sequence on twos."""
        return min((b - a for a, b in pairwise(self.footage.frames)), default=1)

    @property
    def frames(self) -> tuple[int, ...]:
        """The frames that the footage has, in the shot's numbers; between two pictures if it plays so."""
        later, share = self._delay
        first = self.footage.frames
        if share:
            first = tuple(a for a, b in pairwise(first) if b - a == self.step)
        return tuple(number + self.offset + later for number in first)

    def numbers(self, frames: Iterable[int]) -> list[int]:
        """Return the footage's own numbers of the pictures that some frames of the shot are made of."""
        later, share = self._delay
        first = {frame - self.offset - later for frame in set(frames) & set(self.frames)}
        return sorted(first | {number + self.step for number in first if share})

    def paths(self, frame: int) -> list[Path]:
        """Return the files that a frame is made of."""
        if self.footage.kind == "video":
            return list(self.footage.paths)
        return [self.footage.paths[self.footage.frames.index(number)] for number in self.numbers([frame])]

    def light(self, frame: int) -> np.ndarray:
        """Return the light of a frame, or of the picture before it, shape (rows, columns), before it is scaled."""
        return self.matting.light(self.footage.read(frame - self.offset - self._delay[0]))

    def image(self, frame: int) -> np.ndarray:
        """Return the image of a frame, shape (u, v), 255 for white; between two pictures it is a blend of them."""
        later, share = self._delay
        number = frame - self.offset - later
        image = self.matting.image(self.footage.read(number))
        if not share:
            return image
        after = self.matting.image(self.footage.read(number + self.step))
        return image + np.float32(share) * (after - image)

    @property
    def _delay(self) -> tuple[int, float]:
        """Whole steps by which the view plays later [frame], and how far it is then on the way to the next picture."""
        steps = self.alignment.time / self.step
        return math.ceil(steps) * self.step, math.ceil(steps) - steps

    def with_matting(self, **changes) -> "Source":
        """Return the source with another preparation."""
        return replace(self, matting=replace(self.matting, **changes))


def parse_view(view: str | tuple[float, str]) -> tuple[float, str]:
    """Return angle and path of ``ANGLE=PATH`` or a pair."""
    angle, equals, path = view.partition("=") if isinstance(view, str) else (view[0], "=", str(view[1]))
    try:
        angle_deg = float(angle)
    except ValueError:
        equals = ""
    if not equals or not path.strip():
        raise ValueError(f"view {view!r} is not ANGLE=PATH with an angle in degrees, such as 0=front.mp4")
    return angle_deg, path.strip()


def image_size(source: Source, options: InputOptions, notes: list[str]) -> tuple[int, int]:
    """Return width and height of a view's images [pixel]: its footage, cropped and reduced.

    Raises:
        ValueError: If the crop does not fit, or the resolution would enlarge the picture or leave too little.
    """
    width, height = source.footage.size
    if options.crop:
        crop_width, crop_height, left, top = parse_crop(options.crop)
        if left + crop_width > width or top + crop_height > height:
            raise ValueError(f"--crop {options.crop} does not fit into {source.name}, {width} x {height} pixels")
        width, height = crop_width, crop_height
    size = width, height
    if options.resolution:
        new_width, new_height = parse_resolution(options.resolution)
        size = new_width, new_height or max(1, round(new_width * height / width))
        if size[0] > width or size[1] > height:
            raise ValueError(
                f"--resolution {options.resolution} is larger than {source.name}, {width} x {height} pixels: "
                "pictures are only ever reduced"
            )
        if abs(size[0] * height / (size[1] * width) - 1) > STRETCH and new_height:
            notes.append(f"{source.name} changes its proportions, {width} x {height} to {size[0]} x {size[1]}")
    if min(size) < SMALLEST:
        raise ValueError(f"{source.name} has {size[0]} x {size[1]} pixels: at least {SMALLEST} x {SMALLEST} are needed")
    return size


def spread(frames: Sequence[int], count: int) -> list[int]:
    """Return at most ``count`` of the frames, evenly spread, the first and last among them."""
    places = np.unique(np.linspace(0, len(frames) - 1, min(count, len(frames))).round().astype(int))
    return [frames[place] for place in places]


def file_hash(paths: Sequence[str | Path]) -> str:
    """Return a SHA-256 over the name, size, first and last megabyte of every file, quick on long footage."""
    digest = hashlib.sha256()
    for path in map(Path, paths):
        size = path.stat().st_size
        digest.update(f"{path.name}\0{size}\0".encode())
        with path.open("rb") as file:
            digest.update(file.read(HASHED_BYTES))
            file.seek(max(size - HASHED_BYTES, HASHED_BYTES if size > HASHED_BYTES else size))
            digest.update(file.read())
    return digest.hexdigest()
