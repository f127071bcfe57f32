"""``warpfluid doctor``: the installation."""

from warpfluid.cli.app import app
from warpfluid.cli.configured import configure
from warpfluid.cli.flags import COMMON, ClusterFlag, Common


@app.command
def doctor(*, cluster: ClusterFlag = None, common: Common = COMMON) -> int:
    """Check the installation: versions, devices, memory, kernel cache, video, windows, a cluster."""
    from warpfluid.commands import doctor as command

    chosen = configure(common, cluster=cluster)
    chosen.problems.raise_if_any()
    return command.doctor(chosen.cluster, chosen.common)
