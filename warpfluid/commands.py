"""What the commands do, once their flags are read."""

import json
import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np

from warpfluid.files.sequences import format_frames, parse_frames
from warpfluid.inspection import Inspection, inspect_shot, write_views_picture
from warpfluid.options import InputOptions, OutputOptions, ReconstructOptions
from warpfluid.run import Run, Settings, read_settings
from warpfluid.shot import Problems, Shot, open_shot

STREAKS = 0.2  # angles a voxel of width; below this the volumes have streaks


def make_settings(views: list[str], footage, method, output, *, paper: bool = False, config: Path | None = None) -> Settings:
    """Put settings together: flags first, then the configuration file, then the defaults.

    Raises:
        ValueError: If any value or name is wrong; one line each.
    """
    document = read_settings(config) if config else {}
    problems = Problems()
    make_method = ReconstructOptions.paper if paper else ReconstructOptions
    parts = {
        "input": (InputOptions, footage),
        "reconstruct": (make_method, method),
        "output": (OutputOptions, output),
    }
    made = {}
    for name, (make, flags) in parts.items():
        given = {k: v for k, v in asdict(flags).items() if v is not None} if flags else {}
        values = document.get(name, {}) | given
        made[name] = problems.attempt(lambda make=make, values=values: make(**values))
    problems.raise_if_any()
    return Settings(views=tuple(views or document.get("views", ())), **made)


def reconstruct(settings: Settings, out: Path, *, resume: bool, overwrite: bool, common) -> int:
    """Reconstruct a shot into a folder; return the exit code."""
    from warpfluid.device import pick_device
    from warpfluid.progress import Progress
    from warpfluid.reconstruction.sequence import reconstruct_frames

    log = Progress(quiet=common.quiet)
    shot = open_shot(settings.views, settings.input)
    run = Run(out)
    device = pick_device(common.device)
    _check_every_frame(shot)
    inspection = inspect_shot(shot, settings.reconstruct)
    for line in [*inspection.lines(), *_warnings(shot, settings)]:
        log.line(line)
    facts = {"device": str(device), "inputs": shot.hashes()}
    run.begin(settings, facts, resume=resume, overwrite=overwrite)
    done = run.records() if resume else {}
    frames = [frame for frame in shot.frames if frame not in done]
    if len(frames) < len(shot.frames):
        log.line(f"resume  {len(shot.frames) - len(frames)} of {len(shot.frames)} frames are there")
    failed, seconds = {}, sum(record["seconds"] for record in done.values())
    with log.frames(frames, settings.reconstruct.iterations) as bar:
        for record in reconstruct_frames(
            shot, settings, run, device=device, frames=frames, progress=bar.iteration
        ):
            if "error" in record:
                failed[record["frame"]] = record["error"]
            else:
                seconds += record["seconds"]
            bar.finished(record)
    _summarize(run, shot, settings, inspection, device, seconds, log)
    return _conclude(run, shot, failed, common)


def inspect(settings: Settings, picture: Path | None, common) -> int:
    """Show what is understood of footage; return the exit code."""
    shot = open_shot(settings.views, settings.input)
    inspection = inspect_shot(shot, settings.reconstruct)
    if picture:
        write_views_picture(picture, shot.views(shot.frames[len(shot.frames) // 2]))
    if common.json:
        print(json.dumps(inspection.to_dict(), indent=2))
    else:
        print("\n".join([*inspection.lines(), *_warnings(shot, settings)]))
    return 0


def export(folder: Path, out: Path, form: str, frames: str | None, common) -> int:
    """Write the volumes of a run in another format; return the exit code."""
    from warpfluid.files.npz import write_npz

    run = Run(folder)
    table = run.settings()
    there = tuple(run.records())
    wanted = tuple(parse_frames(frames)) if frames else there
    missing = sorted(set(wanted) - set(there))
    if missing or not wanted:
        have = format_frames(there) if there else "none"
        lacks = f"lacks frame {format_frames(missing)}" if missing else "has no finished frame"
        raise ValueError(f"{folder} {lacks} (it has {have}): reconstruct it first, or choose with --frames")
    out.mkdir(parents=True, exist_ok=True)
    written = []
    for frame in wanted:
        path = out / f"density.{frame:04d}.{form}"
        density = np.ascontiguousarray(run.volume(frame).transpose(0, 2, 1))
        write_npz(path, density, voxel_size=table["output"]["voxel_size"], frame=frame)
        written.append(str(path))
    print(json.dumps({"files": written}) if common.json else "\n".join(written))
    return 0


def demo(out: Path, common) -> int:
    """Reconstruct the packaged sample; return the exit code."""
    from importlib.resources import as_file, files

    with as_file(files("warpfluid") / "samples") as samples:
        views = [f"{angle}={samples / name}.####.png" for angle, name in ((0, "front"), (90, "side"))]
        settings = make_settings(views, None, None, None)
        code = reconstruct(settings, out, resume=False, overwrite=(out / "run.toml").exists(), common=common)
    if code == 0 and not (common.json or common.quiet):
        print(
            f"\nopen    {out / 'report.html'} and {out / 'turntable.mp4'}; "
            f"{out / 'density.0001.vdb'} and its followers in Blender, Houdini or Maya\n"
            "next    warpfluid inspect --front YOUR_CLIP.mp4\n"
            "        warpfluid reconstruct --front YOUR_CLIP.mp4 -o fire"
        )
    return code


def _check_every_frame(shot: Shot) -> None:
    """Read every picture once, so that a damaged one is known before the long part."""
    problems = Problems()
    for frame in shot.frames:
        problems.attempt(shot.views, frame)
    problems.raise_if_any()


def _warnings(shot: Shot, settings: Settings) -> list[str]:
    angles, width = settings.reconstruct.angles, shot.size[0]
    if angles and angles < STREAKS * width:
        return [f"hint    {angles} angles are few for {width} pixels: streaks appear below {STREAKS * width:.0f}"]
    return []


def _summarize(run: Run, shot: Shot, settings: Settings, inspection: Inspection, device, seconds: float, log) -> None:
    """Write the turntable and the report of what is finished."""
    from warpfluid.run_report import report_run, write_film

    if not run.records():
        return
    if settings.output.turntable:
        log.line("film    turntable.mp4")
        write_film(run, settings, run.folder / "turntable.mp4")
    if settings.output.report:
        log.line("page    report.html")
        report_run(run, shot, settings, inspection, device=device, seconds=seconds)


def _conclude(run: Run, shot: Shot, failed: dict[int, str], common) -> int:
    """Print the result; return the exit code."""
    records = run.records()
    if common.json:
        result = {"folder": str(run.folder), "frames": list(records.values()), "failed": failed}
        print(json.dumps(result))
    else:
        print(f"{run.folder}: {len(records)} of {len(shot.frames)} frames")
    for frame, error in failed.items():
        print(f"error: frame {frame}: {error}", file=sys.stderr)
    if failed:
        print("the others are whole; --resume tries these again", file=sys.stderr)
    return 1 if failed else 0
