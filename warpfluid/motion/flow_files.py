"""Flows as files: numbers for compositing, and a picture in colours to look at.

The hue is the direction of motion, the saturation its speed, white is stillness: the coding of the Middlebury benchmark
(Baker et al. 2011), with a wheel in the corner that tells which colour goes where.
"""

from pathlib import Path

import numpy as np

from warpfluid.files.exr import write_exr
from warpfluid.files.images import write_png

# Colours between red, yellow, green, cyan, blue, magenta and red again: more where the eye tells more apart.
STEPS = (15, 6, 4, 11, 13, 6)
CORNERS = ((255, 0, 0), (255, 255, 0), (0, 255, 0), (0, 255, 255), (0, 0, 255), (255, 0, 255))
FAST = 99  # per cent of the pixels that move are slower than full saturation
STILL = 0.01  # pixels a frame below which nothing moves
WHEEL = 0.14  # of the picture's shorter side: the wheel's radius
LEAST_WHEEL, MOST_WHEEL = 10, 48  # its bounds [pixel]
MARGIN = 3
DARKER = 0.75  # of colours beyond full saturation


def write_flow(
    folder: str | Path, frame: int, angle_deg: float, flow: np.ndarray, *, full: float | None = None
) -> tuple[Path, Path]:
    """Write the flow of one view as ``flow.ANGLE.FRAME.exr`` and ``.png``.

    Args:
        folder: It must exist.
        frame: Number of the earlier picture.
        angle_deg: Angle of the view.
        flow: Displacement to the right and up [pixel/frame], shape (2, u, v).
        full: Speed of full saturation [pixel/frame]; of this flow's fastest pixels when omitted.

    Returns:
        The EXR file, float channels ``u`` and ``v``, and the PNG file, rows of both from top to bottom.

    Raises:
        OSError: If a file cannot be written.
        ValueError: If the flow has another shape or is not finite.
    """
    flow = np.asarray(flow, np.float32)
    if flow.ndim != 3 or flow.shape[0] != 2 or not np.isfinite(flow).all():
        raise ValueError(f"flow has shape {flow.shape}, expected finite displacements of shape (2, u, v)")
    stem = f"flow.{angle_deg:g}.{frame:04d}"
    numbers, colours = (Path(folder) / f"{stem}.{suffix}" for suffix in ("exr", "png"))
    write_exr(numbers, {name: component.T[::-1] for name, component in zip("uv", flow, strict=True)})
    write_png(colours, draw_flow(flow, full))
    return numbers, colours


def draw_flow(flow: np.ndarray, full: float | None = None) -> np.ndarray:
    """Return a picture of a flow in colours with its legend, uint8, shape (rows, columns, 3), top row first."""
    full = full or saturated_speed(flow)
    picture = colour_flow(flow, full).transpose(1, 0, 2)[::-1].copy()
    _draw_legend(picture, full)
    return picture


def saturated_speed(flow: np.ndarray) -> float:
    """Return a round speed that hardly a moving pixel exceeds [pixel/frame]; 1 for a still picture."""
    speed = np.hypot(*flow)
    moving = speed[speed > STILL]
    if not moving.size:
        return 1.0
    fast = float(np.percentile(moving, FAST))
    decade = 10.0 ** np.floor(np.log10(fast))
    return float(next(decade * digit for digit in (1, 2, 3, 5, 10) if decade * digit >= fast * (1 - 1e-6)))


def colour_flow(flow: np.ndarray, full: float) -> np.ndarray:
    """Return the colours of displacements, uint8.

    Args:
        flow: Displacement to the right and up, shape (2, ...).
        full: Speed of full saturation; faster pixels are darker.

    Returns:
        Colours, shape (..., 3).
    """
    wheel = colour_wheel()
    speed = np.hypot(*flow) / full
    turn = (np.arctan2(-flow[1], flow[0]) / (2 * np.pi)) % 1.0 * len(wheel)  # Middlebury turns with v down
    below = np.floor(turn).astype(int) % len(wheel)
    share = (turn - np.floor(turn))[..., None]
    colour = (1 - share) * wheel[below] + share * wheel[(below + 1) % len(wheel)]
    inside = 1 - speed[..., None] * (1 - colour / 255)
    shade = np.where(speed[..., None] <= 1, inside, DARKER * colour / 255)
    return np.round(255 * np.clip(shade, 0, 1)).astype(np.uint8)


def colour_wheel() -> np.ndarray:
    """Return the colours of all directions, shape (55, 3), values 0 to 255: red is to the right."""
    following = (*CORNERS[1:], CORNERS[0])
    arcs = [
        np.linspace(here, there, count, endpoint=False)
        for here, there, count in zip(CORNERS, following, STEPS, strict=True)
    ]
    return np.concatenate(arcs)


def _draw_legend(picture: np.ndarray, full: float) -> None:
    """Draw the wheel with the speed of its rim into a corner, in place; nothing into a tiny picture."""
    from PIL import Image, ImageDraw

    rows, columns = picture.shape[:2]
    radius = int(np.clip(WHEEL * min(rows, columns), LEAST_WHEEL, MOST_WHEEL))
    if min(rows, columns) < 4 * radius:
        return
    across = np.arange(-radius, radius + 1) / radius
    u, v = np.meshgrid(across, -across)
    inside = np.hypot(u, v) <= 1
    corner = picture[MARGIN : MARGIN + 2 * radius + 1, columns - MARGIN - 2 * radius - 1 : columns - MARGIN]
    corner[inside] = colour_flow(np.stack([u, v]), 1.0)[inside]
    canvas = Image.fromarray(picture)
    draw = ImageDraw.Draw(canvas)
    left = columns - MARGIN - 2 * radius - 1
    draw.ellipse((left, MARGIN, columns - MARGIN - 1, MARGIN + 2 * radius), outline=(90, 90, 90))
    words = f"{full:g} px"
    draw.text((columns - MARGIN, MARGIN + 2 * radius + 2), words, fill=(60, 60, 60), anchor="ra", font_size=10)
    picture[:] = np.asarray(canvas)
