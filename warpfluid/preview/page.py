"""One HTML page that plays volumes in a browser: a single file, without a server or a network.

The page carries the packed volumes, a shader that adds up light along rays as the reconstruction does, and a still
picture for a browser that has no WebGL 2.
"""

import base64
import io
import json
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template

import numpy as np

from warpfluid.files.atomic import replacing
from warpfluid.files.sequences import format_frames
from warpfluid.preview import packing
from warpfluid.preview.scene import Scene
from warpfluid.preview.solids import pack_solids
from warpfluid.rendering.laid_in import AMBIENT, KEY_LIGHT
from warpfluid.rendering.ramps import RAMPS

TABLE_TOP = 4096.0  # of the page's half floats: it keeps the faintest of them precise
SCRIPTS = ("frames.js", "lines.js", "shade.js", "solids.js", "graphics.js", "page.js")
SHADERS = ("page.frag", "shade.frag", "solids.frag", "places.vert")
TO_LIGHT = (-0.6, 1.0, 0.45)  # (x, y, z): from above, the left and the front
LAMPS = (0.95, 0.22)  # light from there, and from all around; a lit face is a little above white
SHADOW = 0.6  # share of the extinction that takes light on its way in: the rest is scattered on, not lost
OVERHEAD = 60_000  # characters that are neither volumes nor the still picture


@dataclass(frozen=True, kw_only=True)
class Written:
    """A page that was written.

    Attributes:
        path: The file.
        bytes: Its size.
        box: Voxels of the volumes (x, y, z).
        stored: Voxels of the part that the page holds (x, y, z).
        coarser: How many times longer its voxels are.
    """

    path: Path
    bytes: int
    box: tuple[int, int, int]
    stored: tuple[int, int, int]
    coarser: float


def write_page(path: str | Path, scene: Scene, *, budget: float) -> Written:
    """Write a page.

    Args:
        path: The file; its folder must exist.
        scene: What it shows.
        budget: How large the file may get [MB]; volumes are stored coarser to fit.

    Raises:
        ValueError: If a volume is damaged, the frames have unlike sizes, or do not fit into the budget.
        OSError: If the page cannot be written.
    """
    path, frames = Path(path), scene.frames
    still = _still(scene)
    extent = packing.measure(scene.volumes, frames)
    solids = pack_solids(scene, extent.box)
    room = budget * 1e6 - len(still) - len(_as_script(solids)) - OVERHEAD
    if room < 0:
        raise ValueError(f"html-size is {budget:g} MB, which what stands in the run fills alone: choose a larger one")
    size, packed = packing.pack_within(scene.volumes, frames, extent, room)
    shape = (extent.box[0], extent.box[2], extent.box[1])
    coarser = max(a / b for a, b in zip(extent.size, size, strict=True))
    facts = _facts(scene, extent, coarser)
    package = files("warpfluid.preview")
    page = Template((package / "template.html").read_text("utf-8")).substitute(
        title=escape(scene.title),
        subtitle=escape(f"{' x '.join(map(str, shape))} voxels, {_count(len(frames), 'frame')}"),
        alt=escape(f"{scene.title}, frame {scene.middle}"),
        still=still,
        facts="".join(f"<tr><td>{escape(name)}</td><td>{escape(text)}</td></tr>" for name, text in facts.items()),
        scene=_as_script({**_described(scene, extent, size), "solids": solids}),
        frames="\n".join(f'<script type="text/plain" class="frame">{text}</script>' for text in packed),
        script="".join((package / name).read_text("utf-8") for name in SCRIPTS),
    )
    data = page.encode()
    with replacing(path) as file:
        file.write(data)
    stored = (size[0], size[2], size[1])
    return Written(path=path, bytes=len(data), box=shape, stored=stored, coarser=coarser)


def _described(scene: Scene, extent: packing.Extent, size: tuple[int, int, int]) -> dict:
    """Return what the page's script must know; points and sizes are (x, y, z), from the middle of the box."""
    low, high, middle = (np.array(corner)[[0, 2, 1]] for corner in (extent.low, extent.high, extent.box))
    around = max(extent.box[0], extent.box[1])
    table = (TABLE_TOP * (np.arange(packing.LEVELS + 1) / packing.LEVELS) ** 2).astype(np.float16)
    return {
        "frames": list(scene.frames),
        "start": scene.frames.index(scene.middle),
        "rate": scene.rate,
        "lights": [float(f"{light:.4g}") for light in extent.lights],
        "box": [around, extent.box[2], around],
        "low": (low - middle / 2).tolist(),
        "high": (high - middle / 2).tolist(),
        "cells": [size[0], size[2], size[1]],
        "peak": extent.peak / TABLE_TOP,
        "table": table.view(np.uint16).tolist(),
        "angle": scene.angle_deg,
        "elevation": scene.elevation_deg or 0,
        "angles": list(scene.volumes.angles_deg),
        "ramp": scene.look,
        "ramps": {name: [[grey, *colour] for grey, colour in stops.items()] for name, stops in RAMPS.items()},
        "exposure": scene.exposure,
        "light": TO_LIGHT,
        "lamps": LAMPS,
        "shadow": SHADOW,
        "headlight": KEY_LIGHT.tolist(),
        "headlamps": (1 - AMBIENT, AMBIENT),
        "reach": 2 * float(np.hypot(around, np.hypot(around, extent.box[2]))),
        "shaders": {Path(name).stem: (files("warpfluid.preview") / name).read_text("utf-8") for name in SHADERS},
    }


def _facts(scene: Scene, extent: packing.Extent, coarser: float) -> dict[str, str]:
    """Return the numbers beside the picture, in words."""
    low, high = min(extent.lights), max(extent.lights)
    light = f"{low:.3g} to {high:.3g}" if len(scene.frames) > 1 else f"{high:.3g}"
    stored = "a byte a voxel" + (f", {coarser:.2f} times coarser" if coarser > 1 else "")
    return {
        "frames": f"{format_frames(scene.frames)}, {scene.rate:g} a second",
        **scene.facts(),
        "light": f"{light} grey levels in all",
        "in this page": stored,
    }


def _still(scene: Scene) -> str:
    """Return the still picture as a data URI."""
    from PIL import Image

    png = io.BytesIO()
    Image.fromarray(scene.still()).save(png, "PNG", optimize=True)
    return f"data:image/png;base64,{base64.b64encode(png.getvalue()).decode()}"


def _as_script(content: dict | list) -> str:
    """Return JSON that no name in it can end, or open a comment in."""
    return json.dumps(content, allow_nan=False).replace("<", "\\u003c")


def _count(number: int, word: str) -> str:
    return f"{number} {word}{'s' * (number != 1)}"
