"""Pictures that are kept from the check of a shot to its inspection, as far as memory allows: reading them is slow."""

from collections.abc import Collection, Sequence

import numpy as np

from warpfluid.footage.preparing import CHECKED_FRAMES, SAMPLED_FRAMES
from warpfluid.footage.sources import spread
from warpfluid.memory import free_memory

INSPECTED_FRAMES = 64  # row sums are compared over these, from the middle of the shot
LOOKED_AT_FRAMES = 8  # of these, for all that needs the pictures
SHARE = 0.125  # of the free memory that kept pictures may take


class Keeping:
    """Footage that keeps some pictures once they have been read.

    Sent to another process it comes without them.

    Args:
        footage: What ``open_footage`` returned.
        wanted: Numbers of the pictures that are worth it.
        room: Memory for them [byte].
    """

    def __init__(self, footage, wanted: Collection[int], room: float):
        self._footage, self._wanted, self._room = footage, frozenset(wanted), room
        self._pictures: dict[int, np.ndarray] = {}

    def __getattr__(self, name: str):
        if name.startswith("__") or name == "_footage":  # while it is unpacked it has none
            raise AttributeError(name)
        return getattr(self._footage, name)

    def __reduce__(self):
        return Keeping, (self._footage, (), 0.0)

    def read(self, number: int) -> np.ndarray:
        """Read a picture, see ``Footage.read``."""
        picture = self._pictures.get(number)
        if picture is None:
            picture = self._footage.read(number)
            if number in self._wanted and picture.nbytes <= self._room:
                self._room -= picture.nbytes
                self._pictures[number] = picture
        return picture

    def forget(self) -> None:
        """Give the memory back, and keep nothing from now on."""
        self._wanted = frozenset()
        self._pictures.clear()


def inspected(frames: Sequence[int]) -> Sequence[int]:
    """Return the frames whose row sums an inspection compares, a run of them from the middle."""
    start = max(0, (len(frames) - INSPECTED_FRAMES) // 2)
    return frames[start : start + INSPECTED_FRAMES]


def frames_to_keep(frames: Sequence[int]) -> set[int]:
    """Return the frames that are read more than once before a run."""
    return {*inspected(frames), *spread(frames, SAMPLED_FRAMES), *spread(frames, CHECKED_FRAMES)}


def room_for(count: int) -> float:
    """Return the memory that each of some sources may keep [byte]."""
    return SHARE * free_memory() / max(count, 1)
