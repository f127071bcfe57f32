"""Curves of the report's page, as inline SVG that follows the page's colours."""

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

WIDTH, HEIGHT = 440, 250  # of the curve, inside its margins
LOW_HEIGHT = 170  # of a curve over frames
LEFT, TOP, RIGHT, BOTTOM = 64, 26, 16, 38
MOST_DOTS = 40  # more would hide the curve
STYLES = ("one", "two", "three")


def energy_chart(energies: np.ndarray, *, alternates: bool = True) -> str:
    """Draw the energy after every half-step, on a logarithmic axis.

    Args:
        energies: After the M-step and after the E-step (Eq. 1), shape (iteration, 2).
        alternates: If not, they are those before and after each round of another method.

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
    words = ("after M (images)", "after E (volume)") if alternates else ("before a round", "after it")
    parts = [_axes(ticks, x[::2] + (x[1] - x[0]) / 2, words)]
    parts.append(f'<polyline class="curve" points="{" ".join(f"{px:.1f},{py:.1f}" for px, py, _ in points)}"/>')
    for px, py, i in points:
        step = "ME"[i % 2]
        name = f"{step}-step" if alternates else f"{words[i % 2]}:"
        told = f"<title>{name} {i // 2 + 1}: {values[i]:.3g}</title>"
        parts.append(f'<circle class="{step.lower()}" cx="{px:.1f}" cy="{py:.1f}" r="4">{told}</circle>')
    box = f"0 0 {LEFT + WIDTH + RIGHT} {TOP + HEIGHT + BOTTOM}"
    return f'<svg viewBox="{box}" role="img" aria-label="energy by half-step">{"".join(parts)}</svg>'


def series_chart(series: Mapping[str, Mapping[int, float]], words: str, *, unit: str = "") -> str:
    """Draw numbers over frames, on a linear axis that begins at zero if they come near it.

    Args:
        series: Values by frame, by name; up to three.
        words: What they are, for who cannot see the curve.
        unit: Behind the numbers.

    Returns:
        An inline SVG; nothing if there are not two frames with a finite value.
    """
    kept = {name: {f: v for f, v in values.items() if np.isfinite(v)} for name, values in series.items()}
    frames = sorted({frame for values in kept.values() for frame in values})
    if len(frames) < 2:
        return ""
    every = [value for values in kept.values() for value in values.values()]
    ticks = linear_ticks(min(every), max(every))
    x = lambda frame: LEFT + 14 + (frame - frames[0]) * (WIDTH - 28) / (frames[-1] - frames[0])  # noqa: E731
    y = lambda value: TOP + LOW_HEIGHT * (ticks[-1] - value) / (ticks[-1] - ticks[0])  # noqa: E731
    parts = [_grid(y(tick), f"{tick:g}") for tick in ticks]
    for frame in sorted({frames[round(place)] for place in np.linspace(0, len(frames) - 1, 6)}):
        parts.append(f'<text x="{x(frame):.1f}" y="{TOP + LOW_HEIGHT + 17}" text-anchor="middle">{frame}</text>')
    parts.append(_legend([name for name in kept if name], unit))
    for style, values in zip(STYLES, kept.values(), strict=False):
        points = " ".join(f"{x(frame):.1f},{y(value):.1f}" for frame, value in sorted(values.items()))
        parts.append(f'<polyline class="curve {style}" points="{points}"/>')
        if len(values) <= MOST_DOTS:
            parts += [_dot(style, x(frame), y(v), f"frame {frame}: {v:.4g}{unit}") for frame, v in values.items()]
    box = f"0 0 {LEFT + WIDTH + RIGHT} {TOP + LOW_HEIGHT + BOTTOM - 12}"
    return f'<svg viewBox="{box}" role="img" aria-label="{escape(words)}">{"".join(parts)}</svg>'


def linear_ticks(low: float, high: float, count: int = 5) -> list[float]:
    """Return round numbers that enclose a range; zero is among them if the range comes near it."""
    low = 0.0 if 0 < low < 0.5 * high else low
    span = max(high - low, 1e-3 * max(abs(high), 1e-9))
    decade = 10.0 ** np.floor(np.log10(span / count))
    step = next(decade * digit for digit in (1, 2, 5, 10) if decade * digit * count >= span * (1 - 1e-9))
    first, last = np.floor(low / step + 1e-9), np.ceil(high / step - 1e-9)
    return [float(f"{i * step:.10g}") for i in np.arange(first, max(last, first + 1) + 1)]


def _grid(y: float, label: str) -> str:
    """Return a line of the grid with its number."""
    line = f'<line class="grid" x1="{LEFT}" x2="{LEFT + WIDTH}" y1="{y:.1f}" y2="{y:.1f}"/>'
    return f'{line}<text x="{LEFT - 8}" y="{y + 4:.1f}" text-anchor="end">{label}</text>'


def _dot(style: str, x: float, y: float, told: str) -> str:
    return f'<circle class="{style}" cx="{x:.1f}" cy="{y:.1f}" r="2.5"><title>{escape(told)}</title></circle>'


def _legend(names: Sequence[str], unit: str) -> str:
    """Return the names of curves, and the unit at the right."""
    parts, at = [], LEFT + 8
    for style, name in zip(STYLES, names, strict=False):
        parts.append(
            f'<circle class="{style}" cx="{at}" cy="11" r="4"/><text x="{at + 10}" y="15">{escape(name)}</text>'
        )
        at += 32 + 7 * len(name)
    return "".join(parts) + f'<text x="{LEFT + WIDTH}" y="15" text-anchor="end">{escape(unit.strip())}</text>'


def _axes(ticks: list[float], middles: np.ndarray, words: tuple[str, str]) -> str:
    """Return grid lines, their labels, the iterations' numbers and the legend."""
    low, high = np.log10([ticks[0], ticks[-1]])
    parts = []
    for tick in ticks:
        y = TOP + HEIGHT * (high - np.log10(tick)) / (high - low)
        parts.append(_grid(y, _short(tick)))
    every = -(-len(middles) // 12)
    for i in range(0, len(middles), every):
        parts.append(f'<text x="{middles[i]:.1f}" y="{TOP + HEIGHT + 17}" text-anchor="middle">{i + 1}</text>')
    bottom = TOP + HEIGHT + 34
    parts.append(f'<text x="{LEFT + WIDTH / 2}" y="{bottom}" text-anchor="middle">iteration</text>')
    for x, style, name in ((8, "m", words[0]), (148, "e", words[1])):
        parts.append(f'<circle class="{style}" cx="{LEFT + x}" cy="11" r="4"/>')
        parts.append(f'<text x="{LEFT + x + 10}" y="15">{name}</text>')
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
