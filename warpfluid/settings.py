"""Everything that decides what a run makes: flags, a configuration file and the defaults put together.

``run.toml`` in the folder of a run has the same form as a configuration file, so that any run can be repeated.
"""

import dataclasses
import difflib
import os
import tomllib
from dataclasses import dataclass
from pathlib import Path

from warpfluid.errors import Problems, describe
from warpfluid.files.sequences import format_frames, parse_frames
from warpfluid.footage.sources import parse_view
from warpfluid.options import (
    PAPER,
    SIMULATE_PAPER,
    THINGS,
    InputOptions,
    OutputOptions,
    ReconstructOptions,
    Scene,
    SimulateOptions,
)
from warpfluid.options.scene import make_thing, parse_thing
from warpfluid.presets import preset_settings

SECTIONS = {
    "input": InputOptions,
    "reconstruct": ReconstructOptions,
    "simulate": SimulateOptions,
    "output": OutputOptions,
}
FREE = ("frames", "turntable", "report", "look")  # what may change when a run is continued


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Everything that decides what a run makes.

    Attributes:
        views: ``ANGLE=PATH`` of every view.
        input: How pictures become images.
        reconstruct: The method.
        output: What is written.
    """

    views: tuple[str, ...]
    input: InputOptions
    reconstruct: ReconstructOptions
    output: OutputOptions

    def to_dict(self) -> dict:
        """Return plain tables with whole paths; options that are None are left out, as TOML has no such value."""
        tables = {name: _table(getattr(self, name)) for name in ("input", "reconstruct", "output")}
        background = tables["input"].get("background", "median")
        if background != "median":
            tables["input"]["background"] = _whole_path(background)
        return {"views": [_whole_view(view) for view in self.views], **tables}


@dataclass(frozen=True, kw_only=True)
class SimulateSettings:
    """Everything that decides what a simulation makes.

    Attributes:
        source: A run or volumes; None for an empty box.
        size: Width and height of an empty box [voxel].
        simulate: The method.
        scene: What stands in the box.
        output: What is written.
    """

    source: str | None
    size: tuple[int, int] | None
    simulate: SimulateOptions
    scene: Scene
    output: OutputOptions

    def to_dict(self) -> dict:
        """Return plain tables with whole paths; options that are None are left out, as TOML has no such value."""
        made = {name: _table(getattr(self, name)) for name in ("simulate", "output")}
        made |= {kind: [_table(thing) for thing in getattr(self.scene, kind)] for kind in THINGS}
        place = {"source": _whole_path(self.source)} if self.source else {"size": list(self.size or ())}
        return {**place, **{name: table for name, table in made.items() if table}}


def make_simulate_settings(
    source: str | None,
    method,
    output,
    things: dict[str, list[str]],
    *,
    size: tuple[int, int] | None = None,
    preset: str | None = None,
    paper: bool = False,
    config: Path | None = None,
    source_output: dict | None = None,
) -> SimulateSettings:
    """Put settings together: flags, a preset, the paper's choices, the file, the source, the defaults, in this order.

    What is typed counts more than what is stored, and a preset, which says what is simulated, more than ``paper``,
    which says how.

    Args:
        source: A run or volumes; that of the configuration when None.
        method: Flags with the names of ``SimulateOptions``; None where not given. May be None altogether.
        output: The same for ``OutputOptions``.
        things: Lines of the command line by kind (``THINGS``); they are added to those of the configuration, unless
            they are there already: a command may be said again with ``--resume``.
        size: Width and height of an empty box.
        preset: Name of a preset; its emitters and its preroll count where there is no source.
        paper: Make the paper's choices.
        config: A configuration file or ``run.toml``.
        source_output: How the files of the source are stored.

    Raises:
        ValueError: If any value or name is wrong; one line each.
    """
    document, problems = (read_settings(config) if config else {}), Problems()
    source = source or document.get("source")
    ready = preset_settings(preset) if preset else {}
    above = {"simulate": (SIMULATE_PAPER if paper else {}) | ready.get("simulate", {})}
    if source:
        above["simulate"].pop("preroll", None)  # its volumes are there already
    above["output"] = ready.get("output", {})
    made = {}
    for (name, options), flags in zip(
        (("simulate", SimulateOptions), ("output", OutputOptions)), (method, output), strict=True
    ):
        given = {k: v for k, v in dataclasses.asdict(flags).items() if v is not None} if flags else {}
        below = source_output or {} if name == "output" else {}
        values = below | document.get(name, {}) | above[name] | given
        made[name] = problems.attempt(lambda options=options, values=values: options(**values))
    scene = _make_scene(document, {} if source else ready, things, problems)
    problems.raise_if_any()
    if source is None:
        size = size or tuple(document.get("size", ())) or (96, 144)
    return SimulateSettings(source=source, size=size, scene=scene, **made)


def _make_scene(document: dict, ready: dict, lines: dict[str, list[str] | None], problems: Problems) -> Scene:
    """Return what is in the box: of the configuration, and of a preset and the command line what is not there yet."""
    scene = {}
    for kind in THINGS:
        make = lambda table, kind=kind: _with_whole_path(make_thing(kind, table, where=f"[[{kind}]] "))  # noqa: E731
        parse = lambda line, kind=kind: _with_whole_path(parse_thing(kind, line))  # noqa: E731
        there = [problems.attempt(make, table) for table in document.get(kind, ())]
        added = [problems.attempt(make, table) for table in ready.get(kind, ())]
        added += [problems.attempt(parse, line) for line in lines.get(kind) or ()]
        scene[kind] = (*there, *(thing for thing in added if thing not in there))
    return Scene(**scene)


def make_settings(
    views: list[str], footage, method, output, *, paper: bool = False, config: Path | None = None
) -> Settings:
    """Put settings together: flags first, then the paper's choices, the configuration file, the defaults.

    Args:
        views: ``ANGLE=PATH`` of every view; those of the configuration when empty.
        footage: Flags with the names of ``InputOptions``; None where not given. May be None altogether.
        method: The same for ``ReconstructOptions``.
        output: The same for ``OutputOptions``.
        paper: Make the paper's choices.
        config: A configuration file or ``run.toml``.

    Raises:
        ValueError: If any value or name is wrong; one line each.
    """
    document = read_settings(config) if config else {}
    problems, made = Problems(), {}
    for name, flags in (("input", footage), ("reconstruct", method), ("output", output)):
        options = SECTIONS[name]
        given = {k: v for k, v in dataclasses.asdict(flags).items() if v is not None} if flags else {}
        values = document.get(name, {}) | (PAPER if paper and name == "reconstruct" else {}) | given
        made[name] = problems.attempt(lambda options=options, values=values: options(**values))
    problems.raise_if_any()
    return Settings(views=tuple(views or document.get("views", ())), **made)


def read_settings(path: str | Path) -> dict:
    """Read ``run.toml`` or a configuration file and check its names and values.

    Raises:
        ValueError: If it is no TOML, or anything in it is unknown or wrong; one line each.
    """
    try:
        document = tomllib.loads(Path(path).read_text("utf-8"))
    except OSError as error:
        raise ValueError(f"{describe(error)}; a configuration or run.toml is needed") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{path} is not TOML: {error}") from error
    problems = Problems()
    for name, table in document.items():
        if name == "views":
            problems.attempt(_check_views, table, where=f"{path}: ")
        elif name in SECTIONS:
            problems.attempt(_check_section, name, table, where=f"{path}: ")
        elif name in THINGS:
            problems.attempt(_check_things, name, table, where=f"{path}: ")
        elif name == "source":
            if not isinstance(table, str):
                problems.append(f"{path}: source is {table!r}, expected the path of a run or of volumes")
        elif name == "size":
            if not (isinstance(table, list) and len(table) == 2 and all(isinstance(n, int) and n > 7 for n in table)):
                problems.append(f"{path}: size is {table!r}, expected a width and a height such as [96, 144]")
        elif name != "made-with":
            expected = ", ".join(f"[{section}]" for section in SECTIONS)
            known = {**SECTIONS, **THINGS}
            problems.append(f"{path}: unknown {name!r}{_like(name, known)}; expected are views, source, {expected}")
    problems.raise_if_any()
    return document


def check_same(folder: Path, old: dict, new: dict) -> None:
    """Check that a run is continued with what it was begun with.

    Args:
        folder: Of the run.
        old: Its ``run.toml``.
        new: What would be written now, with the hashes of volumes or backgrounds under ``made-with``.

    Raises:
        ValueError: If anything differs that the volumes depend on.
    """
    changed = []
    if old.get("views") != new.get("views"):
        views = [" ".join(document.get("views", [])) or "none" for document in (old, new)]
        changed.append(f"views (were {views[0]}, now {views[1]})")
    if old.get("source") != new.get("source") or old.get("size") != new.get("size"):
        changed.append(f"the source (was {old.get('source') or old.get('size')})")
    changed += [f"[[{kind}]]" for kind in THINGS if old.get(kind, []) != new.get(kind, [])]
    for name in SECTIONS:
        before, after = old.get(name, {}), new.get(name, {})
        changed += [
            f"{key.replace('_', '-')} (was {before.get(key)}, now {after.get(key)})"
            for key in sorted({*before, *after} - {*FREE})
            if before.get(key) != after.get(key)
        ]
    before, after = (document.get("made-with", {}).get("inputs", {}) for document in (old, new))
    kind = "the volume of frame {}" if "source" in new else "the background of the view at {} degrees"
    changed += [kind.format(name) for name in after if before.get(name, after[name]) != after[name]]
    if changed:
        raise ValueError(
            f"{folder} was made with something else: {', '.join(changed)}; "
            "use the same again, or --overwrite, or another folder with -o"
        )


def join_frames(old: dict, new: dict) -> None:
    """Let the frames of ``new`` be those of both documents: a run may be made in parts."""
    section = "input" if "input" in new else "simulate"
    parts = [document[section].get("frames") for document in (old, new)]
    if None in parts:
        new[section].pop("frames", None)
    else:
        new[section]["frames"] = format_frames(frame for part in parts for frame in parse_frames(part))


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


def _table(options) -> dict:
    """Return options as a table, without those that are None."""
    return {name: value for name, value in dataclasses.asdict(options).items() if value is not None}


def _check_views(views: object) -> None:
    if not (isinstance(views, list) and all(isinstance(view, str) for view in views)):
        raise ValueError(f'views are {views!r}, expected a list such as ["0=front.mp4", "90=side.mp4"]')


def _like(name: str, known) -> str:
    """Return the known name that is nearest, as a question, or nothing."""
    near = difflib.get_close_matches(name.replace("-", "_"), known, 1)
    return f"; did you mean {near[0]}?" if near else ""


def _whole_view(view: str) -> str:
    angle_deg, path = parse_view(view)
    return f"{angle_deg:.15g}={_whole_path(path)}"


def _with_whole_path(thing):
    return dataclasses.replace(thing, mesh=_whole_path(thing.mesh)) if getattr(thing, "mesh", None) else thing


def _whole_path(path: str) -> str:
    return os.path.abspath(os.path.expanduser(path))
