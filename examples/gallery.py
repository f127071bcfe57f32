"""What the examples share: the packaged fire, and simple pictures for the results."""

import sys
import tempfile
from functools import cache
from importlib.resources import files
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

import warpfluid as wf
from warpfluid.files.images import write_png
from warpfluid.rendering.ramps import apply_ramp
from warpfluid.rendering.turntable import in_a_row

COLOURS = ((214, 96, 20), (40, 110, 190), (60, 150, 80), (150, 70, 160), (150, 120, 20), (70, 70, 78))
INK, FAINT = (60, 60, 66), (222, 222, 226)
CAPTION = 20  # rows


@cache
def folder() -> Path:
    """Return where pictures go: the first argument, or a temporary folder."""
    path = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="warpfluid-examples-"))
    path.mkdir(parents=True, exist_ok=True)
    return path


def save(name: str, picture: np.ndarray) -> None:
    """Write a picture, uint8 (rows, columns[, 3]), and say where."""
    path = folder() / name
    write_png(path, picture)
    print(f"wrote {path}")


def sample(frame: int = 8, *, width: int = 96, sides: tuple[str, ...] = ("front", "side")) -> wf.Views:
    """Return the views of one frame of the packaged fire, 96 x 144 pixels unless a smaller width is asked for."""
    samples = files("warpfluid") / "samples"
    angles = {"front": 0, "side": 90}
    views = [(angles[side], str(samples / f"{side}.####.png")) for side in sides]
    return wf.open_shot(views, wf.InputOptions(resolution=str(width))).views(frame)


def shown(image: np.ndarray, ramp: str = "fire", *, white: float = 255.0, zoom: int = 2) -> np.ndarray:
    """Return an image (u, v) as a colour picture, top row first, each pixel enlarged."""
    return apply_ramp(image.T[::-1], ramp, white).repeat(zoom, axis=0).repeat(zoom, axis=1)


def band_shown(band: np.ndarray, zoom: int = 1) -> np.ndarray:
    """Return a sub-band (u, v) as a picture in which zero is grey."""
    reach = max(float(np.quantile(np.abs(band), 0.995)), 1e-9)
    return shown(127.5 + 127.5 * band / reach, "gray", zoom=zoom)


def captioned(picture: np.ndarray, text: str) -> np.ndarray:
    """Return a picture with a line of text below."""
    line = Image.new("RGB", (picture.shape[1], CAPTION), "black")
    ImageDraw.Draw(line).text(
        (line.width / 2, CAPTION / 2), text, font=ImageFont.load_default(12), fill=(200, 200, 200), anchor="mm"
    )
    return np.concatenate([picture, np.asarray(line)])


def panel(pictures: dict[str, np.ndarray]) -> np.ndarray:
    """Return pictures of one height side by side, each with its caption."""
    return in_a_row(captioned(picture, text) for text, picture in pictures.items())


def stack(pictures: list[np.ndarray]) -> np.ndarray:
    """Return pictures one below the other, filled up with black to one width."""
    width = max(picture.shape[1] for picture in pictures)
    return np.concatenate([np.pad(p, ((0, 4), (0, width - p.shape[1]), (0, 0))) for p in pictures])


def plot(curves: dict[str, tuple], title: str, *, size: tuple[int, int] = (560, 300)) -> np.ndarray:
    """Draw curves, each a pair (x, y) by its name, over common axes that begin at zero."""
    width, height = size
    left, right, top, bottom = 64, 16, 34, 34
    most_x = max(float(np.max(x)) for x, _ in curves.values())
    most_y = max(float(np.max(y)) for _, y in curves.values()) * 1.05
    picture = Image.new("RGB", size, "white")
    pen, font = ImageDraw.Draw(picture), ImageFont.load_default(12)

    def place(x, y):
        across = left + np.asarray(x, float) / most_x * (width - left - right)
        return across, height - bottom - np.asarray(y, float) / most_y * (height - top - bottom)

    for part in np.linspace(0, 1, 5):
        x, y = place(part * most_x, part * most_y)
        pen.line([(left, y), (width - right, y)], fill=FAINT)
        pen.text((left - 8, y), f"{part * most_y:.3g}", font=font, fill=INK, anchor="rm")
        pen.text((x, height - bottom + 8), f"{part * most_x:.3g}", font=font, fill=INK, anchor="mt")
    pen.text((left, 8), title, font=font, fill=INK)
    for index, ((name, (x, y)), colour) in enumerate(zip(curves.items(), COLOURS, strict=False)):
        pen.line(list(zip(*place(x, y), strict=True)), fill=colour, width=2)
        pen.text((width - right, top + 16 * index), name, font=font, fill=colour, anchor="rt")
    return np.asarray(picture)
