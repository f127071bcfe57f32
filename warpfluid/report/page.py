"""One HTML page a run: pictures, numbers, what it was made of and with.

The page is a single file without scripts that needs no network: pictures are embedded, the layout follows the
reader's light or dark setting. It knows nothing of runs and files; whoever has a run fills in ``ReportData``.
"""

from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template

from warpfluid.report.charts import energy_chart, series_chart
from warpfluid.report.data import FrameReport, ReportData
from warpfluid.report.html import colour_bar, film, image, scroll, section, shortened, side_by_side, table
from warpfluid.report.tables import metrics_table, options_table, timings_table, versions_table

FEWEST_ITERATIONS = 2  # of an energy that is worth a curve


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
        section("Quality, mean over some frames", _quality(report)),
        section("Over the frames", _series(report)),
        *(section(title, table(rows)) for title, rows in report.facts.items()),
        *(_frame(frame, angles, report) for frame in report.frames),
        section("Options", options_table(report.options, report.defaults)),
        section("Time and versions", side_by_side(timings_table(report.timings), versions_table(report.versions))),
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
    left += f"<h3>Check</h3>{check}" if check else ""
    turning = ""
    if report.turntable is not None:
        turning = film(report.turntable, report.rate, "turntable of the result")
        turning = f'<figure class="turn">{turning}<figcaption>The result, all around</figcaption></figure>'
    return section(report.origin, side_by_side(f"<div>{left}</div>" if left else "", turning))


def _quality(report: ReportData) -> str:
    """Return the means with what they are measured against."""
    note = f'<p class="note">{escape(report.metrics_note)}</p>' if report.metrics_note else ""
    numbers = metrics_table(report.metrics, report.yardsticks, ranked=report.ranked)
    return numbers + note if numbers else ""


def _series(report: ReportData) -> str:
    """Return the curves over the frames."""
    charts = [(s.title, series_chart(s.values, f"{s.title} by frame", unit=s.unit)) for s in report.series]
    cells = (f"<div><h3>{escape(title)}</h3>{chart}</div>" for title, chart in charts if chart)
    content = "".join(cells)
    return f'<div class="charts">{content}</div>' if content else ""


def _frame(frame: FrameReport, input_angles: set[float], report: ReportData) -> str:
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
    fields = "".join(
        f"<figure>{image(picture, words, 'pixels')}<figcaption>{escape(words)}</figcaption></figure>"
        for words, picture in frame.fields.items()
    )
    if fields:
        title = "<h3>Other fields, cut open where there is most fluid, seen from the front</h3>"
        parts.append(f'{title}<div class="fields">{fields}</div>')
    drawn = frame.energies is not None and len(frame.energies) >= FEWEST_ITERATIONS
    curve = f"<div><h3>Energy</h3>{energy_chart(frame.energies, alternates=frame.alternates)}</div>" if drawn else ""
    numbers = metrics_table(frame.metrics, report.yardsticks, ranked=report.ranked, explained=False)
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
