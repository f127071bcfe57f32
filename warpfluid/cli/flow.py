"""``warpfluid flow``: the motion in footage."""

from functools import partial
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from warpfluid.cli.app import app
from warpfluid.cli.configured import check_views, configure
from warpfluid.cli.flags import (
    COMMON,
    NO_INPUT,
    Common,
    ConfigFlag,
    FrontFlag,
    InputFlags,
    SideFlag,
    ViewFlag,
    named_views,
)


@app.command
def flow(
    *,
    view: ViewFlag = None,
    front: FrontFlag = None,
    side: SideFlag = None,
    out: Annotated[Path, Parameter(name=["--out", "-o"], help="Folder to write to")],
    flow: Annotated[
        Literal["nltv-ncc", "ilk", "tvl1"],
        Parameter(help="Optical flow: non-local TV with cross-correlation, iterative Lucas-Kanade, or TV-L1"),
    ] = "nltv-ncc",
    config: ConfigFlag = None,
    footage: InputFlags = NO_INPUT,
    common: Common = COMMON,
) -> int:
    """Measure the motion in footage and write it: numbers as EXR, colours as PNG."""
    from warpfluid.commands import footage as command
    from warpfluid.settings import make_settings

    views = [*(view or []), *named_views(front, side)]
    chosen = configure(common, config)
    make = partial(make_settings, document=chosen.document)
    settings = chosen.problems.attempt(make, views, footage, None, None)
    chosen.refuse(partial(check_views, views))
    return command.flow(settings, out, flow, chosen.common)
