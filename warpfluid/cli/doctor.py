"""``warpfluid doctor``: the installation."""

from warpfluid.cli.app import app
from warpfluid.cli.flags import (
    COMMON,
    Common,
)


@app.command
def doctor(*, common: Common = COMMON) -> int:
    """Check the installation: versions, devices, kernel cache, video, windows."""
    from warpfluid import commands

    return commands.doctor(common)
