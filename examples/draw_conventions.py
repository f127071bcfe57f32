"""
Axes and angles
===============

Draws ``conventions.png``: the box from above and in perspective, two cameras, and the axes of their pictures.
"""

# %%
# Words and lines are drawn at twice the size and reduced.

import numpy as np
from gallery import folder
from PIL import Image, ImageDraw, ImageFont

WIDTH, HEIGHT, SHARPER = 1160, 520, 2
INK, FAINT, BOX = (70, 74, 84), (196, 200, 210), (150, 156, 170)
X, Y, Z = (206, 62, 50), (46, 140, 66), (48, 98, 206)
CAMERAS = {0: (214, 120, 20), 60: (128, 66, 176)}

picture = Image.new("RGB", (WIDTH * SHARPER, HEIGHT * SHARPER), "white")
pen = ImageDraw.Draw(picture)


def text(place, words: str, colour=INK, size: int = 15, anchor: str = "mm") -> None:
    """Write words at a place."""
    pen.text(tuple(np.multiply(place, SHARPER)), words, colour, ImageFont.load_default(size * SHARPER), anchor=anchor)


def line(places, colour, width: float = 1.5) -> None:
    """Draw a line through places."""
    pen.line([tuple(np.multiply(place, SHARPER)) for place in places], colour, round(width * SHARPER), joint="curve")


def arrow(start, end, colour, name: str = "", width: float = 2.5) -> None:
    """Draw an arrow with its name beyond the tip."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    along = (end - start) / np.linalg.norm(end - start)
    across = np.array([-along[1], along[0]])
    line([start, end - 6 * along], colour, width)
    tip = [end, end - 12 * along + 5 * across, end - 12 * along - 5 * across]
    pen.polygon([tuple(place * SHARPER) for place in tip], colour)
    text(end + 14 * along, name, colour, 17)


# %%
# From above: x to the right, z towards the front viewer, who stands below. The camera of angle t sees u to its right.
# It stands at (x, z) = (-sin t, cos t): seen from above, angles go clockwise, and 90 is to the left of the front.

MIDDLE, HALF, AWAY = np.array([300.0, 210.0]), 92.0, 190.0


def above(x: float, z: float) -> np.ndarray:
    """Return where a point of the ground is drawn, seen from above."""
    return MIDDLE + np.array([x, z])


text((300, 22), "from above", size=17)
line([above(x * HALF, z * HALF) for x, z in ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))], BOX)
arrow(MIDDLE, above(HALF + 34, 0), X, "x")
arrow(MIDDLE, above(0, HALF + 34), Z, "z")
text(MIDDLE - 12, "y", Y, 17)
pen.ellipse([tuple((MIDDLE - 4) * SHARPER), tuple((MIDDLE + 4) * SHARPER)], Y)
for angle_deg, colour in CAMERAS.items():
    t = np.radians(angle_deg)
    right, towards = np.array([np.cos(t), np.sin(t)]), np.array([-np.sin(t), np.cos(t)])
    foot = AWAY * towards
    line([above(*(foot - 100 * right)), above(*(foot + 100 * right))], colour, 3)
    arrow(above(*(foot + 60 * right)), above(*(foot + 118 * right)), colour, "u")
    for place in (-60, 0, 60):
        line([above(*(foot + place * right)), above(*(place * right - 60 * towards))], colour, 0.7)
    text(above(*(foot * 1.13 - 34 * right * (angle_deg == 0))), f"t = {angle_deg}", colour)
arc = [above(150 * -np.sin(a), 150 * np.cos(a)) for a in np.radians(np.arange(4, 57))]
line(arc[:-3], INK, 1.2)
arrow(arc[-5], arc[-1], INK, width=1.2)
text(above(-62, 120), "t", INK, 17)
text((300, 500), "u = x cos t + z sin t      v = y", size=16)

# %%
# In perspective: the same box with its height, and the picture plane of the front camera.

ORIGIN, STEP = np.array([880.0, 244.0]), 74.0


def space(x: float, y: float, z: float) -> np.ndarray:
    """Return where a point of space is drawn, seen from the front, the right and above."""
    return ORIGIN + STEP * np.array([0.92 * x - 0.52 * z, -y + 0.14 * x + 0.3 * z])


text((850, 22), "in perspective", size=17)
corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
for i, (x, z) in enumerate(corners):
    nx, nz = corners[(i + 1) % 4]
    for y in (-1.5, 1.5):
        line([space(x, y, z), space(nx, y, nz)], BOX)
    line([space(x, -1.5, z), space(x, 1.5, z)], BOX)
base = (-1, -1.5, -1)
arrow(space(*base), space(1.5, -1.5, -1), X, "x")
arrow(space(*base), space(-1, 2.0, -1), Y, "y")
arrow(space(*base), space(-1, -1.5, 1.6), Z, "z")
plane = [(-1, -1.5), (1, -1.5), (1, 1.5), (-1, 1.5), (-1, -1.5)]
line([space(x, y, 3.6) for x, y in plane], CAMERAS[0], 3)
arrow(space(-1, -1.5, 3.6), space(1.45, -1.5, 3.6), CAMERAS[0], "u")
arrow(space(-1, -1.5, 3.6), space(-1, 1.95, 3.6), CAMERAS[0], "v")
for x, y in ((0.5, 0.9), (0.5, -0.6)):
    line([space(x, y, -1), space(x, y, 3.6)], CAMERAS[0], 0.7)
text(space(0, -1.1, 3.6), "picture at t = 0", CAMERAS[0], 12)
text((850, 500), "all rays of a view are parallel and level", size=16)

path = folder() / "conventions.png"
picture.resize((WIDTH, HEIGHT), Image.Resampling.LANCZOS).save(path, optimize=True)
print(f"wrote {path}")
