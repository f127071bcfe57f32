"""What is looked at: a sequence of volumes, and how it is to be shown at first."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from warpfluid.files.sequences import format_frames, parse_frames
from warpfluid.options import PreviewOptions
from warpfluid.rendering.ramps import RAMPS
from warpfluid.rendering.surfaces import Surface
from warpfluid.rendering.turntable import render_turntable
from warpfluid.run import RECORDS, Run
from warpfluid.simulation.outlines import Outline, Outlines
from warpfluid.volumes import VolumeSequence, open_volumes, squared

USUAL_RATE = 24.0  # frames a second where nothing says another
USUAL_LOOK = "fire"
TRIED = 8  # frames all along a sequence, of which the brightest becomes the still picture
SOLID_COLOURS = {"body": "#d9a066", "obstacle": "#8a93a6"}


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Volumes to look at.

    Attributes:
        volumes: The sequence.
        frames: Those of its frames that are shown, rising.
        look: Name of the colour ramp.
        rate: Frames a second.
        angle_deg: Where the camera stands at first.
        elevation_deg: How high it stands; None where that is left open.
        exposure: Stops brighter than the footage.
    """

    volumes: VolumeSequence
    frames: tuple[int, ...]
    look: str
    rate: float
    angle_deg: float
    elevation_deg: float | None = None
    exposure: float = 0.0

    @property
    def title(self) -> str:
        """Name of the run, or of the first file of foreign volumes."""
        name = Path(self.volumes.name).expanduser()
        return name.resolve().name if name.is_dir() else name.name

    @property
    def middle(self) -> int:
        """The frame that stands for all where only one can be shown."""
        return self.frames[len(self.frames) // 2]

    def brightest(self) -> int:
        """Return which of a few frames all along the sequence holds the most; the middle one of equals."""
        places = np.linspace(0, len(self.frames) - 1, TRIED).round().astype(int)
        few = dict.fromkeys([self.middle, *(self.frames[place] for place in places)])
        return max(few, key=lambda frame: float(self.volumes.density(frame).sum(dtype=np.float64)))

    def still(self, size: tuple[int, int] | None = None) -> np.ndarray:
        """Draw the brightest frame without a graphics library, level with the floor.

        Args:
            size: Width and height [pixel]; what the box leaves of it shows nothing. By default those of the box.

        Returns:
            The picture, uint8, shape (rows, columns, 3).
        """
        frame = self.brightest()
        density = squared(self.volumes.density(frame))
        surfaces = [Surface(solid.vertices, solid.triangles) for solid in self.solids(frame, density.shape)]
        facts = {"white": 255 / 2**self.exposure, "surfaces": surfaces, "lines": size[1] if size else 0}
        picture = render_turntable(density, [self.angle_deg], self.look, **facts)[0]
        return letterboxed(picture, size, RAMPS[self.look][0]) if size else picture

    def solids(self, frame: int, shape: Sequence[int]) -> list[Outline]:
        """Return the bodies and obstacles of a frame; volumes of another program have none.

        Args:
            frame: Its number.
            shape: Of the volumes (x, z, y).

        Raises:
            ValueError: If what the run says of them is damaged.
            OSError: If it cannot be read.
        """
        return self._outlines.at(frame, tuple(shape)) if self._outlines else []

    @cached_property
    def _outlines(self) -> Outlines | None:
        return Outlines(Run(self.volumes.name)) if self.volumes.document else None

    def facts(self) -> dict[str, str]:
        """Return what the run's files say of it, in words, by what it is."""
        document = self.volumes.document
        if document is None:
            return {
                "kind": "volumes of another program",
                "exposure": f"brightest ray of frame {self.frames[0]} is white",
            }
        made = "simulated" if "simulate" in document else document.get("reconstruct", {}).get("method", "reconstructed")
        views = ", ".join(f"{angle:g}°" for angle in self.volumes.angles_deg)
        facts = {"made by": made, "views": views, "voxel": f"{self.volumes.output.voxel_size:g} units"}
        return facts | _means(Run(self.volumes.name), self.frames) | {"warpfluid": document["made-with"]["warpfluid"]}


def open_scene(source: str | Path, options: PreviewOptions | None = None) -> Scene:
    """Find volumes and how they look.

    Args:
        source: A run; a folder, pattern or file of volumes.
        options: What is shown of them, and how.

    Raises:
        ValueError: If there are none, or a frame is missing.
        OSError: If they cannot be read.
    """
    options = options or PreviewOptions()
    wanted = sorted(set(parse_frames(options.frames))) if options.frames else None
    volumes = open_volumes(source)
    missing = sorted(set(wanted or ()) - set(volumes.frames))
    if missing:
        have = format_frames(volumes.frames)
        raise ValueError(f"{source} lacks frame {format_frames(missing)} (it has {have}): choose others with --frames")
    own = volumes.output.look if volumes.output.look in RAMPS else USUAL_LOOK
    return Scene(
        volumes=volumes,
        frames=tuple(wanted or volumes.frames),
        look=options.look or own,
        rate=float((volumes.document or {}).get("simulate", {}).get("fps", USUAL_RATE)),
        angle_deg=volumes.angles_deg[0] if options.angle is None else options.angle,
        elevation_deg=options.elevation,
        exposure=options.exposure,
    )


def letterboxed(picture: np.ndarray, size: tuple[int, int], around: Sequence[int]) -> np.ndarray:
    """Return a picture as large as fits into a size, in the middle of it.

    Args:
        picture: uint8, shape (rows, columns, 3).
        size: Width and height [pixel].
        around: Colour of what it does not cover.
    """
    from PIL import Image

    rows, columns = picture.shape[:2]
    factor = min(size[0] / columns, size[1] / rows)
    width, height = max(round(columns * factor), 1), max(round(rows * factor), 1)
    canvas = Image.new("RGB", size, tuple(int(part) for part in around))
    fitting = Image.fromarray(picture).resize((width, height), Image.Resampling.BICUBIC)
    canvas.paste(fitting, ((size[0] - width) // 2, (size[1] - height) // 2))
    return np.asarray(canvas)


def _means(run: Run, frames: Sequence[int]) -> dict[str, str]:
    """Return means over the records of a run, where it has any."""
    if not (run.folder.expanduser() / RECORDS).is_file():
        return {}
    records = [record for frame, record in run.records().items() if frame in frames]
    seconds = [record["seconds"] for record in records if "seconds" in record]
    likeness = [np.mean(record["input_psnr"]) for record in records if record.get("input_psnr")]
    found = {"time": f"{np.mean(seconds):.2g} s a frame"} if seconds else {}
    return found | ({"input views": f"{min(np.mean(likeness), 99):.0f} dB PSNR"} if likeness else {})
