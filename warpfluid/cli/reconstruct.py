"""``warpfluid reconstruct``: footage becomes volumes."""

from functools import partial
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from warpfluid.cli.app import app
from warpfluid.cli.configured import check_run, check_views, configure
from warpfluid.cli.flags import (
    COMMON,
    NO_INPUT,
    NO_METHOD,
    NO_OUTPUT,
    ClusterFlag,
    Common,
    ConfigFlag,
    FrontFlag,
    InputFlags,
    JobsFlag,
    MethodFlags,
    OutputFlags,
    PaperFlag,
    SideFlag,
    ViewFlag,
    named_views,
    settings_of_run,
)


@app.command
def reconstruct(
    *,
    view: ViewFlag = None,
    front: FrontFlag = None,
    side: SideFlag = None,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"], help="Folder of the run; needed")] = None,
    paper: PaperFlag = False,
    config: ConfigFlag = None,
    resume: Annotated[bool, Parameter(negative=(), help="Continue a run: frames that are there are kept")] = False,
    overwrite: Annotated[bool, Parameter(negative=(), help="Delete an earlier run in the folder")] = False,
    debug_dir: Annotated[
        Path | None, Parameter(help="Folder for pictures of every iteration of appearance transfer (Fig. 3)")
    ] = None,
    jobs: JobsFlag = None,
    cluster: ClusterFlag = None,
    footage: InputFlags = NO_INPUT,
    method: MethodFlags = NO_METHOD,
    output: OutputFlags = NO_OUTPUT,
    common: Common = COMMON,
) -> int:
    """Make a volume sequence of the footage of one or more views."""
    from warpfluid.commands import reconstruct as command
    from warpfluid.settings import make_settings

    config = settings_of_run(out, config, resume=resume)
    views = [*(view or []), *named_views(front, side)]
    chosen = configure(common, config, jobs=jobs, cluster=cluster)
    make = partial(make_settings, paper=paper, document=chosen.document)
    settings = chosen.problems.attempt(make, views, footage, method, output)
    place = {"resume": resume, "overwrite": overwrite}
    chosen.problems.attempt(partial(check_run, out, **place))
    chosen.refuse(partial(check_views, views))
    return command.reconstruct(settings, out, debug_dir=debug_dir, **place, **chosen.who)
