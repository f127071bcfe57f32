"""``warpfluid export``: volumes in another format."""

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from warpfluid.cli.app import app
from warpfluid.cli.flags import (
    COMMON,
    Common,
)


@app.command
def export(
    run: Annotated[Path, Parameter(help="Folder of a run")],
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"], help="Folder to write to")],
    format: Annotated[
        Literal["npz"], Parameter(help="npz: density (x, y, z), float32, y up, one file a frame")
    ] = "npz",
    frames: Annotated[str | None, Parameter(help="Frames to write, such as 1001-1024; all by default")] = None,
    common: Common = COMMON,
) -> int:
    """Write the volumes of a run in another format."""
    from warpfluid import commands

    return commands.export(run, out, format, frames, common)
