"""The pieces of the report's page: embedded pictures, tables, the energy curve."""

import base64
import io
from collections.abc import Mapping, Sequence
from html import escape
from numbers import Integral, Real

import numpy as np

from warpfluid.rendering.ramps import apply_ramp

WIDTH, HEIGHT = 440, 250  # of the energy curve, inside its margins
LEFT, TOP, RIGHT, BOTTOM = 64, 26, 16, 38


def section(title: str, content: str) -> str:
    """Return a titled card, or nothing if it has no content."""
    return f'<h2>{escape(title)}</h2><div class="card">{content}</div>' if content else ""


def side_by_side(*parts: str) -> str:
    """Return the parts in a row that breaks on narrow screens; empty ones are left out."""
    parts = [part for part in parts if part]
    return f'<div class="side">{"".join(parts)}</div>' if parts else ""


def image(picture: np.ndarray, words: str, style: str = "") -> str:
    """Return a picture, embedded as PNG, uint8 of shape (rows, columns) or (rows, columns, 3)."""
    from PIL import Image

    png = io.BytesIO()
    Image.fromarray(_checked(picture, words)).save(png, "PNG", optimize=True)
    kind = f' class="{style}"' if style else ""
    return f'<img{kind} alt="{escape(words)}" src="{_data_uri("png", png)}">'


def film(pictures: np.ndarray, rate: float, words: str) -> str:
    """Return pictures as an endless film, embedded as WebP."""
    from PIL import Image

    first, *others = [Image.fromarray(_checked(picture, words)) for picture in pictures]
    webp = io.BytesIO()
    first.save(webp, "WEBP", save_all=True, append_images=others, duration=round(1000 / rate), loop=0, quality=85)
    return f'<img alt="{escape(words)}" src="{_data_uri("webp", webp)}">'


def table(rows: Sequence[Mapping[str, object]]) -> str:
    """Return rows of the same columns as a table; numbers go to the right."""
    if not rows:
        return ""
    names = list(rows[0])
    numeric = {name: all(isinstance(row.get(name), Real | None) for row in rows) for name in names}
    kind = {name: ' class="number"' if numeric[name] else "" for name in names}
    head = "".join(f"<th{kind[name]}>{escape(name)}</th>" for name in names)
    lines = "".join(
        "<tr>" + "".join(f"<td{kind[name]}>{cell(row.get(name))}</td>" for name in names) + "</tr>" for row in rows
    )
    return scroll(f"<table><tr>{head}</tr>{lines}</table>")


def scroll(content: str) -> str:
    """Return content that may be wider than a narrow screen, and is then moved sideways."""
    return f'<div class="scroll">{content}</div>' if content else ""


def shortened(text: str, most: int = 60) -> str:
    """Return a text with its middle left out if it is long; the whole of it shows on hovering."""
    if len(text) <= most:
        return escape(text)
    head, tail = most // 3, most - most // 3 - 1
    return f'<span title="{escape(text)}">{escape(text[:head])}…{escape(text[-tail:])}</span>'


def cell(value: object) -> str:
    """Return a value as people write it: three digits of a number, a dash for none."""
    if value is None:
        return "–"
    if isinstance(value, Real) and not isinstance(value, Integral):
        size = abs(value)
        digits = 3 if size < 9.9995 else 1 if size < 9999.5 else 0
        return f"{value:.{digits}f}".replace("-", "−") if np.isfinite(value) else "–"
    return escape(str(value))


def colour_bar(end: float) -> str:
    """Return the jet colours of densities from 0 to ``end``."""
    stops = apply_ramp(np.linspace(0, 255, 33), "jet")
    colours = ", ".join("#{:02x}{:02x}{:02x}".format(*map(int, stop)) for stop in stops)
    labels = "".join(f"<span>{end * share:.3g}</span>" for share in (0, 0.25, 0.5, 0.75, 1))
    style = f"background: linear-gradient(to right, {colours})"
    return f'<div class="bar" style="{style}"></div><div class="ends">{labels}</div>'


def energy_chart(energies: np.ndarray) -> str:
    """Draw the energy (Eq. 1) after every half-step, on a logarithmic axis.

    Args:
        energies: After the M-step and after the E-step, shape (iteration, 2).

    Returns:
        An inline SVG; nothing if no energy is positive and finite.

    Raises:
        ValueError: If the array has another shape.
    """
    energies = np.asarray(energies, float)
    if energies.ndim != 2 or energies.shape[1] != 2:
        raise ValueError(f"energies have shape {energies.shape}; (iteration, 2), after M and E, is needed")
    values = energies.ravel()
    good = np.isfinite(values) & (values > 0)
    if not good.any():
        return ""
    ticks = _log_ticks(values[good].min(), values[good].max())
    low, high = np.log10([ticks[0], ticks[-1]])
    x = LEFT + 14 + np.arange(len(values)) * (WIDTH - 28) / max(len(values) - 1, 1)
    y = TOP + HEIGHT * (high - np.log10(np.where(good, values, ticks[0]))) / (high - low)
    points = [(px, py, i) for i, (px, py) in enumerate(zip(x, y, strict=True)) if good[i]]
    parts = [_axes(ticks, x[::2] + (x[1] - x[0]) / 2)]
    parts.append(f'<polyline class="curve" points="{" ".join(f"{px:.1f},{py:.1f}" for px, py, _ in points)}"/>')
    for px, py, i in points:
        step = "ME"[i % 2]
        told = f"<title>{step}-step {i // 2 + 1}: {values[i]:.3g}</title>"
        parts.append(f'<circle class="{step.lower()}" cx="{px:.1f}" cy="{py:.1f}" r="4">{told}</circle>')
    box = f"0 0 {LEFT + WIDTH + RIGHT} {TOP + HEIGHT + BOTTOM}"
    return f'<svg viewBox="{box}" role="img" aria-label="energy by half-step">{"".join(parts)}</svg>'


def _axes(ticks: list[float], middles: np.ndarray) -> str:
    """Return grid lines, their labels, the iterations' numbers and the legend."""
    low, high = np.log10([ticks[0], ticks[-1]])
    parts = []
    for tick in ticks:
        y = TOP + HEIGHT * (high - np.log10(tick)) / (high - low)
        parts.append(f'<line class="grid" x1="{LEFT}" x2="{LEFT + WIDTH}" y1="{y:.1f}" y2="{y:.1f}"/>')
        parts.append(f'<text x="{LEFT - 8}" y="{y + 4:.1f}" text-anchor="end">{_short(tick)}</text>')
    every = -(-len(middles) // 12)
    for i in range(0, len(middles), every):
        parts.append(f'<text x="{middles[i]:.1f}" y="{TOP + HEIGHT + 17}" text-anchor="middle">{i + 1}</text>')
    bottom = TOP + HEIGHT + 34
    parts.append(f'<text x="{LEFT + WIDTH / 2}" y="{bottom}" text-anchor="middle">iteration</text>')
    for x, style, words in ((8, "m", "after M (images)"), (148, "e", "after E (volume)")):
        parts.append(f'<circle class="{style}" cx="{LEFT + x}" cy="11" r="4"/>')
        parts.append(f'<text x="{LEFT + x + 10}" y="15">{words}</text>')
    return "".join(parts)


def _log_ticks(low: float, high: float) -> list[float]:
    """Return round numbers that enclose a range: 1, 2, 5 a decade, or decades alone if there are many."""
    decades = range(int(np.floor(np.log10(low))) - 1, int(np.ceil(np.log10(high))) + 2)
    steps = (1, 2, 5) if high / low < 1e3 else (1,)
    ticks = [step * 10.0**decade for decade in decades for step in steps]
    first = max(i for i, tick in enumerate(ticks) if tick <= low * 1.0001)
    last = min(i for i, tick in enumerate(ticks) if tick >= high * 0.9999)
    return ticks[first : max(last, first + 1) + 1]


def _short(value: float) -> str:
    """Return a round number as short as it can be: 2e6 for two millions."""
    return f"{value:g}" if 1e-3 <= value < 1e5 else f"{value:.0e}".replace("e+0", "e").replace("e-0", "e−")


def _checked(picture: np.ndarray, words: str) -> np.ndarray:
    """Return the picture, contiguous, or say what is wrong with it."""
    picture = np.ascontiguousarray(picture)
    grey_or_rgb = picture.ndim == 2 or (picture.ndim == 3 and picture.shape[2] == 3)
    if picture.dtype != np.uint8 or not grey_or_rgb or picture.size == 0:
        raise ValueError(
            f"picture '{words}' is {picture.dtype} of shape {picture.shape}; "
            "uint8 of shape (rows, columns) or (rows, columns, 3) is needed"
        )
    return picture


def _data_uri(kind: str, content: io.BytesIO) -> str:
    """Return bytes as an address that holds them."""
    return f"data:image/{kind};base64,{base64.b64encode(content.getvalue()).decode()}"
