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
from warpfluid.options import PAPER, InputOptions, OutputOptions, ReconstructOptions

SECTIONS = {"input": InputOptions, "reconstruct": ReconstructOptions, "output": OutputOptions}
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
        tables = {name: dataclasses.asdict(getattr(self, name)) for name in SECTIONS}
        tables = {name: {k: v for k, v in table.items() if v is not None} for name, table in tables.items()}
        background = tables["input"].get("background", "median")
        if background != "median":
            tables["input"]["background"] = _whole_path(background)
        return {"views": [_whole_view(view) for view in self.views], **tables}


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
    for (name, options), flags in zip(SECTIONS.items(), (footage, method, output), strict=True):
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
        elif name != "made-with":
            expected = ", ".join(f"[{section}]" for section in SECTIONS)
            problems.append(f"{path}: unknown {name!r}{_like(name, SECTIONS)}; expected are views, {expected}")
    problems.raise_if_any()
    return document


def check_same(folder: Path, old: dict, new: dict) -> None:
    """Check that a run is continued with what it was begun with.

    Args:
        folder: Of the run.
        old: Its ``run.toml``.
        new: What would be written now, with the hashes of the footage under ``made-with``.

    Raises:
        ValueError: If anything differs that the volumes depend on.
    """
    changed = []
    if old.get("views") != new["views"]:
        changed.append(f"views (were {' '.join(old.get('views', []))}, now {' '.join(new['views'])})")
    for name in SECTIONS:
        before, after = old.get(name, {}), new[name]
        changed += [
            f"{key.replace('_', '-')} (was {before.get(key)}, now {after.get(key)})"
            for key in sorted({*before, *after} - {*FREE})
            if before.get(key) != after.get(key)
        ]
    before, after = (document.get("made-with", {}).get("inputs", {}) for document in (old, new))
    changed += [f"the footage at {angle} degrees" for angle in after if before.get(angle, after[angle]) != after[angle]]
    if changed:
        raise ValueError(
            f"{folder} was made with something else: {', '.join(changed)}; "
            "use the same again, or --overwrite, or another folder with -o"
        )


def join_frames(old: dict, new: dict) -> None:
    """Let the frames of ``new`` be those of both documents: a run may be made in parts."""
    parts = [document["input"].get("frames") for document in (old, new)]
    if None in parts:
        new["input"].pop("frames", None)
    else:
        new["input"]["frames"] = format_frames(frame for part in parts for frame in parse_frames(part))


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


def _whole_path(path: str) -> str:
    return os.path.abspath(os.path.expanduser(path))
