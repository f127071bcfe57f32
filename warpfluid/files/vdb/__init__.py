"""OpenVDB files (``.vdb``): the format in which volumes travel to Blender, Houdini and Maya.

A grid is a tree. The root holds cubes of 4096 voxels a side, each of them 32^3 cubes of 128, each of those
16^3 leaves of 8 voxels; only leaves that hold something are stored. In the file a grid is its name and type,
metadata, the transform from voxels to the world, the *topology* (which cubes there are, from the root down)
and the *buffers* (the values of every leaf, in the same order). Of a leaf only the *active* voxels are
stored, packed with zlib.

No package for the usual Python versions writes such files, so this one is our own: ``layout`` is what writing
and reading share, ``leaves`` and ``writer`` write, ``stream``, ``blosc``, ``tree`` and ``reader`` read,
``facts`` tells what there is.
"""

from warpfluid.files.vdb.facts import vdb_facts
from warpfluid.files.vdb.reader import read_vdb
from warpfluid.files.vdb.writer import lost_mass, write_vdb

__all__ = ["lost_mass", "read_vdb", "vdb_facts", "write_vdb"]
