"""The command line: flags made from the options, results to stdout, everything else to stderr.

Exit codes: 0 done, 1 some frames failed (they are named), 2 the command or its input is wrong, 130 interrupted.
"""

import os
import sys
import traceback
from dataclasses import dataclass, field, fields, make_dataclass
from pathlib import Path
from typing import Annotated, Literal, get_args, get_type_hints

import cyclopts
from cyclopts import App, Group, Parameter

from warpfluid import __version__
from warpfluid.errors import describe
from warpfluid.options import InputOptions, OutputOptions, ReconstructOptions, SimulateOptions

app = App(
    name="warpfluid",
    help="Volumes of fire, smoke, explosions and splashes from one or a few videos.",
    version=__version__,
    suppress_keyboard_interrupt=False,
)


def _whole_number(_, tokens) -> int:
    """Return a flag's number; without this cyclopts cuts 3.5 to 3 without a word."""
    try:
        return int(tokens[0].value)
    except ValueError as error:
        raise ValueError(f"{tokens[0].value!r} is not a whole number") from error


def _flags(options: type, title: str, order: int) -> type:
    """Make the flags of an options class: all unset, with the defaults in the help."""
    hints, made = get_type_hints(options, include_extras=True), []
    for option in fields(options):
        kind, text = get_args(hints[option.name])[:2]
        default = False if option.default is None else lambda _, value=option.default: value
        convert = _whole_number if int in (kind, *get_args(kind)) else None
        flag = Annotated[kind | None, Parameter(help=text, show_default=default, converter=convert)]
        made.append((option.name, flag, field(default=None)))
    flags = make_dataclass(f"{options.__name__}Flags", made, frozen=True, kw_only=True)
    flags.__module__ = __name__  # without a module of ours cyclopts takes it for one opaque value
    return Annotated[flags, Parameter(name="*", group=Group(title, sort_key=order))]


InputFlags = _flags(InputOptions, "Footage", 1)
MethodFlags = _flags(ReconstructOptions, "Method", 2)
SimulateFlags = _flags(SimulateOptions, "Simulation", 2)
OutputFlags = _flags(OutputOptions, "Output", 3)
NO_INPUT, NO_METHOD, NO_SIMULATION, NO_OUTPUT = (
    get_args(flags)[0]() for flags in (InputFlags, MethodFlags, SimulateFlags, OutputFlags)
)

FrontFlag = Annotated[str | None, Parameter(help="Footage of the front: the same as --view 0=FOOTAGE")]
SideFlag = Annotated[
    str | None,
    Parameter(help="Footage of a camera left of the front one, at a right angle: the same as --view 90=FOOTAGE"),
]
PaperFlag = Annotated[bool, Parameter(negative=(), help="Make the paper's choices; other flags count on top")]
ConfigFlag = Annotated[Path | None, Parameter(help="Take options from a run.toml; flags count on top")]
ViewFlag = Annotated[
    list[str] | None,
    Parameter(
        name=["--view"],
        allow_leading_hyphen=True,
        negative=(),
        help="A view, ANGLE=FOOTAGE: a video, a folder, or a pattern such as front.####.png; once for every view",
    ),
]


@Parameter(name="*", group=Group("Common", sort_key=9))
@dataclass(frozen=True, kw_only=True)
class Common:
    """What most commands take."""

    device: Annotated[str, Parameter(help="cpu, cuda:N, or auto: the first GPU if there is one")] = "auto"
    json: Annotated[bool, Parameter(negative=(), help="Print the result as one JSON document")] = False
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative=(), help="Print nothing but the result")] = False
    verbose: Annotated[bool, Parameter(name=["--verbose", "-v"], negative=(), help="Show errors whole")] = False


COMMON = Common()


@app.command
def reconstruct(
    *,
    view: ViewFlag = None,
    front: FrontFlag = None,
    side: SideFlag = None,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"], help="Folder of the run")] = None,
    paper: PaperFlag = False,
    config: ConfigFlag = None,
    resume: Annotated[bool, Parameter(negative=(), help="Continue a run: frames that are there are kept")] = False,
    overwrite: Annotated[bool, Parameter(negative=(), help="Delete an earlier run in the folder")] = False,
    footage: InputFlags = NO_INPUT,
    method: MethodFlags = NO_METHOD,
    output: OutputFlags = NO_OUTPUT,
    common: Common = COMMON,
) -> int:
    """Make a volume sequence of the footage of one or more views."""
    from warpfluid import commands

    if out is None:
        raise ValueError("no folder is given for the run: add -o FOLDER")
    if resume and config is None and (out / "run.toml").is_file():
        config = out / "run.toml"  # what is not said again stays as it was
    views = [*(view or []), *_named_views(front, side)]
    settings = commands.make_settings(views, footage, method, output, paper=paper, config=config)
    return commands.reconstruct(settings, out, resume=resume, overwrite=overwrite, common=common)


@app.command
def inspect(
    *,
    view: ViewFlag = None,
    front: FrontFlag = None,
    side: SideFlag = None,
    picture: Annotated[
        Path | None, Parameter(negative_none="no-", help="Picture of the views around the box to write, .png")
    ] = Path("views.png"),
    paper: PaperFlag = False,
    config: ConfigFlag = None,
    footage: InputFlags = NO_INPUT,
    method: MethodFlags = NO_METHOD,
    common: Common = COMMON,
) -> int:
    """Show what is understood of footage: sizes, frames, levels, agreement of the views, cost."""
    from warpfluid import commands

    views = [*(view or []), *_named_views(front, side)]
    settings = commands.make_settings(views, footage, method, None, paper=paper, config=config)
    return commands.inspect(settings, picture, common)


@app.command
def flow(
    *,
    view: ViewFlag = None,
    front: FrontFlag = None,
    side: SideFlag = None,
    out: Annotated[Path, Parameter(name=["--out", "-o"], help="Folder to write to")],
    flow: Annotated[
        Literal["nltv-ncc", "ilk", "tvl1"],
        Parameter(help="Optical flow: non-local TV with cross-correlation, iterative Lucas-Kanade, or TV-L1"),
    ] = "nltv-ncc",
    config: ConfigFlag = None,
    footage: InputFlags = NO_INPUT,
    common: Common = COMMON,
) -> int:
    """Measure the motion in footage and write it: numbers as EXR, colours as PNG."""
    from warpfluid import commands

    views = [*(view or []), *_named_views(front, side)]
    settings = commands.make_settings(views, footage, None, None, config=config)
    return commands.flow(settings, out, flow, common)


def _things(kind: str, text: str) -> type:
    """Make the flag that puts things of a kind into the box."""
    return Annotated[list[str] | None, Parameter(name=[f"--{kind}"], negative=(), help=text)]


@app.command
def simulate(
    source: Annotated[str | None, Parameter(help="A run, or volumes: a folder, pattern or file, .vdb or .npz")] = None,
    *,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"], help="Folder of the new run")] = None,
    preset: Annotated[str | None, Parameter(help="fire, smoke, explosion or splash; see presets")] = None,
    size: Annotated[str | None, Parameter(help="Voxels of an empty box, WIDTHxHEIGHT; 96x144 by default")] = None,
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
    from warpfluid import simulating

    if out is None:
        raise ValueError("no folder is given for the run: add -o FOLDER")
    if resume and config is None and (out / "run.toml").is_file():
        config = out / "run.toml"  # what is not said again stays as it was
    things = {"emitter": emitter, "obstacle": obstacle, "force": force, "body": body}
    asked = simulating.Asked(source=source, size=size, preset=preset, things=things, method=method, output=output)
    return simulating.simulate(
        asked, out, paper=paper, config=config, resume=resume, overwrite=overwrite, common=common
    )


@app.command
def presets(*, common: Common = COMMON) -> int:
    """List the presets of simulate, and what each sets."""
    from warpfluid import simulating

    return simulating.show_presets(common)


@app.command
def export(
    run: Annotated[Path, Parameter(help="Folder of a run")],
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"], help="Folder to write to")],
    format: Annotated[
        Literal["npz"], Parameter(help="npz: density (x, y, z), float32, y up, one file a frame")
    ] = "npz",
    frames: Annotated[str | None, Parameter(help="Frames to write, such as 1001-1024; all by default")] = None,
    common: Common = COMMON,
) -> int:
    """Write the volumes of a run in another format."""
    from warpfluid import commands

    return commands.export(run, out, format, frames, common)


@app.command
def demo(
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"], help="Folder of the run")] = Path("warpfluid-demo"),
    common: Common = COMMON,
) -> int:
    """Reconstruct a packaged fire from its front and its side: volumes, turntable and report."""
    from warpfluid import commands

    return commands.demo(out, common)


@app.command
def doctor(*, common: Common = COMMON) -> int:
    """Check the installation: versions, devices, kernel cache, video, windows."""
    from warpfluid import commands

    return commands.doctor(common)


def main(arguments: list[str] | None = None) -> int:
    """Run a command and return its exit code.

    Args:
        arguments: What follows ``warpfluid``; of the command line when omitted.
    """
    arguments = sys.argv[1:] if arguments is None else arguments
    try:
        return app(arguments, exit_on_error=False, print_error=False, result_action="return_value") or 0
    except KeyboardInterrupt as stop:
        print(str(stop) or "stopped", file=sys.stderr)
        return 130
    except BrokenPipeError:  # the reader of stdout had enough, as head does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except cyclopts.CycloptsError as error:
        return _fail(_usage(error), 2)
    except Exception as error:
        if {"-v", "--verbose"} & set(arguments):
            traceback.print_exc()
        if isinstance(error, ValueError | OSError | MemoryError):
            return _fail(describe(error), 2)
        return _fail(f"{describe(error)}: a fault of warpfluid; please report it with what -v prints", 1)


def _fail(message: str, code: int) -> int:
    print("\n".join(f"error: {line}" for line in message.splitlines()), file=sys.stderr)
    return code


def _usage(error: cyclopts.CycloptsError) -> str:
    """Return what is wrong with a command line, and the way out."""
    if isinstance(error, cyclopts.UnusedCliTokensError):
        rest = " ".join(error.unused_tokens or ())
        if list(error.command_chain or ())[:1] == ["simulate"]:
            return f"there is no place for {rest!r}: write what belongs together in quotes, --force 'drag strength=2'"
        return f"there is no place for {rest!r}: footage follows --view ANGLE=, --front or --side"
    return str(error)


def _named_views(front: str | None, side: str | None) -> list[str]:
    return [f"{angle}={path}" for angle, path in ((0, front), (90, side)) if path is not None]
