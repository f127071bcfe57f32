"""Ready-made choices for the four kinds of fluid of the paper, one small file each."""

import tomllib
from importlib.resources import files

from warpfluid.options.keys import is_ramp


def preset_names() -> list[str]:
    """Return the names of all presets."""
    folder = files("warpfluid") / "presets"
    return sorted(file.name.removesuffix(".toml") for file in folder.iterdir() if file.name.endswith(".toml"))


def preset_settings(name: str, *, first: int = 1) -> dict:
    """Return a preset as the tables of a configuration file.

    Args:
        name: Of the preset.
        first: First frame of what is simulated: keys of presets count from frame 1 on, and move with it.

    Raises:
        ValueError: If there is no such preset.
    """
    names = preset_names()
    if name not in names:
        raise ValueError(f"preset is {name!r}, expected one of {', '.join(names)}")
    tables = tomllib.loads((files("warpfluid") / "presets" / f"{name}.toml").read_text("utf-8"))
    return {kind: _moved(table, first - 1) for kind, table in tables.items()}


def _moved(value, frames: int):
    """Return a table, list or value with its keys moved by some frames."""
    if isinstance(value, dict):
        return {name: _moved(part, frames) for name, part in value.items()}
    if isinstance(value, list):
        return [_moved(part, frames) for part in value]
    if not frames or not isinstance(value, str) or ":" not in value or is_ramp(value):
        return value
    keys = (key.partition(":") for key in value.split(";"))
    return ";".join(f"{int(frame) + frames}:{number}" for frame, _, number in keys)
