"""Look at footage: what is understood of it, and how it moves."""

import json
from pathlib import Path

from warpfluid.files.images import is_of_views
from warpfluid.footage.inspection import inspect_shot, write_views_picture
from warpfluid.footage.shot import open_shot
from warpfluid.progress import Progress
from warpfluid.settings import Settings


def inspect(settings: Settings, picture: Path | None, common) -> int:
    """Show what is understood of footage; return the exit code."""
    if common.device not in (None, "auto", "cpu"):  # which any machine has
        from warpfluid.device import pick_device

        pick_device(common.device)
    shot = open_shot(settings.views, settings.input, settings.reconstruct.shoulder or 0.0, keep=True)
    inspection = inspect_shot(shot, settings.reconstruct)
    log = Progress(quiet=common.quiet, verbose=common.verbose)
    if picture and picture.exists() and not is_of_views(picture):
        log.line(f"picture not written: {picture} is not of inspect; name another one with --picture")
    elif picture:
        write_views_picture(picture, shot.views(shot.frames[len(shot.frames) // 2]))
        log.line(f"picture {picture}")
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
    make_folder(out)
    pairs = []
    for pair in write_shot_flow(shot, out, method=method, device=device):
        pairs.append(pair.to_dict())
        if not common.json:
            print(pair.line(), flush=True)
    if common.json:
        print(json.dumps({"folder": str(out), "pairs": pairs}))
    return 0


def make_folder(out: Path, flag: str = "-o") -> None:
    """Make a folder that a flag names; refuse a file."""
    if out.exists() and not out.is_dir():
        raise ValueError(f"{out} is a file: name a folder with {flag}")
    out.mkdir(parents=True, exist_ok=True)
