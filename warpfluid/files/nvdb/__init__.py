"""NanoVDB files (``.nvdb``): volumes for programs that render on a GPU.

The same tree as in a ``.vdb``, laid out so that it is used as it lies in memory: a grid's head, the head of the tree,
the root and its table, then all nodes of a level side by side, upper ones first. A place in a node's table holds where
its child lies, or a value. In the file, grids follow a head that names them, plain or packed with zlib.
"""

from warpfluid.files.nvdb.reader import nvdb_facts, read_nvdb
from warpfluid.files.nvdb.writer import write_nvdb

__all__ = ["nvdb_facts", "read_nvdb", "write_nvdb"]
