"""What a report's page shows; whoever has a run fills it in."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np


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
        fields: Pictures of other fields by what they show, one uint8 picture each.
        energies: Energy (Eq. 1) after the M-step and after the E-step, shape (iteration, 2).
        alternates: If not, the energies are those before and after each round of another method.
        metrics: Numbers of every method, by its name and the metric's.
        seconds: Time the frame took.
    """

    number: int
    angles_deg: Sequence[float]
    stills: Mapping[str, np.ndarray]
    slices: Mapping[str, np.ndarray] = field(default_factory=dict)
    slices_white: float | None = None
    fields: Mapping[str, np.ndarray] = field(default_factory=dict)
    energies: np.ndarray | None = None
    alternates: bool = True
    metrics: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    seconds: float | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class SeriesReport:
    """A number over the frames.

    Attributes:
        title: What it is.
        values: By frame, by the name of the curve; up to three.
        unit: Behind the numbers.
    """

    title: str
    values: Mapping[str, Mapping[int, float]]
    unit: str = ""


@dataclass(frozen=True, kw_only=True, eq=False)
class ReportData:
    """All that a page shows.

    Attributes:
        title: Heading.
        subtitle: One line below it, or a few.
        origin: Where ``inputs`` come from, a heading.
        inputs: The input views.
        warnings: Lines the reader should not miss.
        check: Lines of the input check.
        check_table: Its numbers, rows of the same columns.
        frames: Some frames, about six at most for a page that opens quickly.
        metrics: Means over all frames, as in a frame.
        metrics_note: What they are measured against.
        ranked: Mark the best numbers.
        yardsticks: Names in the metrics that are no methods but floors; distances are told as multiples of the first.
        series: Numbers over the frames.
        facts: Tables by heading, rows of the same columns.
        turntable: Film of the result, uint8, shape (picture, rows, columns, 3).
        rate: Its pictures a second.
        options: Every option of the run.
        defaults: What they are if nobody chooses; those that differ stand out.
        versions: Software and machine.
        timings: Seconds, by stage.
    """

    title: str
    subtitle: str = ""
    origin: str = "Inputs"
    inputs: Sequence[InputReport] = ()
    warnings: Sequence[str] = ()
    check: Sequence[str] = ()
    check_table: Sequence[Mapping[str, object]] = ()
    frames: Sequence[FrameReport] = ()
    metrics: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    metrics_note: str = ""
    ranked: bool = True
    yardsticks: Sequence[str] = ()
    series: Sequence[SeriesReport] = ()
    facts: Mapping[str, Sequence[Mapping[str, object]]] = field(default_factory=dict)
    turntable: np.ndarray | None = None
    rate: float = 24.0
    options: Mapping[str, object] = field(default_factory=dict)
    defaults: Mapping[str, object] = field(default_factory=dict)
    versions: Mapping[str, object] = field(default_factory=dict)
    timings: Mapping[str, float] = field(default_factory=dict)
