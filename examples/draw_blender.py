"""
Volumes in Blender
==================

The packaged fire and the presets for smoke and explosions, exported with a scene for Blender and rendered by Cycles.
Writes ``blender.png``. Needs Blender; the environment variable ``WARPFLUID_BLENDER`` may name it.
"""

# %%
# Each is a run like those of an artist.

import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from gallery import panel, save
from PIL import Image

from warpfluid.cli import main

BLENDER = os.environ.get("WARPFLUID_BLENDER", "blender")
SIZE, SAMPLES = "330x440", "64"
MADE = {
    "fire, look fire": (["demo"], "8", "fire"),
    "smoke preset, look smoke": (
        ["simulate", "--preset", "smoke", "--size", "64x96", "--frames", "1-60"],
        "60",
        "smoke",
    ),
    "explosion preset, look explosion": (
        ["simulate", "--preset", "explosion", "--size", "64x96", "--frames", "1-16"],
        "14",
        "explosion",
    ),
}

# %%
# The script stands beside the volumes; what follows the two hyphens is for it.


def rendered(folder: Path, command: list[str], frame: str, look: str):
    """Return what Cycles makes of a run, uint8 (rows, columns, 3)."""
    run, out, picture = folder / "run", folder / "out", folder / "picture.png"
    flags = ["--no-turntable"] if command[0] == "simulate" else []
    assert main([*command, *flags, "-o", str(run), "-q"]) == 0
    assert (
        main(["export", str(run), "-o", str(out), "--format", "blender", "--look", look, "--frames", frame, "-q"]) == 0
    )
    script = ["--python", str(out / "open_in_blender.py"), "--", "--render", str(picture), "--size", SIZE]
    blender = [BLENDER, "-b", "--factory-startup", "--python-exit-code", "1"]
    subprocess.run([*blender, *script, "--samples", SAMPLES], check=True, stdout=subprocess.DEVNULL)
    return np.asarray(Image.open(picture).convert("RGB"))


# %%
# Side by side.

pictures = {}
for caption, (command, frame, look) in MADE.items():
    with tempfile.TemporaryDirectory() as folder:
        pictures[caption] = rendered(Path(folder), command, frame, look)
save("blender.png", panel(pictures))
