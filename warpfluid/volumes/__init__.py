"""Sequences of volumes on disk: a run of ours, or files of another program."""

from warpfluid.volumes.boxes import boxed, squared
from warpfluid.volumes.find import ENDINGS, find_volumes
from warpfluid.volumes.lattice import Lattice, join, lattice_of, lit_part
from warpfluid.volumes.reading import file_facts, read_density, read_grids
from warpfluid.volumes.room import check_room
from warpfluid.volumes.sequence import EXPORT, VolumeSequence, open_volumes

__all__ = [
    "ENDINGS",
    "EXPORT",
    "Lattice",
    "VolumeSequence",
    "boxed",
    "check_room",
    "file_facts",
    "find_volumes",
    "join",
    "lattice_of",
    "lit_part",
    "open_volumes",
    "read_density",
    "read_grids",
    "squared",
]
