"""Ready-made choices for the four kinds of fluid of the paper, one small file each."""

import tomllib
from importlib.resources import files


def preset_names() -> list[str]:
    """Return the names of all presets."""
    folder = files("warpfluid") / "presets"
    return sorted(file.name.removesuffix(".toml") for file in folder.iterdir() if file.name.endswith(".toml"))


def preset_settings(name: str) -> dict:
    """Return a preset as the tables of a configuration file.

    Raises:
        ValueError: If there is no such preset.
    """
    names = preset_names()
    if name not in names:
        raise ValueError(f"preset is {name!r}, expected one of {', '.join(names)}")
    return tomllib.loads((files("warpfluid") / "presets" / f"{name}.toml").read_text("utf-8"))
