"""One HTML page a run: pictures, energy, input check.

The page is a single file without scripts that needs no network: pictures are embedded, the layout follows the
reader's light or dark setting. It knows nothing of runs and files; whoever has a run fills in ``ReportData``.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template

import numpy as np

from warpfluid.metrics import METRICS
from warpfluid.report.html import (
    cell,
    colour_bar,
    energy_chart,
    film,
    image,
    scroll,
    section,
    shortened,
    side_by_side,
    table,
)

AIMS = {"low": "↓", "high": "↑", "one": "→ 1"}


@dataclass(frozen=True, kw_only=True, eq=False)
class InputReport:
    """One input view.

    Attributes:
        name: Where it came from.
        angle_deg: Where its camera stood.
        picture: A frame of it, uint8, shape (rows, columns) or (rows, columns, 3).
    """

    name: str
    angle_deg: float
    picture: np.ndarray


@dataclass(frozen=True, kw_only=True, eq=False)
class FrameReport:
    """One frame: the methods side by side.

    Attributes:
        number: Frame number as in the footage.
        angles_deg: Angles of the stills.
        stills: Pictures of every method, by its name, uint8, shape (angle, rows, columns[, 3]).
        slices: Horizontal slices of every method, by its name, one uint8 picture each.
        slices_white: Density at the end of the slices' colour bar; None leaves the bar out.
        energies: Energy (Eq. 1) after the M-step and after the E-step, shape (iteration, 2).
        metrics: Numbers of every method, by its name and the metric's.
        seconds: Time the frame took.
    """

    number: int
    angles_deg: Sequence[float]
    stills: Mapping[str, np.ndarray]
    slices: Mapping[str, np.ndarray] = field(default_factory=dict)
    slices_white: float | None = None
    energies: np.ndarray | None = None
    metrics: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    seconds: float | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class ReportData:
    """All that a page shows.

    Attributes:
        title: Heading.
        subtitle: One line below it, or a few.
        inputs: The input views.
        warnings: Lines the reader should not miss.
        check: Lines of the input check.
        check_table: Its numbers, rows of the same columns.
        frames: Some frames, about six at most for a page that opens quickly.
        metrics: Means over all frames, as in a frame.
        yardsticks: Names in the metrics that are no methods, such as a true view from nearby.
        turntable: Film of the result, uint8, shape (picture, rows, columns, 3).
        rate: Its pictures a second.
        options: Every option of the run.
        defaults: What they are if nobody chooses; those that differ stand out.
        versions: Software and machine.
        timings: Seconds, by stage.
    """

    title: str
    subtitle: str = ""
    inputs: Sequence[InputReport] = ()
    warnings: Sequence[str] = ()
    check: Sequence[str] = ()
    check_table: Sequence[Mapping[str, object]] = ()
    frames: Sequence[FrameReport] = ()
    metrics: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    yardsticks: Sequence[str] = ()
    turntable: np.ndarray | None = None
    rate: float = 24.0
    options: Mapping[str, object] = field(default_factory=dict)
    defaults: Mapping[str, object] = field(default_factory=dict)
    versions: Mapping[str, object] = field(default_factory=dict)
    timings: Mapping[str, float] = field(default_factory=dict)


def write_report(path: str | Path, report: ReportData) -> None:
    """Write a run's page.

    Args:
        path: The HTML file to write or to replace.
        report: What to show.

    Raises:
        ValueError: If a picture is not uint8, grey or RGB, or a frame has not one still an angle.
        OSError: If the file cannot be written.
    """
    from warpfluid.files.atomic import replacing

    page = html_report(report).encode()
    with replacing(path) as file:
        file.write(page)


def html_report(report: ReportData) -> str:
    """Return the page of ``write_report`` as text."""
    angles = {image.angle_deg for image in report.inputs}
    body = [
        "".join(f'<p class="warning">{escape(line)}</p>' for line in report.warnings),
        _inputs(report),
        section("Quality, mean over the frames", _metrics(report.metrics, report.yardsticks)),
        *(_frame(frame, angles, report.yardsticks) for frame in report.frames),
        section("Options", _options(report.options, report.defaults)),
        section("Time and versions", side_by_side(_timings(report.timings), _versions(report.versions))),
    ]
    template = Template(files("warpfluid").joinpath("report/template.html").read_text("utf-8"))
    return template.substitute(
        title=escape(report.title), subtitle=escape(report.subtitle), body="\n".join(filter(None, body))
    )


def _inputs(report: ReportData) -> str:
    """Return the input views and their check beside the turning result."""
    pictures = "".join(
        f"<figure>{image(view.picture, f'input at {view.angle_deg:g}°')}"
        f"<figcaption><b>{view.angle_deg:g}°</b> {shortened(view.name)}</figcaption></figure>"
        for view in report.inputs
    )
    check = "".join(f"<p>{escape(line)}</p>" for line in report.check) + table(report.check_table)
    left = f'<div class="inputs">{pictures}</div>' if pictures else ""
    left += f"<h3>Input check</h3>{check}" if check else ""
    turning = ""
    if report.turntable is not None:
        turning = film(report.turntable, report.rate, "turntable of the result")
        turning = f'<figure class="turn">{turning}<figcaption>The result, all around</figcaption></figure>'
    return section("Inputs", side_by_side(f"<div>{left}</div>" if left else "", turning))


def _frame(frame: FrameReport, input_angles: set[float], yardsticks: Sequence[str]) -> str:
    """Return a frame: stills, slices, numbers, energy."""
    parts = [_stills(frame, input_angles)]
    slices = "".join(
        f'<figure class="slices">{image(picture, f"horizontal slices, {name}", "pixels")}'
        f"<figcaption><b>{escape(name)}</b></figcaption></figure>"
        for name, picture in frame.slices.items()
    )
    if slices:
        bar = colour_bar(frame.slices_white) if frame.slices_white is not None else ""
        title = "<h3>Horizontal slices, from above: front at the bottom, low to high</h3>"
        parts.append(f'{title}<div class="side">{slices}</div>{bar}')
    curve = "" if frame.energies is None else energy_chart(frame.energies)
    curve = f"<div><h3>Energy</h3>{curve}</div>" if curve else ""
    numbers = _metrics(frame.metrics, yardsticks)
    parts.append(side_by_side(f'<div class="wide"><h3>Quality</h3>{numbers}</div>' if numbers else "", curve))
    seconds = "" if frame.seconds is None else f' <span class="soft">{frame.seconds:.1f} s</span>'
    return f'<h2>Frame {frame.number}{seconds}</h2><div class="card">{"".join(parts)}</div>'


def _stills(frame: FrameReport, input_angles: set[float]) -> str:
    """Return a row of stills a method, and below them the angles."""
    cells = []
    for name, pictures in frame.stills.items():
        if len(pictures) != len(frame.angles_deg):
            raise ValueError(
                f"frame {frame.number}: {name} has {len(pictures)} stills for {len(frame.angles_deg)} angles"
            )
        cells.append(f'<div class="row">{escape(name)}</div>')
        cells += [image(p, f"{name} at {angle:g}°") for p, angle in zip(pictures, frame.angles_deg, strict=True)]
    cells.append("<div></div>")
    for angle in frame.angles_deg:
        label = f"{angle:g}°" + (" <b>input</b>" if angle in input_angles else "")
        cells.append(f'<div class="angle">{label}</div>')
    columns = f"grid-template-columns: minmax(56px, max-content) repeat({len(frame.angles_deg)}, minmax(0, 1fr))"
    return scroll(f'<div class="stills" style="{columns}">{"".join(cells)}</div>')


def _metrics(methods: Mapping[str, Mapping[str, float]], yardsticks: Sequence[str]) -> str:
    """Return the table of metrics against methods, the best number of a row marked."""
    rows = []
    for metric in METRICS.values():
        values = {name: numbers[metric.name] for name, numbers in methods.items() if metric.name in numbers}
        if not values:
            continue
        rivals = [name for name in values if name not in yardsticks and metric.ranks]
        best = min(rivals, key=lambda name: metric.badness(values[name])) if len(rivals) > 1 else None
        cells = "".join(
            f'<td class="number{" best" if name == best else ""}">{cell(values.get(name))}</td>' for name in methods
        )
        mark = "" if metric.ranks else "*"
        rows.append(
            f"<tr><td>{escape(metric.label)}{mark} <small>{escape(metric.meaning)}</small></td>"
            f'<td class="aim">{AIMS[metric.best]}</td>{cells}</tr>'
        )
    if not rows:
        return ""
    heads = "".join(f'<th class="number">{escape(name)}</th>' for name in methods)
    note = '<p class="note">* nothing to rank by: matched by the method itself, or better for a blur</p>'
    return scroll(f"<table><tr><th></th><th></th>{heads}</tr>{''.join(rows)}</table>") + note


def _options(options: Mapping[str, object], defaults: Mapping[str, object]) -> str:
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


def _timings(timings: Mapping[str, float]) -> str:
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


def _versions(versions: Mapping[str, object]) -> str:
    """Return software and machine."""
    rows = "".join(
        f'<tr><td>{escape(name)}</td><td class="mono">{escape(str(value))}</td></tr>'
        for name, value in versions.items()
    )
    return scroll(f"<table>{rows}</table>") if rows else ""
