"""Everything that decides what a command makes: flags, the environment, a configuration file and the defaults together.

``run.toml`` in the folder of a run has the same form as a configuration file, so that any run can be repeated.
"""

from warpfluid.settings.configuration import SECTIONS, read_settings
from warpfluid.settings.continuing import check_same, join_frames
from warpfluid.settings.machine import make_machine, read_environment
from warpfluid.settings.of_reconstruction import Settings, make_settings
from warpfluid.settings.of_simulation import SimulateSettings, make_simulate_settings
from warpfluid.settings.tables import make_options

__all__ = [
    "SECTIONS",
    "Settings",
    "SimulateSettings",
    "check_same",
    "join_frames",
    "make_machine",
    "make_options",
    "make_settings",
    "make_simulate_settings",
    "read_environment",
    "read_settings",
]
