"""Reconstruct the packaged sample."""

from pathlib import Path

from warpfluid.commands.reconstruct import reconstruct
from warpfluid.run import FILM, PAGE, Run
from warpfluid.settings import make_settings


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


def _is_demo(folder: Path, views: list[str]) -> bool:
    """Return whether a folder holds the demo, which may be repeated, and not work of the user."""
    try:
        return Run(folder).settings().get("views", []) == views
    except ValueError:
        return False
