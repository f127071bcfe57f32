"""``warpfluid preview``: volumes in a window, or in a page for the browser."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, get_args

from cyclopts import Parameter

from warpfluid.cli.app import app
from warpfluid.cli.flags import COMMON, Common, SourceArgument, make_flags
from warpfluid.options import PreviewOptions

PreviewFlags = make_flags(PreviewOptions, "Preview", 1)
NO_CHOICES = get_args(PreviewFlags)[0]()


@app.command
def preview(
    source: SourceArgument,
    *,
    html: Annotated[Path | None, Parameter(help="Write a page that plays them in any browser, .html")] = None,
    screenshot: Annotated[Path | None, Parameter(help="Draw the window into a picture instead, .png")] = None,
    choices: PreviewFlags = NO_CHOICES,
    common: Common = COMMON,
) -> int:
    """Look at volumes: turn them, play them, and see what stands about them."""
    from warpfluid.preview import show

    given = {name: value for name, value in asdict(choices).items() if value is not None}
    return show.preview(source, PreviewOptions(**given), html=html, screenshot=screenshot, common=common)
