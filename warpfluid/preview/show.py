"""What ``warpfluid preview`` does, once its flags are read."""

import json
from pathlib import Path

from warpfluid.doctor import drawing
from warpfluid.files.folders import check_writable
from warpfluid.files.images import write_png
from warpfluid.options import PreviewOptions
from warpfluid.preview.page import write_page
from warpfluid.preview.scene import Scene, open_scene
from warpfluid.progress import Progress

STILL = Path("preview.png")  # where there can be no window
INSTALL = "apt install libegl1 libgl1-mesa-dri, or a graphics driver"


def preview(source: str, options: PreviewOptions, *, html: Path | None, screenshot: Path | None, common) -> int:
    """Show volumes in a window, a page or a picture; return the exit code."""
    log = Progress(quiet=common.quiet, verbose=common.verbose)
    for path, endings in ((html, (".html", ".htm")), (screenshot, (".png",))):
        _check_path(path, endings)
    scene = open_scene(source, options)
    log.notes(scene.volumes.messages)
    result: dict = {"source": str(source), "frames": list(scene.frames)}
    if html:
        result["html"] = _write_page(html, scene, options, log)
    if screenshot:
        result["picture"] = _write_picture(screenshot, scene, options, log)
    if not html and not screenshot:
        result |= _open_window(scene, options, log)
    if common.json:
        print(json.dumps(result))
    else:
        for name in ("html", "picture"):
            if name in result:
                print(result[name]["file"])
    return 0


def _check_path(path: Path | None, endings: tuple[str, ...]) -> None:
    """Refuse what cannot be written, before any work."""
    if path is None:
        return
    if path.suffix.lower() not in endings:
        raise ValueError(f"{path} ends in {path.suffix!r}, expected {' or '.join(endings)}")
    if not path.parent.is_dir():
        raise ValueError(f"{path} cannot be written, {path.parent} is no folder: name one that is there")
    check_writable(path.parent)


def _write_page(path: Path, scene: Scene, options: PreviewOptions, log: Progress) -> dict:
    """Write the page; say what it took."""
    page = write_page(path, scene, budget=options.html_size)
    stored, box = (" x ".join(map(str, size)) for size in (page.stored, page.box))
    log.line(f"page    {len(scene.frames)} frames of {box} voxels, what is lit as {stored}: {page.bytes / 1e6:.1f} MB")
    if page.coarser > 1:
        log.line(f"page    voxels are {page.coarser:.2f} times longer to fit {options.html_size:g} MB; see --html-size")
    return {"file": str(path), "bytes": page.bytes, "voxels": list(page.stored), "coarser": round(page.coarser, 3)}


def _write_picture(path: Path, scene: Scene, options: PreviewOptions, log: Progress) -> dict:
    """Write what the window would show, or a still picture where nothing draws one."""
    from warpfluid.preview.window import Window

    if drawing() == "nothing":
        log.line(f"picture of the volume alone: there is no OpenGL library; {INSTALL}")
        return _write_still(path, scene, options)
    import pyvista

    with pyvista.vtk_verbosity("off"):  # it warns where there is no screen
        picture = Window(scene, options, off_screen=True, say=log.line).picture()
    write_png(path, picture)
    return {"file": str(path), "drawn": "window"}


def _open_window(scene: Scene, options: PreviewOptions, log: Progress) -> dict:
    """Open the window, or write a still picture where there can be none."""
    from warpfluid.preview.controls import Controls
    from warpfluid.preview.window import Window

    state = drawing()
    if state == "screen":
        Controls(Window(scene, options, say=log.line)).run()
        return {"window": True}
    reason = "there is no screen" if state == "memory" else f"there is no OpenGL library ({INSTALL})"
    log.line(f"no window: {reason}; --html FILE plays the volumes in any browser. A still picture is in {STILL}")
    return {"window": False, "picture": _write_still(STILL, scene, options)}


def _write_still(path: Path, scene: Scene, options: PreviewOptions) -> dict:
    write_png(path, scene.still(options.window_size))
    return {"file": str(path), "drawn": "still"}
