"""Where pictures go: numbered files, one still or a film, as the ending of a name says."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from warpfluid.files.atomic import remove_left
from warpfluid.files.folders import check_writable
from warpfluid.files.sequences import has_number, insert_word, numbered_path
from warpfluid.rendering.display import quantize
from warpfluid.rendering.picture import Picture

STILLS, FILMS = (".exr", ".png"), (".mp4", ".webp", ".gif")
EYES = ("left", "right")
Screen = Callable[[Picture, float], np.ndarray]


@dataclass(frozen=True, kw_only=True)
class Target:
    """What is written.

    Attributes:
        path: A film, a still, or numbered stills with the place of the number as ``####``.
        separate: Two eyes have files of their own.
        half: Half precision in .exr.
        deep: 16 bits a channel in .png.

    Raises:
        ValueError: If no picture can have that name, or its folder is protected.
    """

    path: Path
    separate: bool = False
    half: bool = False
    deep: bool = False

    def __post_init__(self):
        ending = self.path.suffix.lower()
        if ending not in (*STILLS, *FILMS):
            known = ", ".join((*STILLS, *FILMS))
            raise ValueError(f"{self.path} is of an unknown kind: end the name in one of {known}")
        if self.is_film and self.separate:
            raise ValueError(f"{self.path} is one film, and the eyes are separate: choose --stereo side-by-side")
        if self.is_film and self.is_numbered:
            raise ValueError(f"{self.path} is a film, which needs no frame number: leave it out")
        numbered_path(self.path, 1)
        folder = self.path.absolute().parent
        if not next(there for there in (folder, *folder.parents) if there.exists()).is_dir():
            raise ValueError(f"{self.path.parent} cannot be a folder, there is a file: choose another name with -o")
        check_writable(folder)

    @property
    def is_film(self) -> bool:
        """Whether all pictures go into one file."""
        return self.path.suffix.lower() in FILMS

    @property
    def is_numbered(self) -> bool:
        """Whether each picture has a file."""
        return has_number(self.path)

    def make_folder(self) -> None:
        """Make the folder that the files go into, without what a killed render left half written in it.

        Raises:
            OSError: If it cannot be made.
        """
        folder = self.path.absolute().parent
        folder.mkdir(parents=True, exist_ok=True)
        remove_left(folder)

    def files(self, number: int) -> list[Path]:
        """Return the files of a picture: one, or one an eye."""
        names = [insert_word(self.path, eye) for eye in EYES] if self.separate else [self.path]
        return [numbered_path(name, number) for name in names]

    def write(self, number: int, eyes: Sequence[Picture], screen: Screen, unit: float) -> list[Path]:
        """Write a picture into its files, and return them.

        Args:
            number: In the name.
            eyes: One picture, or the left and the right one.
            screen: Makes the values of a screen, 0 to 1, of a picture and a number.
            unit: Edge of a voxel in the units of the scene, which depth is stored in.

        Raises:
            OSError: If a file cannot be written.
        """
        from warpfluid.files.exr import write_exr
        from warpfluid.files.images import write_png

        files = self.files(number)
        for file, picture in zip(files, eyes if self.separate else [side_by_side(eyes)], strict=True):
            if file.suffix.lower() == ".exr":
                write_exr(file, layers(picture, unit), half=self.half)
            else:
                write_png(file, quantize(screen(picture, number), 16 if self.deep else 8))
        return files

    def screen(self, number: float, eyes: Sequence[Picture], screen: Screen) -> np.ndarray:
        """Return a picture of a film, uint8 (rows, columns, 3)."""
        return quantize(screen(side_by_side(eyes), number))

    def film(self, screens: Iterable[np.ndarray], rate: float) -> None:
        """Write all pictures into one film.

        Args:
            screens: What ``screen`` returns, one after the other.
            rate: Frames a second.

        Raises:
            ValueError: If there is no picture.
            OSError: If the file cannot be written.
        """
        from warpfluid.files.video import write_animation, write_video

        write = write_video if self.path.suffix.lower() == ".mp4" else write_animation
        write(self.path, screens, rate)


def layers(picture: Picture, unit: float) -> dict[str, np.ndarray]:
    """Return the channels of a picture's .exr.

    Args:
        picture: Linear light, colours multiplied by alpha.
        unit: Edge of a voxel in the units of the scene.

    Returns:
        ``RGBA``; ``Z``, depth in units of the scene, infinite where there is nothing; ``density``, the sum along the
        ray in grey levels; ``emission.R`` and so on, the part of the colour that the fluid gives itself.
    """
    channels = {
        "RGBA": np.concatenate([picture.color, picture.alpha[..., None]], axis=2),
        "Z": picture.depth * unit,
        "density": picture.density,
    }
    return channels | {f"emission.{name}": picture.emission[..., i] for i, name in enumerate("RGB")}


def side_by_side(eyes: Sequence[Picture]) -> Picture:
    """Return pictures in one, from left to right."""
    if len(eyes) == 1:
        return eyes[0]
    layers = {f.name: [getattr(eye, f.name) for eye in eyes] for f in fields(Picture)}
    return Picture(**{name: np.concatenate(parts, axis=1) for name, parts in layers.items() if parts[0] is not None})
