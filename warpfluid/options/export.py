"""What an export is made of."""

from dataclasses import dataclass
from typing import Annotated, Literal

from warpfluid.options.checks import check_options


@dataclass(frozen=True, kw_only=True)
class ExportOptions:
    """How volumes leave for other programs."""

    format: Annotated[
        Literal["vdb", "usda", "blender", "nvdb", "vti", "npz"],
        "vdb: OpenVDB; usda: the same with a USD stage; blender: the same, z up, with a script that sets up a scene; "
        "nvdb: NanoVDB; vti: ParaView; npz: NumPy",
    ] = "vdb"
    frames: Annotated[str | None, "Frames to write, such as 1001-1024; all by default"] = None
    grids: Annotated[str | None, "Grids to write, such as density,velocity; all by default"] = None
    grid: Annotated[
        str | None, "Grid of other programs' files to take as density; density, or the only one, by default"
    ] = None
    source_up: Annotated[Literal["y", "z"], "Axis that points up in other programs' files that do not tell"] = "y"
    up: Annotated[Literal["y", "z"], "Axis that points up in the files: y for Houdini and Maya, z for Blender"] = "y"
    velocity_name: Annotated[str, "Name of the velocity in the files: velocity for Blender, vel for Houdini"] = (
        "velocity"
    )
    half: Annotated[bool, "Store half precision: half the size, three digits"] = False
    voxel_size: Annotated[float | None, "Edge of a voxel in scene units; as in the source by default"] = None
    density_scale: Annotated[float, "What the density is multiplied by"] = 1.0
    drop_below: Annotated[float, "Density not stored, as a part of the frame's maximum"] = 0.0
    crop: Annotated[bool, "Cut the box to what is lit in any frame of the source"] = False
    repair: Annotated[bool, "Write 0 where values are NaN or infinite, or a density is negative"] = False
    plain: Annotated[bool, "Leave .nvdb files unpacked, for readers without zip"] = False
    look: Annotated[
        Literal["auto", "fire", "smoke", "explosion"],
        "Material in Blender; by default explosion where there is a flame, else the run's look",
    ] = "auto"
    fps: Annotated[float | None, "Frames a second of the scene; the run's by default, else 24"] = None

    def __post_init__(self):
        problems = []
        if self.half and self.format in ("nvdb", "vti"):
            problems.append(f"half is for vdb, usda, blender and npz; {self.format} has no such kind: leave it out")
        if self.up == "z" and self.format == "npz":
            problems.append("up is z, but .npz volumes are y up always: leave it out")
        if self.plain and self.format != "nvdb":
            problems.append("plain is for nvdb: leave it out")
        check_options(self, problems)

    @property
    def file_up(self) -> str:
        """The up axis of the files."""
        return "z" if self.format == "blender" else self.up

    @property
    def ending(self) -> str:
        """Of the files of volumes."""
        return {"usda": "vdb", "blender": "vdb"}.get(self.format, self.format)
