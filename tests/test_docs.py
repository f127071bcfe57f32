"""The documents say what is true: links, commands, options, defaults, names and the README's Python."""

import ast
import re
import shlex
from dataclasses import asdict, fields
from importlib import import_module
from pathlib import Path
from typing import get_args, get_type_hints

import numpy as np
import pytest

from warpfluid.cli import app
from warpfluid.cli.examples import EXAMPLES
from warpfluid.options import (
    SIMULATE_PAPER,
    THINGS,
    CameraOptions,
    CompareOptions,
    ExportOptions,
    InputOptions,
    LightOptions,
    OutputOptions,
    PreviewOptions,
    ReconstructOptions,
    RenderOptions,
    SimulateOptions,
)
from warpfluid.options.scene import parse_thing
from warpfluid.presets import preset_names

ROOT = Path(__file__).parents[1]
PAGES = {str(path.relative_to(ROOT)): path for path in [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")]}
SECTIONS = {
    InputOptions: "### Footage",
    ReconstructOptions: "### Method",
    SimulateOptions: "### Simulation",
    OutputOptions: "### Output",
    CompareOptions: "### Comparison",
    ExportOptions: "### Files",
    PreviewOptions: "### What is shown",
    RenderOptions: "### Picture",
    CameraOptions: "### Camera",
    LightOptions: "### Light",
    THINGS["emitter"]: "### Emitters",
    THINGS["obstacle"]: "### Obstacles",
    THINGS["force"]: "### Forces",
    THINGS["body"]: "### Bodies",
}
OPTIONS = tuple(SECTIONS)
COMMANDS = [name for name in app if not name.startswith("-")]
FENCE = re.compile(r"^ *```(\w*)\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)


def blocks(page: str, language: str) -> list[str]:
    """Return the code blocks of a page in one language."""
    return [text for kind, text in FENCE.findall(PAGES[page].read_text("utf-8")) if kind == language]


def prose(page: str) -> str:
    """Return a page without its code blocks."""
    return FENCE.sub("", PAGES[page].read_text("utf-8"))


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as forges make them."""
    headings = re.findall(r"^#+ (.+)$", page.read_text("utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def flags(command: str) -> set[str]:
    """Return the options of a command, short ones too."""
    names = {name for argument in app[command].assemble_argument_collection() for name in argument.names}
    return {name for name in names if name.startswith("-")}


SCENE = (ROOT / "warpfluid" / "exporting" / "blender_scene.py").read_text("utf-8")
OTHERS = {"--python", "--port", "--nworkers", "--nthreads", "--upgrade", "--force-reinstall"}  # of Blender, Dask, pip
OTHERS |= set(re.findall(r'add_argument\("(--[\w-]+)"', SCENE))  # of our script in Blender
FIGURES = (ROOT / "examples" / "paper" / "common.py").read_text("utf-8")
OTHERS |= set(re.findall(r'add_argument\("(--[\w-]+)"', FIGURES))  # of the paper's figures
FUZZER = (ROOT / "examples" / "fuzz.py").read_text("utf-8")
OTHERS |= set(re.findall(r'add_argument\("(--[\w-]+)"', FUZZER))  # of what tries damaged files
ALL_FLAGS = set().union(*map(flags, COMMANDS))


def command_lines() -> list[tuple[str, str]]:
    """Return every command line of ours that a page shows, with the page."""
    found = []
    for page in PAGES:
        for line in "\n".join(blocks(page, "sh")).replace("\\\n", " ").splitlines():
            parts = (part.strip().removeprefix(".venv/bin/") for part in line.split("&&"))
            found += [(page, part) for part in parts if part.startswith("warpfluid ")]
    return found


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page):
    """Every relative link and every anchor exists."""
    for target in re.findall(r"\]\(([^)\s]+)\)", prose(page)):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        there = (PAGES[page].parent / path).resolve() if path else PAGES[page]
        assert there.exists(), target
        if anchor:
            assert anchor in anchors(there), target


def test_every_page_is_in_the_index():
    """Whoever starts at the index finds all pages."""
    seen, found = set(), {ROOT / "docs" / "index.md"}
    while found:
        page = found.pop()
        seen.add(page)
        links = re.findall(r"\]\(([^)\s#:]+\.md)[)#]", page.read_text("utf-8"))
        found |= {there for link in links if (there := (page.parent / link).resolve()).is_file()} - seen
    assert {path for path in PAGES.values() if path.is_relative_to(ROOT / "docs")} <= seen


def test_messages_in_troubleshooting_are_ours():
    """Each message and hint that the page explains is written somewhere in the package, word for word."""
    page = PAGES["docs/troubleshooting.md"].read_text("utf-8")
    tables = re.findall(r"^\| (?:message|hint) \|.*\n\| ---.*\n((?:\|.*\n)+)", page, re.MULTILINE)
    rows = [row.split(" | ")[0] for table in tables for row in table.splitlines()]
    told = [message for row in rows for message in re.findall("`(.+?)`", row)]
    assert len(told) > 60
    texts = "\n".join(texts_of(path) for path in (ROOT / "warpfluid").rglob("*.py"))
    foreign = ("Unknown option", "command not found")  # of the command line's parser, and of the shell
    parts = {part.strip() for message in told if message not in foreign for part in message.split("...")}
    assert [part for part in parts if part not in texts] == []


def texts_of(path: Path) -> str:
    """Return the texts in a source file, with what is filled into them left out."""
    texts = []
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.JoinedStr):
            texts.append("\0".join(part.value if isinstance(part, ast.Constant) else "" for part in node.values))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            texts.append(node.value)
    return "\n".join(texts)


@pytest.mark.parametrize(("page", "line"), command_lines())
def test_command_lines_parse(page, line):
    """A command that is shown is one that is taken, with values that are allowed."""
    command, *rest = shlex.split(line)[1:]
    _, bound, *_ = app.parse_args([command, *rest], exit_on_error=False, print_error=False)
    method = SimulateOptions if command == "simulate" else ReconstructOptions
    for name, options in (("footage", InputOptions), ("method", method), ("output", OutputOptions)):
        if name in bound.arguments:
            options(**{key: value for key, value in asdict(bound.arguments[name]).items() if value is not None})
    for kind in THINGS:
        for text in bound.arguments.get(kind) or ():
            parse_thing(kind, text)


@pytest.mark.parametrize(("command", "line"), EXAMPLES.items())
def test_examples_of_the_help_parse(command, line):
    """Each command's help ends with an example of it that is taken."""
    assert line.split()[:2] == ["warpfluid", command]
    app.parse_args(shlex.split(line)[1:], exit_on_error=False, print_error=False)


def test_every_command_has_an_example():
    """The list that orders them is complete."""
    assert sorted(EXAMPLES) == sorted(COMMANDS)


def test_commands_are_shown():
    """Each command is shown in use on the page of commands."""
    lines = [line for page, line in command_lines() if page == "docs/cli.md"]
    assert {line.split()[1] for line in lines} == set(COMMANDS)


def test_page_of_commands_is_complete():
    """It has a section for each command, names each option, and nothing else."""
    text = PAGES["docs/cli.md"].read_text("utf-8")
    assert set(COMMANDS) <= anchors(PAGES["docs/cli.md"])
    assert set(re.findall(r"^\| \[`(\w+)`\]", text, re.MULTILINE)) == set(COMMANDS)
    assert set(re.findall(r"(?<![\w-])--?[a-z][\w-]*", text)) - {"--help"} == ALL_FLAGS


@pytest.mark.parametrize("options", OPTIONS, ids=lambda options: options.__name__)
def test_defaults_are_right(options):
    """Every option has one row with its default; a dash stands for none."""
    rows = dict(re.findall(r"^\| `(?:--)?([\w-]+)[^|]*\| ([^|]+) \|", documented(options), re.MULTILINE))
    made = {spelt(options, field.name): getattr(options(), field.name) for field in fields(options)}
    assert rows.keys() == made.keys()
    for name, default in made.items():
        told = rows[name].strip("`")
        if isinstance(default, bool):
            assert told == (("true" if default else "false") if is_thing(options) else "on" if default else "off"), name
        elif isinstance(default, int | float):
            assert float(told) == default, name
        else:
            assert told == (default or "–"), name


@pytest.mark.parametrize("options", OPTIONS, ids=lambda options: options.__name__)
def test_choices_are_told(options):
    """The row of an option with choices names each of them."""
    for field in fields(options):
        choices = re.findall(r"'([\w-]+)'", str(field.type)) if "Literal" in str(field.type) else []
        name = ("" if is_thing(options) else "--") + spelt(options, field.name)
        row = next(line for line in documented(options).splitlines() if re.match(rf"\| `{name}\b", line))
        assert all(f"`{choice}`" in row for choice in choices), field.name


def documented(options: type) -> str:
    """Return the section of the page of commands that has an options class."""
    return PAGES["docs/cli.md"].read_text("utf-8").split(f"\n{SECTIONS[options]}\n")[1].split("\n#")[0]


def is_thing(options: type) -> bool:
    """Return whether these are fields of what stands in the box, and no flags."""
    return options in THINGS.values()


def spelt(options: type, name: str) -> str:
    """Return an option as it is written: flags have hyphens."""
    return name if is_thing(options) else name.replace("_", "-")


@pytest.mark.parametrize(
    ("command", "options", "paper"),
    [
        ("reconstruct", ReconstructOptions, ReconstructOptions.paper()),
        ("simulate", SimulateOptions, SimulateOptions(**SIMULATE_PAPER)),
    ],
)
def test_choices_of_paper_are_told(command, options, paper):
    """The sentence on --paper names exactly what differs from the defaults."""
    told = re.search(r"`--paper` sets (.+?);", documented(options), re.DOTALL)[1]
    bound = app.parse_args(
        [command, *" ".join(re.findall(r"`(.+?)`", told)).split()], exit_on_error=False, print_error=False
    )[1]
    given = {key: value for key, value in asdict(bound.arguments["method"]).items() if value is not None}
    assert options(**given) == paper


def test_what_may_be_keyed_is_told():
    """The numbers that may not be keyed are named, and no others."""
    told = re.search(r"may be keyed but for (.+?)\.", documented(SimulateOptions), re.DOTALL)[1]
    kinds = {field.name: get_args(get_type_hints(SimulateOptions)[field.name]) for field in fields(SimulateOptions)}
    plain = {name for name, kind in get_type_hints(SimulateOptions).items() if kind is float or (float in kinds[name])}
    plain -= {name for name, kind in kinds.items() if str in kind}
    assert {name.replace("-", "_") for name in re.findall(r"`(.+?)`", told)} == plain


def test_presets_are_told():
    """The page of commands names each preset, and no other."""
    row = re.search(r"^\| `--preset NAME`.*$", PAGES["docs/cli.md"].read_text("utf-8"), re.MULTILINE)[0]
    assert re.findall(r"`(\w+)`", row) == sorted(preset_names(), key=row.find)


@pytest.mark.parametrize("page", PAGES)
def test_options_exist(page):
    """No page speaks of an option that there is not."""
    spoken = set(re.findall(r"(?<![\w-])--[a-z][\w-]*", PAGES[page].read_text("utf-8")))
    assert spoken - {"--help", "--version", "--quick"} - OTHERS <= ALL_FLAGS  # the last is the benchmarks'


def test_names_in_the_method_exist():
    """Each file and each function that the page of the method names is there."""
    package = ROOT / "warpfluid"
    text = PAGES["docs/method.md"].read_text("utf-8")
    named = set(re.findall(r"\b([a-z_]+(?:/[a-z_]+)*\.py)\b", text))
    assert len(named) > 8
    for name in named:
        assert any(
            path.as_posix().endswith(f"/{name}")
            for path in [*package.rglob("*.py"), *ROOT.glob("examples/*.py"), *ROOT.glob("tests/**/*.py")]
        )
    source = "\n".join(path.read_text("utf-8") for path in package.rglob("*.py"))
    for name in re.findall(r"`([A-Za-z_]+(?:\.[A-Za-z_]+)+|[a-z]+_[a-z_]+)`", prose("docs/method.md")):
        parts = name.removesuffix(".py").split(".")
        if not name.endswith(".py"):
            assert re.search(rf"(?:def|class) {parts[-1]}\b|^    {parts[-1]}:", source, re.MULTILINE), name


def test_reference_has_all_names():
    """The public names are in the reference, and what is in the reference is there."""
    import warpfluid as wf

    found = set()
    for page in (page for page in PAGES if page.startswith("docs/reference")):
        for module, names in re.findall(r"<!-- autodoc ([\w.]+): ([\w, ]+) -->", PAGES[page].read_text("utf-8")):
            assert all(hasattr(import_module(module), name) for name in names.split(", ")), (page, names)
            found |= {name for name in names.split(", ") if module == "warpfluid"}
    public = set(wf.__all__) - {"__version__"}
    options = {name for name in public if name.endswith("Options")}  # these are on a page of their own
    assert public - options == found


def test_readme_in_python(tmp_path, monkeypatch):
    """The README's Python runs as it is and leaves a volume and a film."""
    import warpfluid as wf
    from warpfluid.files.images import write_png

    monkeypatch.chdir(tmp_path)
    rows, columns = np.mgrid[0:40, 0:24]
    for name, lean in (("front", 3), ("side", -2)):
        flame = 200 * np.exp(-(((columns - 11.5 - lean * (1 - rows / 39)) / 4) ** 2)) * (rows > 5)
        write_png(f"{name}.png", flame.astype(np.uint8))
    (script,) = blocks("README.md", "python")
    exec(compile(script, "README.md", "exec"), {})
    density = wf.read_vdb("fire.0001.vdb").grids["density"]
    assert density.shape == (24, 40, 24)
    assert density.sum() > 0
    assert Path("fire.mp4").stat().st_size > 1000
