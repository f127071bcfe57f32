"""The tables of a report's page."""

from collections.abc import Mapping, Sequence
from html import escape

from warpfluid.metrics import METRICS, Metric
from warpfluid.report.html import cell, scroll

AIMS = {"low": "↓", "high": "↑", "one": "→ 1"}
LEAST_FLOOR = 1e-3  # that multiples are told of


def metrics_table(
    methods: Mapping[str, Mapping[str, float]],
    yardsticks: Sequence[str],
    *,
    ranked: bool = True,
    explained: bool = True,
) -> str:
    """Return the table of metrics against methods.

    Args:
        methods: Numbers by the method's name and the metric's.
        yardsticks: Names among them that are floors; distances are told as multiples of the first one.
        ranked: Mark the best number of a row.
        explained: Say what each metric sees, and how to read the table.
    """
    rows = [row for metric in METRICS.values() if (row := _metric_row(metric, methods, yardsticks, ranked, explained))]
    if not rows:
        return ""
    heads = "".join(
        f'<th class="number{" floor" if name in yardsticks else ""}">{escape(name)}</th>' for name in methods
    )
    notes = ["↓ low, ↑ high, → 1 near one is good"]
    notes += ["* ranks nothing: matched by the method itself, or better for a blur"]
    notes += [f"×: multiples of the floor, {escape(yardsticks[0])}"] if yardsticks else []
    note = f'<p class="note">{"; ".join(notes)}</p>'
    table = scroll(f'<table class="metrics"><tr><th></th><th></th>{heads}</tr>{"".join(rows)}</table>')
    return table + note if explained else table


def _metric_row(
    metric: Metric, methods: Mapping[str, Mapping[str, float]], yardsticks: Sequence[str], ranked: bool, explained: bool
) -> str:
    """Return the row of a metric; nothing if no method has it."""
    values = {name: numbers[metric.name] for name, numbers in methods.items() if metric.name in numbers}
    if not values:
        return ""
    rivals = [name for name in values if name not in yardsticks and metric.ranks and ranked]
    best = min(rivals, key=lambda name: metric.badness(values[name])) if len(rivals) > 1 else None
    floor = values.get(yardsticks[0], 0.0) if yardsticks and metric.best == "low" else 0.0
    cells = []
    for name in methods:
        kind = " floor" if name in yardsticks else " best" if name == best else ""
        told = name in values and name not in yardsticks and floor > LEAST_FLOOR
        times = f"<small>{values[name] / floor:.1f}×</small>" if told else ""
        cells.append(f'<td class="number{kind}">{cell(values.get(name))}{times}</td>')
    label = escape(metric.label) + ("" if metric.ranks else "*")
    label += f" <small>{escape(metric.meaning)}</small>" if explained else ""
    return f'<tr><td>{label}</td><td class="aim">{AIMS[metric.best]}</td>{"".join(cells)}</tr>'


def options_table(options: Mapping[str, object], defaults: Mapping[str, object]) -> str:
    """Return the options, those changed from their default first."""
    if not options:
        return ""
    changed = [name for name in options if name in defaults and options[name] != defaults[name]]
    rows = [
        f'<tr class="changed"><td>{escape(name)}</td><td class="mono">{escape(str(options[name]))}</td>'
        f'<td class="soft">default {escape(str(defaults[name]))}</td></tr>'
        for name in changed
    ]
    top = scroll(f"<table>{''.join(rows)}</table>") if rows else "<p>All as they are by default.</p>"
    rest = "".join(
        f'<tr class="plain"><td>{escape(name)}</td><td class="mono">{escape(str(value))}</td></tr>'
        for name, value in options.items()
        if name not in changed
    )
    rest = scroll(f"<table>{rest}</table>") if rest else ""
    return f"{top}<details><summary>The other options</summary>{rest}</details>" if rest else top


def timings_table(timings: Mapping[str, float]) -> str:
    """Return the seconds of every stage with a bar, and their total."""
    if not timings:
        return ""
    total = sum(timings.values())
    rows = "".join(
        f'<tr><td>{escape(name)}</td><td class="number">{seconds:.1f} s</td><td style="width: 45%">'
        f'<div class="share" style="width: {100 * seconds / max(total, 1e-9):.1f}%"></div></td></tr>'
        for name, seconds in timings.items()
    )
    last = f'<tr><td><b>Total</b></td><td class="number"><b>{total:.1f} s</b></td><td></td></tr>'
    return scroll(f"<table>{rows}{last}</table>")


def versions_table(versions: Mapping[str, object]) -> str:
    """Return software and machine."""
    rows = "".join(
        f'<tr><td>{escape(name)}</td><td class="mono">{escape(str(value))}</td></tr>'
        for name, value in versions.items()
    )
    return scroll(f"<table>{rows}</table>") if rows else ""
