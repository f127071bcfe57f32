"""The rigid bodies of a simulated run: what its settings say they are, and where its file has them."""

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path

import numpy as np

from warpfluid.files.bodies import read_bodies
from warpfluid.options.scene import make_thing
from warpfluid.run import BODIES
from warpfluid.simulation.placing import Placing
from warpfluid.simulation.rigid_body import RigidBody


class RecordedBodies:
    """The bodies of a run. Its file is read when it is first asked for.

    Args:
        settings: Those of the run.
        folder: Its folder.

    Attributes:
        path: Of the file; a run without bodies has none.

    Raises:
        ValueError: If the settings are damaged.
    """

    def __init__(self, settings: Mapping, folder: Path):
        self._options = [make_thing("body", table, where="run.toml: [[body]] ") for table in settings.get("body", ())]
        self.path = folder / BODIES

    @property
    def names(self) -> list[str]:
        """One a body; none without a file.

        Raises:
            ValueError: If the file is damaged or does not fit the settings.
            OSError: If it cannot be read.
        """
        return self._read[0]

    @property
    def states(self) -> dict[int, list[dict[str, np.ndarray]]]:
        """The bodies by frame number, as ``read_bodies`` returns them; raises as ``names`` does."""
        return self._read[1]

    def place(self, shape: tuple[int, int, int], frame: int) -> list[RigidBody]:
        """Return the bodies as they start.

        Args:
            shape: Of the run's volumes (x, z, y), whose voxels are the unit of length.
            frame: At which keyed numbers are looked up.

        Raises:
            ValueError: If a mesh is damaged.
            OSError: If a mesh cannot be read.
        """
        placing = Placing(tuple(shape), 1.0)
        return [placing.body(options, frame) for options in self._options]

    @cached_property
    def _read(self) -> tuple[list[str], dict[int, list[dict[str, np.ndarray]]]]:
        if not (self._options and self.path.is_file()):
            return [], {}
        names, frames = read_bodies(self.path)
        if len(names) != len(self._options):
            raise ValueError(f"{self.path} has {len(names)} bodies, the settings {len(self._options)}")
        return names, frames
