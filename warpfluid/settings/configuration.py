"""Configuration files: what they may hold, and one error for all that is wrong with one."""

import dataclasses
import difflib
import tomllib
from pathlib import Path

from warpfluid.errors import Problems, describe
from warpfluid.options import (
    THINGS,
    USUAL_SIZE,
    CameraOptions,
    CompareOptions,
    ExportOptions,
    InputOptions,
    LightOptions,
    MachineOptions,
    OutputOptions,
    PreviewOptions,
    ReconstructOptions,
    RenderOptions,
    SimulateOptions,
)
from warpfluid.options.scene import make_thing
from warpfluid.settings.earlier import fill_earlier

SMALLEST = 8  # voxels of a side of an empty box
OF_RUNS = {
    "input": InputOptions,
    "reconstruct": ReconstructOptions,
    "simulate": SimulateOptions,
    "output": OutputOptions,
}
SECTIONS = OF_RUNS | {
    "render": RenderOptions,
    "camera": CameraOptions,
    "light": LightOptions,
    "preview": PreviewOptions,
    "compare": CompareOptions,
    "export": ExportOptions,
    "machine": MachineOptions,
}


def read_settings(path: str | Path) -> dict:
    """Read ``run.toml`` or a configuration file and check its names and values.

    Options that the version of a run lacked have the values that they had in effect, see ``fill_earlier``.

    Raises:
        ValueError: If it is no TOML, or anything in it is unknown or wrong; one line each.
    """
    try:
        document = tomllib.loads(Path(path).read_text("utf-8"))
    except OSError as error:
        raise ValueError(f"{describe(error)}; a configuration or run.toml is needed") from error
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path} is not TOML: {error}") from error
    problems = Problems()
    for name, value in document.items():
        problems.attempt(_check_entry, name, value, where=f"{path}: ")
    problems.raise_if_any()
    return fill_earlier(document)


def _check_entry(name: str, value: object) -> None:
    """Refuse an entry of a document that is unknown or wrong."""
    if name in SECTIONS:
        _check_section(name, value)
    elif name in THINGS:
        _check_things(name, value)
    elif name == "views":
        _check_views(value)
    elif name == "source" and not isinstance(value, str):
        raise ValueError(f"source is {value!r}, expected the path of a run or of volumes")
    elif name == "size" and not _is_size(value):
        raise ValueError(f"size is {value!r}, expected a width and a height such as {list(USUAL_SIZE)}")
    elif name not in ("source", "size", "made-with"):
        expected = ", ".join(f"[{section}]" for section in SECTIONS)
        near = _like(name, {**SECTIONS, **THINGS})
        raise ValueError(f"unknown {name!r}{near}; expected are views, source, size, {expected}")


def _is_size(value: object) -> bool:
    """Return whether a value is a width and a height [voxel]."""
    return isinstance(value, list) and len(value) == 2 and all(type(n) is int and n >= SMALLEST for n in value)


def _check_section(name: str, table: object) -> None:
    """Refuse a table that is none, or has unknown options or wrong values."""
    if not isinstance(table, dict):
        raise ValueError(f"{name} is {table!r}, expected a table [{name}]")
    known = [field.name for field in dataclasses.fields(SECTIONS[name])]
    unknown = [key for key in table if key not in known]
    problems = Problems(f"[{name}] has no option {key!r}{_like(key, known)}" for key in unknown)
    values = {key: value for key, value in table.items() if key in known}
    problems.attempt(lambda: SECTIONS[name](**values), where=f"[{name}] ")
    problems.raise_if_any()


def _check_things(kind: str, tables: object) -> None:
    """Refuse what is no array of tables, or has unknown options or wrong values."""
    if not (isinstance(tables, list) and all(isinstance(table, dict) for table in tables)):
        raise ValueError(f"{kind} is {tables!r}, expected tables [[{kind}]]")
    problems = Problems()
    for table in tables:
        problems.attempt(lambda table=table: make_thing(kind, table, where=f"[[{kind}]] "))
    problems.raise_if_any()


def _check_views(views: object) -> None:
    if not (isinstance(views, list) and all(isinstance(view, str) for view in views)):
        raise ValueError(f'views are {views!r}, expected a list such as ["0=front.mp4", "90=side.mp4"]')


def _like(name: str, known) -> str:
    """Return the known name that is nearest, as a question, or nothing."""
    near = difflib.get_close_matches(name.replace("-", "_"), known, 1)
    return f"; did you mean {near[0]}?" if near else ""
