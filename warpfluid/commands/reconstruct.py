"""Reconstruct a shot."""

import dataclasses
from pathlib import Path

from warpfluid.cluster.pools import Asked, reach
from warpfluid.commands.footage import make_folder
from warpfluid.commands.frames import Work, check_footage, reconstruct_frames
from warpfluid.errors import Problems
from warpfluid.files.sequences import format_frames
from warpfluid.footage.estimate import check_cost
from warpfluid.footage.inspection import Inspection, inspect_shot
from warpfluid.footage.shot import Shot, open_shot
from warpfluid.outcome import conclude, do_all
from warpfluid.progress import Progress
from warpfluid.run import FILM, PAGE, Run
from warpfluid.settings import Settings


def reconstruct(
    settings: Settings,
    out: Path,
    *,
    resume: bool,
    overwrite: bool,
    common,
    debug_dir: Path | None = None,
    jobs: str = "1",
    cluster: str | None = None,
) -> int:
    """Reconstruct a shot into a folder, and every iteration's pictures into another; return the exit code."""
    from warpfluid.device import pick_device
    from warpfluid.reconstruction.pieces import first_picture

    if cluster:  # whose workers are in other folders
        settings = dataclasses.replace(settings, views=tuple(settings.to_dict()["views"]))
        out, debug_dir = out.absolute(), debug_dir and debug_dir.absolute()
    log, run, problems = Progress(quiet=common.quiet, verbose=common.verbose), Run(out), Problems()
    problems.attempt(lambda: run.check_free(resume=resume, overwrite=overwrite))
    asked = problems.attempt(lambda: Asked(jobs=jobs, device=common.device, cluster=cluster))
    device = problems.attempt(pick_device, common.device)
    shoulder = settings.reconstruct.shoulder or 0.0
    shot = problems.attempt(lambda: open_shot(settings.views, settings.input, shoulder, keep=True))
    problems.raise_if_any()
    if debug_dir:
        make_folder(debug_dir, "--debug-dir")
    _check_lengths(shot, settings)
    inspection = inspect_shot(shot, settings.reconstruct)
    check_cost(shot.size, inspection.hull_share, inspection.options, device)
    footage = dataclasses.replace(shot.options, white=shot.white or settings.input.white)
    settings = dataclasses.replace(settings, input=footage, reconstruct=inspection.options)
    if resume:
        check_footage(run, shot, settings)
    with reach(asked, need=inspection.memory_bytes, folder=run.folder, say=log.line) as crew:
        noted = {"frames": format_frames(shot.frames), "first": first_picture(shot), "inputs": shot.background_hashes()}
        facts = {"device": str(device), **noted}
        done = run.begin(settings, facts, resume=resume, overwrite=overwrite)
        for line in inspection.lines():
            log.line(line)
        facts = {"need": inspection.memory_bytes, "debug_dir": debug_dir}
        work = Work(run=run, shot=shot, settings=settings, records=done, **facts)
        reconstruct_frames(work, crew, device, log)
    failed = work.failed | _summarize(run, shot, settings, inspection, device, log)
    return conclude(run, shot.frames, failed, as_json=common.json)


def _check_lengths(shot: Shot, settings: Settings) -> None:
    """Refuse footage of unequal length, unless the frames were chosen or the times given or found."""
    spans = {(source.frames[0], source.frames[-1]) for source in shot.sources}
    if len(spans) > 1 and settings.input.frames is None and shot.options.view_time is None:
        found = ", ".join(f"{source.name} has {format_frames(source.frames)}" for source in shot.sources)
        way_out = f"--frames {format_frames(shot.frames)} uses what all of them have"
        raise ValueError(f"the views have unequal frames ({found}): {way_out}")


def _summarize(
    run: Run, shot: Shot, settings: Settings, inspection: Inspection, device, log: Progress
) -> dict[str, str]:
    """Write the turntable and the report of what is finished; return what failed."""
    from warpfluid.report.film import write_film
    from warpfluid.report.of_reconstruction import report_reconstruction

    jobs = {}
    if settings.output.turntable:
        jobs[FILM] = lambda: write_film(run, settings.output.look, run.folder / FILM)
    if settings.output.report:
        jobs[PAGE] = lambda: report_reconstruction(run, shot, settings, inspection, device=device)
    go_on = f"warpfluid reconstruct -o {run.folder} --resume"
    return do_all(jobs if set(run.records()) & set(shot.frames) else {}, log, go_on)
