"""``warpfluid demo``: the packaged fire."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from warpfluid.cli.app import app
from warpfluid.cli.configured import configure
from warpfluid.cli.flags import (
    COMMON,
    Common,
)


@app.command
def demo(
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"], help="Folder of the run")] = Path("warpfluid-demo"),
    common: Common = COMMON,
) -> int:
    """Reconstruct a packaged fire from its front and its side: volumes, turntable and report."""
    from warpfluid.commands import demo as command

    chosen = configure(common)
    chosen.refuse()
    return command.demo(out, chosen.common)
