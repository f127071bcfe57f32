"""A comparison as a table of plain text."""

from warpfluid.comparison.comparison import Comparison
from warpfluid.files.sequences import format_frames
from warpfluid.metrics import METRICS, Metric

AIMS = {"low": "↓ 0", "high": "↑", "one": "→ 1"}
BEST, PLAIN = "> ", "  "
AGAINST = {
    "truth": "the truth at the same angles",
    "footage": "the footage from other angles, as distributions",
    "nothing": "nothing",
}


def comparison_lines(comparison: Comparison) -> list[str]:
    """Return the table, what stands above it and below it."""
    names = list(comparison.values)
    rows = [row for metric in METRICS.values() if (row := _row(comparison, metric))]
    head = ["", "", *(PLAIN + name for name in names)]
    widths = [max(len(row[i]) for row in [head, *rows]) for i in range(len(head))]
    lines = [*_facts(comparison), ""]
    for row in [head, *rows]:
        lines.append("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip())
    return [*lines, "", *_notes(comparison)]


def number(metric: Metric, value: float) -> str:
    """Return a value as the table shows it: decibels with one digit, the others with three."""
    return f"{value:.1f}" if metric.best == "high" and value > 1 else f"{value:.3f}"


def best_of(comparison: Comparison, metric: Metric) -> tuple[str, ...]:
    """Return the names of the best values of a metric that ranks, as they are shown; none if all are alike."""
    values = {
        name: numbers[metric.name]
        for name, numbers in comparison.values.items()
        if metric.name in numbers and name not in comparison.floors
    }
    shown = {name: number(metric, value) for name, value in values.items()}
    if not (metric.ranks and comparison.ranks) or len(set(shown.values())) < 2:
        return ()
    best = min(values, key=lambda name: metric.badness(values[name]))
    return tuple(name for name in shown if shown[name] == shown[best])


def multiple(comparison: Comparison, metric: Metric, name: str) -> float | None:
    """Return a distance as a multiple of the yardstick's; None where that makes no sense."""
    floor = comparison.values.get(comparison.yardstick or "", {}).get(metric.name, 0)
    if metric.best != "low" or floor <= 1e-3 or name in comparison.floors:
        return None
    return comparison.values[name][metric.name] / floor


def _row(comparison: Comparison, metric: Metric) -> list[str] | None:
    """Return the cells of a metric; None if it was not measured."""
    if not any(metric.name in numbers for numbers in comparison.values.values()):
        return None
    best, cells = best_of(comparison, metric), []
    for name, numbers in comparison.values.items():
        text = "–"
        if metric.name in numbers:
            times = multiple(comparison, metric, name)
            text = number(metric, numbers[metric.name]) + ("" if times is None else f" ({times:.1f} x)")
        cells.append((BEST if name in best else PLAIN) + text)
    label = metric.label if metric.ranks else f"({metric.label})"
    return [label, AIMS[metric.best], *cells]


def _facts(comparison: Comparison) -> list[str]:
    """Return what was measured."""
    angles = [" ".join(f"{angle:g}" for angle in group) for group in (comparison.given_deg, comparison.unseen_deg)]
    return [
        f"against {AGAINST[comparison.against]}",
        f"frames  {format_frames(comparison.frames)}, pictures of {' '.join(map(str, comparison.measured))}",
        f"views   given {angles[0]}, scored {angles[1]} degrees",
    ]


def _notes(comparison: Comparison) -> list[str]:
    """Return how to read the table."""
    lines = [f"note    {note}" for note in comparison.notes]
    if not comparison.ranks:
        edited = ", ".join(comparison.edited)
        lines.append(f"note    {edited}: edited, so not meant to be the footage; no number is marked as the best")
    elif len(comparison.values) - len(comparison.floors) > 1:
        lines.append("note    > marks the best; what stands in brackets ranks nothing")
    if comparison.yardstick:
        lines.append(
            f"note    x: multiples of the floor '{comparison.yardstick}'; what is not above 1 is as good as real"
        )
    return lines
