"""What the commands do, once their flags are read."""

import dataclasses
import json
from pathlib import Path

from warpfluid.cluster.pools import Asked, reach
from warpfluid.errors import Problems
from warpfluid.files.sequences import format_frames
from warpfluid.footage.estimate import check_cost
from warpfluid.footage.inspection import Inspection, inspect_shot, write_views_picture
from warpfluid.footage.shot import Shot, open_shot
from warpfluid.outcome import conclude, do_all
from warpfluid.progress import Progress
from warpfluid.reconstructing import Work, check_footage, reconstruct_frames
from warpfluid.run import FILM, PAGE, Run
from warpfluid.settings import Settings, make_settings


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
        _make_folder(debug_dir, "--debug-dir")
    _check_lengths(shot, settings)
    inspection = inspect_shot(shot, settings.reconstruct)
    check_cost(shot.size, inspection.hull_share, inspection.options, device)
    footage = dataclasses.replace(shot.options, white=shot.white or settings.input.white)
    settings = dataclasses.replace(settings, input=footage, reconstruct=inspection.options)
    if resume:
        check_footage(run, shot, settings)
    with reach(asked, need=inspection.memory_bytes, folder=run.folder, say=log.line) as crew:
        facts = {"device": str(device), "inputs": shot.background_hashes()}
        done = run.begin(settings, facts, resume=resume, overwrite=overwrite)
        for line in inspection.lines():
            log.line(line)
        facts = {"need": inspection.memory_bytes, "debug_dir": debug_dir}
        work = Work(run=run, shot=shot, settings=settings, records=done, **facts)
        reconstruct_frames(work, crew, device, log)
    failed = work.failed | _summarize(run, shot, settings, inspection, device, log)
    return conclude(run, shot.frames, failed, as_json=common.json)


def inspect(settings: Settings, picture: Path | None, common) -> int:
    """Show what is understood of footage; return the exit code."""
    shot = open_shot(settings.views, settings.input, settings.reconstruct.shoulder or 0.0, keep=True)
    inspection = inspect_shot(shot, settings.reconstruct)
    if picture:
        write_views_picture(picture, shot.views(shot.frames[len(shot.frames) // 2]))
        Progress(quiet=common.quiet, verbose=common.verbose).line(f"picture {picture}")
    print(json.dumps(inspection.to_dict(), indent=2) if common.json else "\n".join(inspection.lines()))
    return 0


def flow(settings: Settings, out: Path, method: str, common) -> int:
    """Write the flow of every view between the frames of a shot; return the exit code."""
    from warpfluid.device import pick_device
    from warpfluid.motion.shot_flow import write_shot_flow

    device = pick_device(common.device)
    shot = open_shot(settings.views, settings.input)
    if len(shot.frames) < 2:
        raise ValueError("a flow leads from one frame to the next, and there is only one: use more with --frames")
    _make_folder(out)
    pairs = []
    for pair in write_shot_flow(shot, out, method=method, device=device):
        pairs.append(pair.to_dict())
        if not common.json:
            print(pair.line(), flush=True)
    if common.json:
        print(json.dumps({"folder": str(out), "pairs": pairs}))
    return 0


def demo(out: Path, common) -> int:
    """Reconstruct the packaged sample; return the exit code."""
    from importlib.resources import as_file, files

    with as_file(files("warpfluid") / "samples") as samples:
        views = [f"{angle}={samples / name}.####.png" for angle, name in ((0, "front"), (90, "side"))]
        settings = make_settings(views, None, None, None)
        code = reconstruct(settings, out, resume=False, overwrite=_is_demo(out, views), common=common)
    if code == 0 and not (common.json or common.quiet):
        print(
            f"\nopen    {out / PAGE} in a browser, {out / FILM} in a player\n"
            f"        {Run(out).volume_path(1)} and the other frames in Blender, Houdini or Maya\n"
            "next    warpfluid inspect --front YOUR_CLIP.mp4\n"
            "        warpfluid reconstruct --front YOUR_CLIP.mp4 -o fire"
        )
    return code


def doctor(cluster: str | None, common) -> int:
    """Report on the installation, the machine and a cluster; return the exit code, 1 if nothing can be made here."""
    from warpfluid.doctor import complaints, examine, lines

    found = examine(common.device, cluster)
    found["problems"] = complaints(found)
    print(json.dumps(found, indent=2) if common.json else "\n".join(lines(found)))
    return 1 if found["problems"] else 0


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
    return do_all(jobs if set(run.records()) & set(shot.frames) else {}, log)


def _make_folder(out: Path, flag: str = "-o") -> None:
    if out.exists() and not out.is_dir():
        raise ValueError(f"{out} is a file: name a folder with {flag}")
    out.mkdir(parents=True, exist_ok=True)


def _is_demo(folder: Path, views: list[str]) -> bool:
    """Return whether a folder holds the demo, which may be repeated, and not work of the user."""
    try:
        return Run(folder).settings().get("views", []) == views
    except ValueError:
        return False
