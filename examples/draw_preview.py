"""
The preview
===========

The pictures of ``docs/preview.md``: the page as Chromium shows it, and the window. Writes ``preview-page.webp``,
``preview-window.webp`` and ``preview-motion.webp``. Needs OpenGL, and Chromium; the environment variable
``WARPFLUID_CHROMIUM`` may name it.
"""

# %%
# Runs like those of an artist: the packaged fire, the preset for smoke, and a burst between things that stand and fall.

import os
import subprocess
import tempfile
from pathlib import Path

from gallery import folder
from PIL import Image

from warpfluid.cli import main

CHROMIUM = os.environ.get("WARPFLUID_CHROMIUM", "chromium")
HEADLESS = ("--headless", "--no-sandbox", "--hide-scrollbars", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
SMOKE = ["simulate", "--preset", "smoke", "--size", "64x96", "--frames", "1-60"]
BURST = ["simulate", "--preset", "explosion", "--size", "64x96", "--frames", "1-9"]
THINGS = [
    *("--body", "box center=1.5,1,0.5 size=1.4,0.9,1.4"),
    *("--obstacle", "cylinder center=-1.6,4,0 radius=0.5 size=1,2,1 rotation=0,0,30"),
]
WIDTH = 960  # pixels of a picture in the documents


def run(*words: object) -> None:
    """Run a command of warpfluid."""
    assert main([str(word) for word in words]) == 0


def keep(path: Path, name: str) -> None:
    """Keep a picture, as wide as the documents are."""
    with Image.open(path) as picture:
        size = (WIDTH, round(picture.height * WIDTH / picture.width))
        picture.convert("RGB").resize(size, Image.Resampling.LANCZOS).save(folder() / name, quality=88)
    print(f"wrote {folder() / name}")


# %%
# The page, lit from above.

with tempfile.TemporaryDirectory() as name:
    work = Path(name)
    run(*SMOKE, "--no-turntable", "-o", work / "smoke", "-q")
    run("preview", work / "smoke", "--html", work / "page.html", "-q")
    view = "frame=60&angle=-20&elevation=12&mode=lit&absorption=7&theme=dark"
    address = f"file://{work / 'page.html'}#{view}"
    size = ("--window-size=1280,800", "--virtual-time-budget=20000", f"--screenshot={work / 'page.png'}")
    command = [CHROMIUM, *HEADLESS, f"--user-data-dir={work / 'profile'}", *size, address]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    keep(work / "page.png", "preview-page.webp")

    # %%
    # The window: the fire between the pictures it was made from.

    run("demo", "-o", work / "fire", "-q")
    shot = ("--window", "1280x800", "--screenshot", work / "window.png", "-q")
    run("preview", work / "fire", "--angle", 32, "--elevation", 18, *shot)
    keep(work / "window.png", "preview-window.webp")

    # %%
    # Motion, and what stands in its way.

    run(*BURST, *THINGS, "--no-turntable", "-o", work / "burst", "-q")
    shown = ("--show", "volume,arrows,bodies,box", "--frames", 8, "--exposure", -1.5)
    run("preview", work / "burst", *shown, "--angle", -25, *shot)
    keep(work / "window.png", "preview-motion.webp")
