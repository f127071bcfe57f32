"""What a run was made of: the footage, found again through the runs that it came from."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warpfluid.footage.shot import Shot, open_shot
from warpfluid.options import InputOptions
from warpfluid.run import SETTINGS
from warpfluid.settings import read_settings

LONGEST_CHAIN = 16  # a simulation of a simulation of ...


@dataclass(frozen=True, kw_only=True)
class Footage:
    """The views that a volume was made of.

    Attributes:
        shot: The footage, prepared as for the run.
        shoulder: Tone curve that was undone, see ``ReconstructOptions``.
    """

    shot: Shot
    shoulder: float = 0.0

    @property
    def angles_deg(self) -> tuple[float, ...]:
        """Angle of each view."""
        return self.shot.angles_deg

    def images(self, frame: int) -> np.ndarray | None:
        """Return the views of a frame, shape (view, u, v); None if any view lacks it."""
        there = all(frame in source.frames for source in self.shot.sources)
        return self.shot.views(frame).images if there else None


def find_footage(document: dict | None) -> Footage | None:
    """Open the footage of a run, or of the run that it follows.

    Args:
        document: What ``run.toml`` says; None for volumes of another program.

    Returns:
        The footage; None if the run was made of none.

    Raises:
        ValueError: If it is not there any more, or damaged.
        OSError: If it cannot be read.
    """
    origin = find_reconstruction(document)
    if origin is None:
        return None
    shoulder = origin.get("reconstruct", {}).get("shoulder", 0.0)
    shot = open_shot(origin["views"], InputOptions(**origin.get("input", {})), shoulder)
    return Footage(shot=shot, shoulder=shoulder)


def find_reconstruction(document: dict | None) -> dict | None:
    """Return what ``run.toml`` says of the reconstruction that a run began with; None if there is none.

    Raises:
        ValueError: If a run on the way is damaged.
    """
    origin = find_origin(document)
    return origin if origin and origin.get("views") else None


def find_origin(document: dict | None) -> dict | None:
    """Return what ``run.toml`` says of the first of the runs that led to a run: a reconstruction, or an empty box.

    Args:
        document: What that of the run itself says.

    Returns:
        The first one's; None if it is not there any more, or volumes of another program were the first.

    Raises:
        ValueError: If a run on the way is damaged.
    """
    for _ in range(LONGEST_CHAIN):
        if document is None or not document.get("source"):
            return document
        path = Path(document["source"]) / SETTINGS
        document = read_settings(path) if path.is_file() else None
    return None
