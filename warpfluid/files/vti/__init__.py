"""Volumes as ``.vti``, VTK's XML image data, for ParaView and PyVista: one file a frame.

Values stand at points, which are the centres of the voxels, so that ParaView interpolates between them, and contours,
slices and streamlines need no conversion. There is little to the format, so it is written and read here: VTK's reader
takes a damaged file's word for every size, and ends the whole program.
"""

from warpfluid.files.vti.reader import read_vti, vti_facts
from warpfluid.files.vti.writer import write_vti

__all__ = ["read_vti", "vti_facts", "write_vti"]
