"""Small runs of all commands that make numbers, in a process of its own: for the test that who works does not matter.

python everything.py FOLDER ROWS COLUMNS ELEMENTS JOBS: launches are cut into so many rows, rows of whole columns and
elements; commands that spread take so many processes.
"""

import os
import sys
from pathlib import Path

from tiny import BARE, flame, footage, run

from warpfluid.kernels import launch

SIZE = (36, 50)
FEW = ["--angles", "16", "--cg-steps", "2", "--lsm-steps", "2", "--iterations", "1", "--mutations", "9000"]
METHODS = ("lsm", "stochastic", "convex", "multiplication", "flame-sheet")
FORMATS = ("vdb", "nvdb", "vti", "npz", "usda")


def reconstructions(front: str, side: str, jobs: str) -> dict[str, list[str]]:
    """Return the flags of reconstructions by name."""
    two, alone = ["--front", front, "--side", side], ["--frames", "1", *BARE]
    pieces = ["--piece", "2", "--overlap", "1", "--jobs", jobs, *BARE]
    return {
        "coherent": [*two, *BARE],
        "pieces": [*two, *pieces],
        "one-view": ["--front", front, *alone],
        "paper": [*two, "--paper", "--coherence", "flow", "--frames", "1-2", *BARE],
        "walk": [*two, "--e-step", "stochastic", *alone],
        **{name: [*two, "--method", name, "--convex-steps", "9", *alone] for name in METHODS},
        **{name: [*two, "--transfer", name, *alone] for name in ("texture-optimization", "portilla-simoncelli")},
    }


def simulations() -> dict[str, list[str]]:
    """Return the flags of simulations by name; the first follows a reconstruction."""
    box = ["--size", "28x44", "--frames", "1-2"]
    things = ["--obstacle", "sphere center=0,3,0", "--body", "box center=0,6,0", "--force", "vortex strength=20"]
    return {
        "followed": ["coherent", "--swirl", "1", "--turbulence-strength", "0.5"],
        "burning": [*box, "--preset", "explosion", "--detail", "2"],
        "around": [*box, "--preset", "smoke", *things, "--viscosity", "1"],
        "liquid": [*box, "--preset", "splash"],
    }


def pictures(jobs: str) -> dict[str, list[str]]:
    """Return the flags of pictures by name."""
    small = ["--resolution", "60x44"]
    lit = ["--look", "smoke", "--ground", "--motion-blur", "0.5", "--blur-samples", "2", *small]
    return {
        "lit.####.exr": ["around", *lit, "--jobs", jobs],
        "fire.####.png": ["burning", "--look", "explosion", "--glow", "2", *small],
        "film.mp4": ["coherent", "--resolution", "100x74"],
        "film.webp": ["coherent", "--resolution", "50x40"],
    }


def main(jobs: str) -> None:
    """Run everything in this folder."""
    views = [footage(Path(name), range(1, 4), lambda *at: flame(*at, *SIZE), k) for k, name in enumerate("ab")]
    on = ["--device", "cpu", "--quiet"]
    for name, flags in reconstructions(*views, jobs).items():
        assert run("reconstruct", *FEW, *flags, *on, "-o", name) == 0, name
    for name, flags in simulations().items():
        assert run("simulate", *flags, *BARE, *on, "-o", name) == 0, name
    for method in ("nltv-ncc", "ilk", "tvl1"):
        assert run("flow", "--front", views[0], "--flow", method, *on, "-o", f"flow-{method}") == 0, method
    for name, flags in pictures(jobs).items():
        assert run("render", *flags, *on, "-o", name) == 0, name
    for kind in FORMATS:
        assert run("export", "burning", "--format", kind, "--quiet", "-o", f"as-{kind}") == 0, kind


if __name__ == "__main__":
    folder, rows, columns, elements, processes = sys.argv[1:]
    launch._ROWS_A_JOB, launch._ROWS_OF_WHOLE_COLUMNS_A_JOB, launch._ELEMENTS_A_JOB = map(
        int, (rows, columns, elements)
    )
    os.chdir(folder)
    main(processes)
