"""Flags that several commands share, made from the options."""

from dataclasses import dataclass, field, fields, make_dataclass
from pathlib import Path
from typing import Annotated, get_args, get_type_hints

from cyclopts import Group, Parameter

from warpfluid.cli.app import spell
from warpfluid.options import InputOptions, MachineOptions, OutputOptions, ReconstructOptions, SimulateOptions
from warpfluid.options.checks import VECTORS
from warpfluid.options.machine import VARIABLES

PATHS = {"background", "camera", "probe", "look"}  # options that are paths, or may be


def _whole_number(_, tokens) -> int:
    """Return a flag's number; without this cyclopts cuts 3.5 to 3 without a word."""
    try:
        return int(tokens[0].value)
    except ValueError as error:
        raise ValueError(f"{tokens[0].value!r} is not a whole number") from error


def _number(_, tokens) -> float:
    try:
        return float(tokens[0].value)
    except ValueError as error:
        raise ValueError(f"{tokens[0].value!r} is not a number") from error


def make_flags(options: type, title: str, order: int) -> type:
    """Make the flags of an options class: all unset, with the defaults in the help."""
    hints, made = get_type_hints(options, include_extras=True), []
    for option in fields(options):
        kind, text = get_args(hints[option.name])[:2]
        default = False if option.default is None else lambda _, value=option.default: spell(value)
        kinds = {kind, *get_args(kind)} - {type(None)}
        convert = _whole_number if int in kinds else _number if float in kinds and str not in kinds else None
        vector = option.name in VECTORS or option.name.startswith("view_")  # -1,0,0 and -60=2 look like flags
        flag = Annotated[
            _flag_type(option.name, kind),
            Parameter(
                help=text,
                show_default=default,
                converter=convert,
                allow_leading_hyphen=vector,
                metavar=metavar(kind),
            ),
        ]
        made.append((option.name, flag, field(default=None)))
    namespace = {"OPTIONS": options}
    flags = make_dataclass(f"{options.__name__}Flags", made, frozen=True, kw_only=True, namespace=namespace)
    flags.__module__ = __name__  # without a module of ours cyclopts takes it for one opaque value
    return Annotated[flags, Parameter(name="*", group=Group(title, sort_key=order))]


def _flag_type(name: str, kind: type) -> type:
    """Return the type of a flag, which tells the shell what to complete: nothing after a switch, files after a path."""
    return (
        bool
        if kind is bool
        else kind | Path | None
        if name in PATHS and str in (kind, *get_args(kind))
        else kind | None
    )


def metavar(kind: type) -> str | None:
    """Return what stands for a flag's value in the help; None where that is plain."""
    kinds = {kind, *get_args(kind)}
    return next((name for each, name in ((float, "X"), (int, "N"), (str, "TEXT")) if each in kinds), None)


InputFlags = make_flags(InputOptions, "Footage", 1)
MethodFlags = make_flags(ReconstructOptions, "Method", 2)
SimulateFlags = make_flags(SimulateOptions, "Simulation", 2)
OutputFlags = make_flags(OutputOptions, "Output", 3)
NO_INPUT, NO_METHOD, NO_SIMULATION, NO_OUTPUT = (
    get_args(flags)[0]() for flags in (InputFlags, MethodFlags, SimulateFlags, OutputFlags)
)

SOURCE = Parameter(help="A run, or volumes: a folder, pattern or file, .vdb, .nvdb, .vti or .npz", metavar="SOURCE")
# These are text; that they may be paths as well makes shells complete files.
SourceArgument = Annotated[str | Path, SOURCE]
FrontFlag = Annotated[
    str | Path | None, Parameter(help="Footage of the front: the same as --view 0=FOOTAGE", metavar="FOOTAGE")
]
SideFlag = Annotated[
    str | Path | None,
    Parameter(
        help="Footage of a camera left of the front one, at a right angle: the same as --view 90=FOOTAGE",
        metavar="FOOTAGE",
    ),
]
PaperFlag = Annotated[bool, Parameter(negative=(), help="Make the paper's choices; other flags count on top")]
ConfigFlag = Annotated[
    Path | None, Parameter(help="Take options from this file, such as a run.toml; flags count on top", metavar="FILE")
]
ViewFlag = Annotated[
    list[str | Path] | None,
    Parameter(
        name=["--view"],
        allow_leading_hyphen=True,
        negative=(),
        metavar="ANGLE=FOOTAGE",
        help="A view: its angle, and a video, a folder, or a pattern such as front.####.png; once for every view",
    ),
]


def _machine_flag(name: str, metavar: str) -> type:
    """Make the flag of an option that the environment may give, too."""
    text = get_args(get_type_hints(MachineOptions, include_extras=True)[name])[1]
    default = getattr(MachineOptions, name)
    shown = False if default is None else lambda _: spell(default)
    return Annotated[
        str | None, Parameter(help=f"{text} [environment: {VARIABLES[name]}]", show_default=shown, metavar=metavar)
    ]


DeviceFlag = _machine_flag("device", "NAME")
JobsFlag = _machine_flag("jobs", "N")
ClusterFlag = _machine_flag("cluster", "ADDRESS")


@Parameter(name="*", group=Group("Common", sort_key=9))
@dataclass(frozen=True, kw_only=True)
class Common:
    """What most commands take."""

    device: DeviceFlag = None
    json: Annotated[bool, Parameter(negative=(), help="Print the result as one JSON object")] = False
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative=(), help="Print nothing but the result")] = False
    verbose: Annotated[
        bool, Parameter(name=["--verbose", "-v"], negative=(), help="Say versions and times, and show errors whole")
    ] = False


COMMON = Common()


def named_views(front: str | None, side: str | None) -> list[str]:
    """Return the views that are named by where they stand, as ``--view`` takes them."""
    return [f"{angle}={path}" for angle, path in ((0, front), (90, side)) if path is not None]


def settings_of_run(out: Path | None, config: Path | None, *, resume: bool) -> Path | None:
    """Return where the settings of a run come from: what is not said again when it is continued stays as it was."""
    if out and resume and config is None and (out / "run.toml").is_file():
        return out / "run.toml"
    return config
