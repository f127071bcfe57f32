"""Options as the tables of a configuration file, and back."""

import dataclasses
import os


def given(flags) -> dict:
    """Return the flags that were given; None for none of them may be given, too."""
    return {name: value for name, value in dataclasses.asdict(flags).items() if value is not None} if flags else {}


def make_options(options: type, table: dict, flags=None):
    """Make options of a table and of flags, which count more.

    Args:
        options: A class of options.
        table: Of a configuration file; may be empty.
        flags: With the names of the options; None where not given. May be None altogether.

    Raises:
        ValueError: If any value is wrong; one line each.
    """
    return options(**table | given(flags))


def to_table(options) -> dict:
    """Return options as a table, without those that are None, which TOML has no value for."""
    return {name: value for name, value in dataclasses.asdict(options).items() if value is not None}


def whole_path(path: str) -> str:
    """Return a path that means the same in every folder."""
    return os.path.abspath(os.path.expanduser(path))
