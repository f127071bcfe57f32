"""What a run was made of: the footage, found again through the runs that it came from."""

from dataclasses import dataclass

import numpy as np

from warpfluid.footage.shot import Shot, open_shot
from warpfluid.options import InputOptions
from warpfluid.run import SETTINGS, Run
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
    shot = open_shot(origin["views"], InputOptions(**origin.get("input", {})))
    return Footage(shot=shot, shoulder=origin.get("reconstruct", {}).get("shoulder", 0.0))


def find_reconstruction(document: dict | None) -> dict | None:
    """Return what ``run.toml`` says of the reconstruction that a run began with; None if there is none.

    Raises:
        ValueError: If a run on the way is no longer one.
    """
    for _ in range(LONGEST_CHAIN):
        if document is None or document.get("views"):
            return document
        source = Run(document.get("source") or "")
        if not document.get("source") or not (source.folder / SETTINGS).is_file():
            return None
        document = read_settings(source.folder / SETTINGS)
    return None
