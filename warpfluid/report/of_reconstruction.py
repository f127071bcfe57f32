"""The page of a reconstruction: footage, check, least squares against the result, energies, numbers."""

import dataclasses
import time
from pathlib import Path

import numpy as np

from warpfluid.comparison.comparison import other_moment
from warpfluid.comparison.measure import halfway, mean_numbers, with_left_over
from warpfluid.comparison.motion import motion_against_footage, speeds
from warpfluid.files.sequences import format_frames
from warpfluid.footage.estimate import SHOWN_FRAMES
from warpfluid.footage.inspection import Inspection
from warpfluid.footage.shot import Shot
from warpfluid.footage.sources import spread
from warpfluid.options import InputOptions, OutputOptions, ReconstructOptions
from warpfluid.reconstruction.em import reconstruct
from warpfluid.report import pieces
from warpfluid.report.data import FrameReport, ReportData, SeriesReport
from warpfluid.report.page import write_report
from warpfluid.run import PAGE, Run
from warpfluid.settings import Settings

LSM = "least squares"
NAMES = {"stochastic": "stochastic tomography", "convex": "convex minimum", "flame-sheet": "flame sheet"}


def report_reconstruction(run: Run, shot: Shot, settings: Settings, inspection: Inspection, *, device=None) -> Path:
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
    numbered = spread(shown, pieces.NUMBERED_FRAMES)
    frames = [_frame(run, shot, settings, records, number, number in numbered, device) for number in shown]
    methods = list(frames[0].stills)
    means, floors = pieces.sorted_floors(mean_numbers(frame.metrics for frame in frames), methods)
    means = _with_motion(means, run, shot, settings, tuple(records), methods[-1], device)
    middle = shot.views(shown[len(shown) // 2])
    data = ReportData(
        subtitle=_subtitle(records, shown, inspection),
        inputs=pieces.view_reports([s.footage.source for s in shot.sources], shot.angles_deg, middle.images),
        warnings=inspection.hints,
        check=[
            f"The visual hull fills {inspection.hull_share:.0%} of the box.",
            *(f"Aligned: {view.line()}" for view in inspection.alignments),
            *inspection.notes,
        ],
        check_table=_check_table(shot, inspection, tuple(records), device),
        frames=frames,
        metrics=means,
        metrics_note=pieces.AGAINST,
        yardsticks=floors,
        series=_series(records),
        options=pieces.options_of(settings.input, settings.reconstruct, settings.output),
        defaults=pieces.options_of(InputOptions(), _default_method(inspection), OutputOptions()),
        **pieces.common(run, records, settings.output.look, begin),
    )
    write_report(run.folder / PAGE, data)
    return run.folder / PAGE


def _frame(run: Run, shot: Shot, settings: Settings, records: dict, frame: int, numbered: bool, device) -> FrameReport:
    """Gather the pictures and numbers of a frame; least squares is quick and done again."""
    views, record = shot.views(frame), records[frame]
    volumes = {LSM: reconstruct(views, dataclasses.replace(settings.reconstruct, method="lsm"), device=device).volume}
    if settings.reconstruct.method != "lsm":
        method = settings.reconstruct.method
        volumes[NAMES.get(method, method.replace("-", " "))] = run.volume(frame)
    white = pieces.peak(list(volumes.values())[-1])
    other = other_moment(frame, tuple(records))
    far = shot.views(other).images if other != frame and numbered else None
    lit = (views.images > settings.reconstruct.threshold).any(axis=(1, 2)).all()
    facts = {"far": far, "shoulder": settings.reconstruct.shoulder, "device": device}
    numbers = pieces.footage_numbers(volumes, views.images, views.angles_deg, **facts) if numbered and lit else {}
    return FrameReport(
        number=frame,
        angles_deg=pieces.STILLS_DEG,
        stills=pieces.stills(volumes, settings.output.look),
        slices=pieces.slices(volumes, white),
        slices_white=white,
        energies=np.asarray(record["energies"]) if record["energies"] else None,
        alternates=settings.reconstruct.method == "appearance-transfer",
        metrics=numbers,
        seconds=record["seconds"],
    )


def _with_motion(
    means: dict, run: Run, shot: Shot, settings: Settings, frames: tuple[int, ...], method: str, device
) -> dict:
    """Return the numbers with what motion leaves of the result, over the footage's."""
    if method not in means:
        return means
    unseen = halfway(shot.angles_deg)
    facts = {"shoulder": settings.reconstruct.shoulder, "pairs": pieces.MOTION_PAIRS, "device": device}
    found = motion_against_footage({method: run.volume}, lambda f: shot.views(f).images, frames, unseen, **facts)
    return with_left_over(means, found)


def _series(records: dict[int, dict]) -> list[SeriesReport]:
    """Return the numbers over the frames."""

    def curve(value) -> dict[int, float]:
        return {frame: value(record) for frame, record in records.items()}

    energies = {"": curve(lambda r: r["energies"][-1][-1] / 1e6 if r["energies"] else np.nan)}
    return [
        SeriesReport(
            title="How exactly the inputs come back", values={"": curve(lambda r: min(r["input_psnr"]))}, unit=" dB"
        ),
        SeriesReport(title="Energy at the end", values=energies, unit=" million"),
        SeriesReport(title="Total density", values={"": curve(lambda r: r["total"] / 1e3)}, unit=" thousand"),
        SeriesReport(title="Time a frame took", values={"": curve(lambda r: r["seconds"])}, unit=" s"),
    ]


def _subtitle(records: dict[int, dict], shown: list[int], inspection: Inspection) -> str:
    lacking = inspection.frame_count - len(records)
    frames = f"{format_frames(records)}, {len(records)} of {inspection.frame_count}" if lacking else inspection.frames
    width, height, depth = inspection.volume_size
    return pieces.headline(tuple(records), frames, shown, (width, depth, height))


def _check_table(shot: Shot, inspection: Inspection, frames: tuple[int, ...], device) -> list[dict[str, object]]:
    """Return what the check found of every view, a row each, with how fast its picture moves."""
    apart = {pair.angle_deg: f"{pair.remedy.disagreement:.1%}" for pair in inspection.pairs}
    rows = []
    for i, view in enumerate(inspection.views):
        speed = speeds(
            lambda frame, i=i: shot.views(frame).images[i : i + 1], frames, pairs=pieces.MOTION_PAIRS, device=device
        )
        rows.append(
            {
                "view": f"{view.angle_deg:g}°",
                "footage": f"{' x '.join(map(str, view.footage_size))}, {view.depth}",
                "frames": view.frames,
                "grey levels": f"{view.darkest:.0f} to {view.brightest:.0f}",
                "background": f"{view.background:.0f}",
                "saturated": f"{view.saturated:.1%}",
                "rows differ by": apart.get(view.angle_deg, "–"),
                "moves [px/frame]": f"{speed['median']:.1f}, fastest {speed['fast']:.1f}" if speed else "–",
            }
        )
    return rows


def _default_method(inspection: Inspection) -> ReconstructOptions:
    """Return what the method would be for this footage if nobody chose anything."""
    view = inspection.views[0]
    return ReconstructOptions().settled(views=len(inspection.views), width=view.size[0], bright=view.bright)
