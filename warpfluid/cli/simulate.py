"""``warpfluid simulate`` and ``warpfluid presets``: volumes flow."""

from functools import partial
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from warpfluid.cli.app import app
from warpfluid.cli.configured import check_run, check_volumes, configure
from warpfluid.cli.flags import (
    COMMON,
    NO_OUTPUT,
    NO_SIMULATION,
    SOURCE,
    Common,
    ConfigFlag,
    OutputFlags,
    PaperFlag,
    SimulateFlags,
    settings_of_run,
)
from warpfluid.presets import preset_names


def _things(kind: str, text: str) -> type:
    """Make the flag that puts things of a kind into the box."""
    return Annotated[list[str] | None, Parameter(name=[f"--{kind}"], negative=(), help=text, metavar="THING")]


@app.command
def simulate(
    source: Annotated[str | Path | None, SOURCE] = None,
    *,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"], help="Folder of the new run; needed")] = None,
    preset: Annotated[
        str | None,
        Parameter(help="Choices made for a kind of fluid; see presets", choices=preset_names(), metavar="NAME"),
    ] = None,
    size: Annotated[
        str | None, Parameter(help="Voxels of an empty box, 96x144 by default", metavar="WIDTHxHEIGHT")
    ] = None,
    emitter: _things("emitter", "An emitter: 'sphere center=0,1,0 radius=0.5 density=4'; once for each") = None,
    obstacle: _things("obstacle", "An obstacle: 'box center=0,4,0 size=2,0.5,2'; once for each") = None,
    force: _things("force", "A force: 'vortex center=0,3,0 strength=20'; once for each") = None,
    body: _things("body", "A rigid body: 'box center=0,2,0 size=1,0.6,2'; once for each") = None,
    paper: PaperFlag = False,
    config: ConfigFlag = None,
    resume: Annotated[bool, Parameter(negative=(), help="Continue a run, or make it longer")] = False,
    overwrite: Annotated[bool, Parameter(negative=(), help="Delete an earlier run in the folder")] = False,
    method: SimulateFlags = NO_SIMULATION,
    output: OutputFlags = NO_OUTPUT,
    common: Common = COMMON,
) -> int:
    """Make volumes flow: smooth motion that keeps the look of the footage, and that can be edited."""
    from warpfluid.commands import simulate as command

    config = settings_of_run(out, config, resume=resume)
    things = {"emitter": emitter, "obstacle": obstacle, "force": force, "body": body}
    asked = command.Asked(source=source, size=size, preset=preset, things=things, method=method, output=output)
    chosen = configure(common, config)
    place = {"resume": resume, "overwrite": overwrite}
    chosen.problems.attempt(partial(check_run, out, **place))
    chosen.refuse(partial(check_volumes, source))
    what = {"paper": paper, "document": chosen.document, "common": chosen.common}
    return command.simulate(asked, out, **place, **what)


@app.command
def presets(*, common: Common = COMMON) -> int:
    """List the presets of simulate, and what each sets."""
    from warpfluid.commands import simulate as command

    return command.show_presets(common)
