"""Whether a Dask cluster answers, and with which workers."""

import logging
from collections import Counter
from importlib.metadata import PackageNotFoundError, version

from warpfluid import __version__

PATIENCE = 10.0  # s that a scheduler has to answer


def examine_cluster(address: str | None) -> dict:
    """Return the version of dask.distributed here, and what is known of a cluster.

    Args:
        address: Of its scheduler, such as ``tcp://host:8786``; None for no cluster.
    """
    found = {"distributed": _installed(), "address": address, "workers": None, "threads": None, "versions": {}}
    if not address or not found["distributed"]:
        return found
    from distributed import Client

    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # what matters is said as a line
    try:
        with Client(address, timeout=PATIENCE, set_as_default=False) as client:
            workers = client.scheduler_info(n_workers=-1)["workers"]
            answers = client.run(own_version, on_error="return") if workers else {}
    except (OSError, ValueError):
        return found
    texts = (answer if isinstance(answer, str) else f"none ({answer})" for answer in answers.values())
    threads = sum(worker["nthreads"] for worker in workers.values())
    return found | {"workers": len(workers), "threads": threads, "versions": dict(Counter(texts))}


def own_version() -> str:
    """Return the version of this package, wherever it is asked."""
    return __version__


def _installed() -> str | None:
    try:
        return version("distributed")
    except PackageNotFoundError:
        return None
