"""The page of a simulation: what it follows, what came out, steps, light, motion, what stands in the box."""

import dataclasses
import time
from pathlib import Path

import numpy as np

from warpfluid.comparison.comparison import other_moment
from warpfluid.comparison.measure import halfway, mean_numbers, with_left_over
from warpfluid.comparison.motion import motion_against_footage
from warpfluid.errors import describe
from warpfluid.footage.estimate import SHOWN_FRAMES
from warpfluid.footage.origin import Footage, find_footage
from warpfluid.footage.sources import spread
from warpfluid.options import SimulateOptions
from warpfluid.projector import Projector
from warpfluid.rendering.turntable import render_turntable
from warpfluid.report import pieces
from warpfluid.report.course import OURS, SOURCE, check, course, departure, speeds, warnings
from warpfluid.report.data import FrameReport, InputReport, ReportData
from warpfluid.report.fields import field_pictures
from warpfluid.report.film import surfaces_in
from warpfluid.report.page import write_report
from warpfluid.report.scene import body_rows, scene_rows
from warpfluid.run import PAGE, Run
from warpfluid.settings import SimulateSettings
from warpfluid.simulation.animation import is_edited
from warpfluid.simulation.outlines import Outlines
from warpfluid.simulation.source import Source
from warpfluid.volumes import VolumeSequence, open_volumes

EDITED = " An edit is not meant to be the footage, so no number is marked as the best."


@dataclasses.dataclass(frozen=True, kw_only=True)
class _Simulated:
    """A run with all that the page needs of it."""

    run: Run
    settings: SimulateSettings
    source: Source
    volumes: VolumeSequence
    footage: Footage | None
    records: dict[int, dict]
    device: object

    def volume(self, frame: int) -> np.ndarray:
        """Return a volume in grey levels."""
        return self.run.volume(frame) * np.float32(self.source.volumes.scale)

    def both(self, frame: int) -> dict[str, np.ndarray]:
        """Return what a frame follows, if there is such, and what came out."""
        followed = {SOURCE: self.source.volume(frame)} if frame in self.source.frames else {}
        return followed | {OURS: self.volume(frame)}

    def images(self, frame: int) -> np.ndarray | None:
        """Return the footage of a frame, if there is any."""
        return self.footage.images(frame) if self.footage else None


def report_simulation(run: Run, settings: SimulateSettings, source: Source, *, device=None) -> Path:
    """Write the page of a run.

    Args:
        run: A run with at least one frame.
        settings: Its settings.
        source: What it follows, or an empty box.
        device: Where to compute.

    Returns:
        The page, ``report.html`` in the run's folder.
    """
    begin = time.perf_counter()
    footage, missing = _footage(run, source)
    edited = is_edited(settings.simulate, settings.scene)
    facts = {"run": run, "settings": settings, "source": source, "footage": footage, "device": device}
    made = _Simulated(volumes=open_volumes(run.folder), records=run.records(), **facts)
    shown = spread(tuple(made.records), SHOWN_FRAMES)
    numbered = spread(shown, pieces.NUMBERED_FRAMES)
    pages = [_frame(made, frame, frame in numbered) for frame in shown]
    means, floors = pieces.sorted_floors(mean_numbers(page.metrics for page in pages), [SOURCE, OURS])
    data = ReportData(
        subtitle=f"Simulation. {pieces.headline(tuple(made.records), '', shown, source.shape)}",
        origin="Footage" if footage else "Source",
        inputs=_inputs(made, shown[len(shown) // 2]),
        warnings=[*missing, *warnings(made.records, settings.simulate)],
        check=[*check(made.records, source), *departure(made.records, settings)],
        frames=pages,
        metrics=_with_motion(made, means),
        metrics_note=pieces.AGAINST + EDITED * edited,
        ranked=not edited,
        yardsticks=floors,
        series=[*course(made.records, source), *speeds(made.volumes, shown, settings.simulate.fps)],
        facts=_facts(made),
        options=pieces.options_of(settings.simulate, settings.output),
        defaults=pieces.options_of(SimulateOptions(), source.volumes.output),
        **pieces.common(run, made.records, settings.output.look, begin, source.volumes.scale),
    )
    write_report(run.folder / PAGE, data)
    return run.folder / PAGE


def _footage(run: Run, source: Source) -> tuple[Footage | None, list[str]]:
    """Return the footage that the run goes back to, if it is still there and fits, and what to say about it."""
    try:
        footage = find_footage(run.settings())
    except (ValueError, OSError) as error:
        return None, [f"The footage is not to be had, so nothing is compared with it: {describe(error)}"]
    width, height = source.shape[0], source.shape[2]
    if footage and footage.shot.size != (width, height):
        return None, [f"Nothing is compared with the footage: the simulation has another size, {width} x {height}."]
    return footage, []


def _frame(made: _Simulated, frame: int, numbered: bool) -> FrameReport:
    """Gather the pictures and numbers of a frame."""
    volumes = made.both(frame)
    white = pieces.peak(next(iter(volumes.values())))
    return FrameReport(
        number=frame,
        angles_deg=pieces.STILLS_DEG,
        stills=pieces.stills(volumes, made.settings.output.look) | _stills(made, frame, volumes[OURS]),
        slices=pieces.slices(volumes, white),
        slices_white=white,
        fields=field_pictures(made.volumes, frame, made.settings.simulate.fps),
        metrics=_numbers(made, frame, volumes) if numbered else {},
        seconds=made.records[frame]["seconds"],
    )


def _stills(made: _Simulated, frame: int, volume: np.ndarray) -> dict[str, np.ndarray]:
    """Return pictures with what stands in the box."""
    surfaces = surfaces_in(Outlines(made.run), frame, volume.shape)
    look = made.settings.output.look
    return {OURS: render_turntable(volume, pieces.STILLS_DEG, look, surfaces=surfaces)} if surfaces else {}


def _numbers(made: _Simulated, frame: int, volumes: dict[str, np.ndarray]) -> dict:
    """Compare a frame with the footage; nothing if there is none."""
    images = made.images(frame)
    if images is None:
        return {}
    other = other_moment(frame, tuple(made.records))
    far = made.images(other) if other != frame else None
    facts = {"far": far, "shoulder": made.footage.shoulder, "device": made.device}
    return pieces.footage_numbers(volumes, images, made.footage.angles_deg, **facts)


def _with_motion(made: _Simulated, means: dict) -> dict:
    """Return the numbers with what motion leaves over."""
    if OURS not in means:
        return means
    frames = tuple(made.records)
    volumes = {OURS: made.volume}
    if set(frames) <= set(made.source.frames):
        volumes[SOURCE] = made.source.volume
    facts = {"shoulder": made.footage.shoulder, "pairs": pieces.MOTION_PAIRS, "device": made.device}
    unseen = halfway(made.footage.angles_deg)
    found = motion_against_footage(volumes, made.images, frames, unseen, **facts)
    return with_left_over(means, found)


def _inputs(made: _Simulated, frame: int) -> list[InputReport]:
    """Return the footage, or else the source from its views; nothing of an empty box."""
    images = made.images(frame)
    if images is not None:
        names = [source.footage.source for source in made.footage.shot.sources]
        return pieces.view_reports(names, made.footage.angles_deg, images)
    if frame not in made.source.frames:
        return []
    angles = made.source.volumes.angles_deg
    images = Projector(angles, made.source.shape, device=made.device).project(made.source.volume(frame))
    return pieces.view_reports([made.source.volumes.name] * len(angles), angles, images)


def _facts(made: _Simulated) -> dict[str, list[dict[str, object]]]:
    """Return what stands in the box, and where the bodies went."""
    found = {"Scene": scene_rows(made.settings.scene), "Rigid bodies": body_rows(made.run, made.settings.scene.body)}
    return {title: rows for title, rows in found.items() if rows}
