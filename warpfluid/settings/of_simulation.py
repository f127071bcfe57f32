"""The settings of a simulation."""

import dataclasses
from dataclasses import dataclass

from warpfluid.errors import Problems
from warpfluid.options import SIMULATE_PAPER, THINGS, USUAL_SIZE, OutputOptions, Scene, SimulateOptions
from warpfluid.options.scene import make_thing, parse_thing
from warpfluid.presets import preset_settings
from warpfluid.settings.tables import make_options, to_table, whole_path


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
        made = {name: to_table(getattr(self, name)) for name in ("simulate", "output")}
        made |= {kind: [to_table(thing) for thing in getattr(self.scene, kind)] for kind in THINGS}
        place = {"source": whole_path(self.source)} if self.source else {"size": list(self.size or ())}
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
    document: dict | None = None,
    source_output: dict | None = None,
    first: int = 1,
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
        document: What a configuration file or ``run.toml`` says, see ``read_settings``.
        source_output: How the files of the source are stored.
        first: First frame, from which the keys of a preset count.

    Raises:
        ValueError: If any value or name is wrong; one line each.
    """
    document, problems = document or {}, Problems()
    source = source or document.get("source")
    ready = problems.attempt(lambda: preset_settings(preset, first=first)) or {} if preset else {}
    above = (SIMULATE_PAPER if paper else {}) | ready.get("simulate", {})
    if source:
        above.pop("preroll", None)  # its volumes are there already
    below = source_output or {}
    made = {
        "simulate": problems.attempt(make_options, SimulateOptions, document.get("simulate", {}) | above, method),
        "output": problems.attempt(
            make_options, OutputOptions, below | document.get("output", {}) | ready.get("output", {}), output
        ),
    }
    scene = _make_scene(document, {} if source else ready, things, problems)
    problems.raise_if_any()
    if source is None:
        size = size or tuple(document.get("size", ())) or USUAL_SIZE
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


def _with_whole_path(thing):
    return dataclasses.replace(thing, mesh=whole_path(thing.mesh)) if getattr(thing, "mesh", None) else thing
