"""What a finished run shows: a turntable, and a page with pictures, energies and numbers."""

import dataclasses
import time
from itertools import pairwise
from pathlib import Path

import numpy as np

from warpfluid.files.sequences import format_frames
from warpfluid.footage.estimate import SHOWN_FRAMES
from warpfluid.footage.inspection import Inspection
from warpfluid.footage.shot import Shot
from warpfluid.footage.sources import spread
from warpfluid.kernels.launch import thread_count
from warpfluid.metrics import SMALLEST_SIDE, appearance_distance
from warpfluid.options import InputOptions, OutputOptions, ReconstructOptions
from warpfluid.reconstruction.em import reconstruct
from warpfluid.reconstruction.inputs import apply_shoulder
from warpfluid.rendering.ramps import apply_ramp
from warpfluid.rendering.turntable import render_turntable, slices_picture
from warpfluid.report.film import RATE, TURN_PICTURES, film_pictures
from warpfluid.report.page import FrameReport, InputReport, ReportData, write_report
from warpfluid.run import Run, versions
from warpfluid.settings import Settings
from warpfluid.views import Views

STILLS_DEG = tuple(range(0, 91, 15))
SLICES = 6
FILM_IN_PAGE = 60  # pictures of the film that the page carries
LSM, OURS = "least squares", "appearance transfer"


def report_run(run: Run, shot: Shot, settings: Settings, inspection: Inspection, *, device=None) -> Path:
    """Write the page of a run.

    Args:
        run: A run with at least one frame of the shot.
        shot: Its footage.
        settings: Its settings, all choices made.
        inspection: What the check of the footage found.
        device: Where to compute the volumes of least squares.

    Returns:
        The page, ``report.html`` in the run's folder.
    """
    begin = time.perf_counter()
    records = {frame: record for frame, record in run.records().items() if frame in shot.frames}
    shown = spread(tuple(records), SHOWN_FRAMES)
    frames = [_frame(run, shot, settings, records[number], device) for number in shown]
    film = np.stack(list(film_pictures(run, settings.output.look, FILM_IN_PAGE)))
    took = sum(record["seconds"] for record in records.values())
    data = ReportData(
        title=run.folder.resolve().name,
        subtitle=_subtitle(records, shown, inspection),
        inputs=_inputs(shot, shown[len(shown) // 2]),
        warnings=inspection.hints,
        check=_sentences(inspection),
        check_table=_check_table(inspection),
        frames=frames,
        metrics=_means(frames),
        turntable=film[:, :: _step(film), :: _step(film)],
        rate=RATE * FILM_IN_PAGE / TURN_PICTURES,
        options=_options(settings.input, settings.reconstruct, settings.output),
        defaults=_options(InputOptions(), _default_method(inspection), OutputOptions()),
        versions={**versions(), "CPU threads": thread_count(), "device": run.settings()["made-with"].get("device", "")},
        timings={"frames": took, "this page": time.perf_counter() - begin},
    )
    path = run.folder / "report.html"
    write_report(path, data)
    return path


def _frame(run: Run, shot: Shot, settings: Settings, record: dict, device) -> FrameReport:
    """Gather the pictures and numbers of a frame; least squares is quick and done again."""
    views = shot.views(record["frame"])
    least_squares = dataclasses.replace(settings.reconstruct, method="lsm")
    volumes = {LSM: reconstruct(views, least_squares, device=device).volume}
    if settings.reconstruct.method != "lsm":
        volumes[OURS] = run.volume(record["frame"])
    ours = volumes[OURS if OURS in volumes else LSM]
    heights = np.linspace(0.1, 0.9, SLICES) * (ours.shape[2] - 1)
    peak = float(np.quantile(ours[ours > 0], 0.999)) if (ours > 0).any() else 1.0
    look = settings.output.look
    return FrameReport(
        number=record["frame"],
        angles_deg=STILLS_DEG,
        stills={name: render_turntable(v, STILLS_DEG, look) for name, v in volumes.items()},
        slices={name: slices_picture(v, heights.astype(int), white=peak) for name, v in volumes.items()},
        slices_white=peak,
        energies=np.asarray(record["energies"]) if record["energies"] else None,
        metrics=_numbers(volumes, views, settings.reconstruct),
        seconds=record["seconds"],
    )


def _numbers(volumes: dict, views: Views, options: ReconstructOptions) -> dict[str, dict[str, float]]:
    """Compare every method with the inputs, half-way between them, as distributions: there is no truth."""
    from warpfluid.projector import Projector

    if min(views.size) < SMALLEST_SIDE or not (views.images > options.threshold).any(axis=(1, 2)).all():
        return {}
    angles = sorted(angle % 180 for angle in views.angles_deg)
    angles = [*angles, angles[0] + 180]
    unseen = [(a + b) / 2 for a, b in pairwise(angles)]
    references = [image.T[::-1] for image in views.images]
    numbers = {}
    for name, volume in volumes.items():
        pictures = apply_shoulder(Projector(unseen, volume.shape).project(volume), options.shoulder)
        rows = [appearance_distance(picture.T[::-1], references) for picture in pictures if picture.max() > 0]
        if rows:
            numbers[name] = {key: float(np.mean([row[key] for row in rows])) for key in rows[0]}
    return numbers


def _inputs(shot: Shot, frame: int) -> list[InputReport]:
    views = shot.views(frame)
    pictures = apply_ramp(views.images.transpose(0, 2, 1)[:, ::-1], "gray")
    rows = zip(shot.sources, pictures, strict=True)
    return [InputReport(name=s.footage.source, angle_deg=s.angle_deg, picture=picture) for s, picture in rows]


def _means(frames: list[FrameReport]) -> dict[str, dict[str, float]]:
    """Return the mean of every number over the frames shown."""
    totals: dict[str, dict[str, list[float]]] = {}
    for frame in frames:
        for method, numbers in frame.metrics.items():
            for key, value in numbers.items():
                totals.setdefault(method, {}).setdefault(key, []).append(value)
    return {method: {key: float(np.mean(v)) for key, v in numbers.items()} for method, numbers in totals.items()}


def _subtitle(records: dict[int, dict], shown: list[int], inspection: Inspection) -> str:
    lacking = inspection.frame_count - len(records)
    frames = f"{format_frames(records)}, {len(records)} of {inspection.frame_count}" if lacking else inspection.frames
    x, y, z = inspection.volume_size
    below = f"\nShown: {', '.join(map(str, shown))}" if len(shown) < len(records) else ""
    return f"Frames {frames}; {x} x {y} x {z} voxels (width, height, depth){below}"


def _sentences(inspection: Inspection) -> list[str]:
    """Return what the check of the footage says of all views together."""
    return [f"The visual hull fills {inspection.hull_share:.0%} of the box.", *inspection.notes]


def _check_table(inspection: Inspection) -> list[dict[str, object]]:
    """Return what the check found of every view, a row each."""
    apart = {pair.angle_deg: f"{pair.remedy.disagreement:.1%}" for pair in inspection.pairs}
    return [
        {
            "view": f"{view.angle_deg:g}°",
            "footage": f"{' x '.join(map(str, view.footage_size))}, {view.depth}",
            "frames": view.frames,
            "grey levels": f"{view.darkest:.0f} to {view.brightest:.0f}",
            "background": f"{view.background:.0f}",
            "saturated": f"{view.saturated:.1%}",
            "rows differ by": apart.get(view.angle_deg, "–"),
        }
        for view in inspection.views
    ]


def _default_method(inspection: Inspection) -> ReconstructOptions:
    """Return what the method would be for this footage if nobody chose anything."""
    view = inspection.views[0]
    return ReconstructOptions().settled(views=len(inspection.views), width=view.size[0], bright=view.bright)


def _options(*parts) -> dict[str, object]:
    """Return all options in one table, named as the flags are; None is a choice left to the footage."""
    merged = {key: value for part in parts for key, value in dataclasses.asdict(part).items()}
    return {key.replace("_", "-"): "auto" if value is None else value for key, value in merged.items()}


def _step(film: np.ndarray) -> int:
    """Return by how much the film is thinned so that the page stays light."""
    return max(1, film.shape[2] // 320)
