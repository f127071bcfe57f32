"""Who computes: flags over the environment over a configuration file over the defaults."""

import os
from collections.abc import Collection, Mapping

from warpfluid.errors import Problems
from warpfluid.options import MachineOptions
from warpfluid.options.machine import VARIABLES

WHO = {"jobs", "cluster"}  # of these one counts, wherever it is named


def read_environment(settled: Collection[str] = ()) -> dict[str, str]:
    """Return what the environment says of ``MachineOptions``; what is empty says nothing.

    Args:
        settled: Options that a flag has decided, which are not looked at.

    Raises:
        ValueError: If a value is wrong; one line each.
    """
    found = {name: os.environ[variable] for name, variable in VARIABLES.items() if os.environ.get(variable)}
    found = {name: value for name, value in found.items() if name not in settled}
    problems = Problems()
    for name, value in found.items():
        problems.attempt(lambda n=name, v=value: MachineOptions(**{n: v}), where=f"{VARIABLES[name]}: ")
    problems.raise_if_any()
    return found


def make_machine(given: Mapping[str, str | None], document: dict | None = None) -> MachineOptions:
    """Put together who computes: flags first, then the environment, the configuration file, the defaults.

    Processes of this machine and a cluster exclude each other, so that naming one sets aside what lower places say of
    the other.

    Args:
        given: Flags by the names of ``MachineOptions``; None where not given.
        document: What a configuration file says.

    Raises:
        ValueError: If any value is wrong; one line each.
    """
    flags = {name: value for name, value in given.items() if value is not None}
    settled, values = {*flags} | (WHO if WHO & {*flags} else set()), {}
    for place in ((document or {}).get("machine", {}), read_environment(settled), flags):
        if WHO & set(place):
            values = {name: value for name, value in values.items() if name not in WHO}
        values |= place
    return MachineOptions(**values)
