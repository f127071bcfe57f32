"""Who imports whom, read from the source; and what a quick start may load."""

import ast
import subprocess
import sys
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import warpfluid

# From the bottom to the top. A module imports from its own layer and from those below it.
LAYERS = [
    {"files", "options", "kernels", "device", "errors", "memory"},
    {"presets", "views", "footage", "metrics", "projector", "balance", "settings", "run", "volumes", "motion"},
    {"reconstruction", "rendering", "simulation"},
    {
        "report",
        "preview",
        "commands",
        "comparison",
        "outcome",
        "progress",
        "doctor",
        "explaining",
        "exporting",
        "cluster",
    },
    {"cli"},
]

# Within these layers nobody knows the others.
STRANGERS = [LAYERS[0], LAYERS[2]]

HEAVY = {"warp", "pyvista", "vtkmodules", "scipy", "skimage", "av", "OpenEXR", "PIL", "matplotlib"}
LAUNCHING = {"launch", "launch_tiled", "kernel", "func", "func_native", "map"}

ROOT = Path(warpfluid.__file__).parent


def module_of(path):
    """Dotted name of a source file."""
    parts = path.relative_to(ROOT.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def part_of(module):
    """``files`` for ``warpfluid.files.vdb.writer``."""
    return module.split(".")[1]


TREES = {module_of(path): ast.parse(path.read_text()) for path in sorted(ROOT.rglob("*.py"))}
INSIDE = [module for module in TREES if module not in ("warpfluid", "warpfluid.__main__")]


def imports(module):
    """The modules of ours that a module imports anywhere in it; the version is there before any of them."""
    found = set()
    for node in ast.walk(TREES[module]):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module} imports relatively: write the whole name"
            names = {f"{node.module}.{alias.name}" for alias in node.names} - {"warpfluid.__version__"}
            found |= {name if name in TREES else node.module for name in names}
    return {name for name in found if name.split(".")[0] == "warpfluid"}


def rank(part):
    """Height of a part's layer."""
    return next(height for height, layer in enumerate(LAYERS) if part in layer)


def test_every_module_has_its_layer():
    """A new module is put into the table above, and one that is gone leaves it."""
    assert {part_of(module) for module in INSIDE} == set().union(*LAYERS)


@pytest.mark.parametrize("module", INSIDE)
def test_imports_point_down(module):
    """To lower layers or the own one, and not between strangers."""
    part = part_of(module)
    for name in imports(module):
        assert name != "warpfluid", f"{module} imports the package, which imports it"
        other = part_of(name)
        assert rank(other) <= rank(part), f"{module} imports {name}, which lies above it"
        for group in STRANGERS:
            assert other == part or not {part, other} <= group, f"{module} imports {name}, which it must not know"


def test_there_are_no_cycles():
    """No module reaches itself through a chain of imports."""
    TopologicalSorter({module: imports(module) for module in TREES}).prepare()


def test_the_entry_points_know_little():
    """``python -m warpfluid`` is the command; ``import warpfluid`` imports nothing of its own."""
    assert imports("warpfluid.__main__") == {"warpfluid.cli"}
    assert not imports("warpfluid")


@pytest.mark.parametrize("module", [module for module in INSIDE if part_of(module) != "kernels"])
def test_only_kernels_launch(module):
    """Nobody else launches or defines a kernel."""
    for node in ast.walk(TREES[module]):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in ("wp", "warp"):
            assert node.attr not in LAUNCHING, f"{module}, line {node.lineno}: put it into a file of kernels"


def loaded_by(program):
    """Top-level packages in memory after a program has run in an interpreter of its own."""
    program += "\nimport sys\nprint(*{name.split('.')[0] for name in sys.modules}, file=sys.stderr)"
    command = [sys.executable, "-c", program]
    return set(subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stderr.split())


def test_import_loads_nothing_heavy():
    """Not even NumPy: names are imported when they are first used."""
    assert not loaded_by("import warpfluid") & (HEAVY | {"numpy"})


@pytest.mark.parametrize("arguments", [["--help"], ["reconstruct", "--help"], ["--version"]])
def test_help_loads_nothing_heavy(arguments):
    """So that it comes at once."""
    program = f"from warpfluid.cli import main\nassert main({arguments}) == 0"
    assert not loaded_by(program) & HEAVY


@pytest.mark.parametrize("name", warpfluid.__all__)
def test_public_names_are_there(name):
    """Every name that the package promises can be imported."""
    assert name in dir(warpfluid)
    assert getattr(warpfluid, name) is not None


def test_other_names_are_not():
    """As in any module."""
    with pytest.raises(AttributeError, match="nonsense"):
        _ = warpfluid.nonsense
