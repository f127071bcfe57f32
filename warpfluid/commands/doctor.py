"""Tell what is installed and what this machine can do."""

import json


def doctor(cluster: str | None, common) -> int:
    """Report on the installation, the machine and a cluster; return the exit code, 1 if nothing can be made here."""
    from warpfluid.doctor import complaints, examine, lines

    found = examine(common.device, cluster)
    found["problems"] = complaints(found)
    print(json.dumps(found, indent=2) if common.json else "\n".join(lines(found)))
    return 1 if found["problems"] else 0
