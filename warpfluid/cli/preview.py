"""``warpfluid preview``: volumes in a window, or in a page for the browser."""

from functools import partial
from pathlib import Path
from typing import Annotated, get_args

from cyclopts import Parameter

from warpfluid.cli.app import app
from warpfluid.cli.configured import check_volumes, configure
from warpfluid.cli.flags import COMMON, Common, ConfigFlag, SourceArgument, make_flags
from warpfluid.options import PreviewOptions

PreviewFlags = make_flags(PreviewOptions, "Preview", 1)
NO_CHOICES = get_args(PreviewFlags)[0]()


@app.command
def preview(
    source: SourceArgument,
    *,
    html: Annotated[Path | None, Parameter(help="Write a page that plays them in any browser, .html")] = None,
    screenshot: Annotated[Path | None, Parameter(help="Draw the window into a picture instead, .png")] = None,
    config: ConfigFlag = None,
    choices: PreviewFlags = NO_CHOICES,
    common: Common = COMMON,
) -> int:
    """Look at volumes: turn them, play them, and see what stands about them."""
    from warpfluid.preview import show

    chosen = configure(common, config)
    options = chosen.options(PreviewOptions, "preview", choices)
    chosen.refuse(partial(check_volumes, source))
    return show.preview(source, options, html=html, screenshot=screenshot, common=chosen.common)
