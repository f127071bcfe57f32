"""``warpfluid inspect``: what is understood of footage, and what a file is."""

from functools import partial
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from warpfluid.cli.app import app
from warpfluid.cli.configured import check_views, configure
from warpfluid.cli.flags import (
    COMMON,
    NO_INPUT,
    NO_METHOD,
    Common,
    ConfigFlag,
    FrontFlag,
    InputFlags,
    MethodFlags,
    PaperFlag,
    SideFlag,
    ViewFlag,
    named_views,
)


@app.command
def inspect(
    *files: Annotated[
        str | Path, Parameter(help="Files to explain: volumes, pictures, videos, stages, folders of runs")
    ],
    view: ViewFlag = None,
    front: FrontFlag = None,
    side: SideFlag = None,
    picture: Annotated[
        Path | None, Parameter(negative_none="no-", help="Picture of the views around the box to write, .png")
    ] = Path("views.png"),
    paper: PaperFlag = False,
    config: ConfigFlag = None,
    footage: InputFlags = NO_INPUT,
    method: MethodFlags = NO_METHOD,
    common: Common = COMMON,
) -> int:
    """Show what is understood of footage: sizes, frames, levels, agreement, cost; or what files are."""
    from warpfluid.commands import footage as command
    from warpfluid.settings import make_settings

    views = [*(view or []), *named_views(front, side)]
    if files:
        if views or config:
            given = " ".join(files)
            raise ValueError(f"{given} is explained as it is; footage follows --view ANGLE=, --front or --side")
        from warpfluid.commands.explain import explain_files

        return explain_files(files, common)
    chosen = configure(common, config)
    make = partial(make_settings, paper=paper, document=chosen.document)
    settings = chosen.problems.attempt(make, views, footage, method, None)
    chosen.refuse(partial(check_views, views))
    return command.inspect(settings, picture, chosen.common)
