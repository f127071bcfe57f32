"""``warpfluid export``: volumes in another format."""

from functools import partial
from pathlib import Path
from typing import Annotated, get_args

from cyclopts import Parameter

from warpfluid.cli.app import app
from warpfluid.cli.configured import check_volumes, configure
from warpfluid.cli.flags import COMMON, Common, ConfigFlag, SourceArgument, make_flags
from warpfluid.options import ExportOptions

ExportFlags = make_flags(ExportOptions, "Files", 1)
NO_CHOICES = get_args(ExportFlags)[0]()


@app.command
def export(
    source: SourceArgument,
    *,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"], help="Folder to write to; needed")] = None,
    resume: Annotated[bool, Parameter(negative=(), help="Continue an export: frames that are there are kept")] = False,
    overwrite: Annotated[bool, Parameter(negative=(), help="Replace an earlier export in the folder")] = False,
    config: ConfigFlag = None,
    choices: ExportFlags = NO_CHOICES,
    common: Common = COMMON,
) -> int:
    """Write volumes for Blender, Houdini, Maya, Omniverse, ParaView or NumPy."""
    from warpfluid.commands import export as command

    chosen = configure(common, config)
    if out is None:
        chosen.problems.append("no folder is given for the files: add -o FOLDER")
    options = chosen.options(ExportOptions, "export", choices)
    chosen.refuse(partial(check_volumes, source))
    return command.export(source, out, options, resume=resume, overwrite=overwrite, common=chosen.common)
