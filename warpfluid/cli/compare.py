"""``warpfluid compare``: results against each other and the truth."""

from functools import partial
from pathlib import Path
from typing import Annotated, get_args

from cyclopts import Parameter

from warpfluid.cli.app import app
from warpfluid.cli.configured import check_volumes, configure
from warpfluid.cli.flags import COMMON, Common, ConfigFlag, make_flags
from warpfluid.options import CompareOptions

CompareFlags = make_flags(CompareOptions, "Comparison", 1)
NO_CHOICES = get_args(CompareFlags)[0]()


@app.command
def compare(
    *results: Annotated[
        str | Path, Parameter(help="Runs, or volumes: a folder, pattern or file, .vdb, .nvdb, .vti or .npz")
    ],
    truth: Annotated[
        str | Path | None, Parameter(help="The true volumes, or a run that counts as true", metavar="VOLUMES")
    ] = None,
    out: Annotated[
        list[Path] | None,
        Parameter(name=["--out", "-o"], negative=(), help="Film (.mp4, .webp, .gif) or sheet (.png); once for each"),
    ] = None,
    config: ConfigFlag = None,
    choices: CompareFlags = NO_CHOICES,
    common: Common = COMMON,
) -> int:
    """Measure results against the truth or their footage, with floors; show them side by side."""
    from warpfluid.commands import compare as command

    chosen = configure(common, config)
    options = chosen.options(CompareOptions, "compare", choices)
    chosen.refuse(partial(check_volumes, *results, truth))
    return command.compare(results, truth, options, out or (), chosen.common)
