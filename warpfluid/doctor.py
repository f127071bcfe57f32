"""What is installed and what this machine can do, for a report that helps when something does not work."""

import os
import subprocess
import sys
import tempfile
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from warpfluid import __version__
from warpfluid.kernels.launch import thread_count

PACKAGES = ("warp-lang", "numpy", "scipy", "scikit-image", "OpenEXR", "av", "pyvista", "cyclopts", "rich")
# Where there is no OpenGL library this crashes, so it is tried in a process of its own. The class says what it drew on.
DRAW = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderWindow
window = vtkRenderWindow()
window.SetShowWindow(False)
window.SetSize(8, 8)
window.Render()
print(window.GetClassName())
"""
SCREENLESS = ("EGL", "OSOpenGL")  # in the names of classes that draw in memory
PATIENCE = 30  # s


def examine() -> dict:
    """Return versions, devices and abilities as plain tables, whatever is missing."""
    return {
        "versions": {"warpfluid": __version__, "python": sys.version.split()[0], **_packages()},
        "devices": _devices(),
        "threads": thread_count(),
        "kernels": _kernel_cache(),
        "video": {"write": _has_codec("libx264", "w"), "read": _has_codec("h264", "r")},
        "windows": drawing() != "nothing",
    }


def lines(found: dict) -> list[str]:
    """Return what ``examine`` found as plain text, with the way out of what does not work."""
    cache, video = found["kernels"], found["video"]
    state = "compiled" if cache["warm"] else "to be compiled at the first run, about a minute"
    return [
        *(f"{name:<13}{number or 'MISSING: install warpfluid again'}" for name, number in found["versions"].items()),
        *(f"device       {d['name']}: {d['description']}, {d['memory'] / 1e9:.0f} GB" for d in found["devices"]),
        f"threads      {found['threads']}; WARPFLUID_THREADS sets another number",
        f"kernels      {cache['folder']}: {state}"
        + ("" if cache["lasting"] else "; NOT KEPT: set WARP_CACHE_PATH to a folder that can be written"),
        f"video        reads H.264: {_yes(video['read'])}, writes it: {_yes(video['write'])}"
        + ("" if all(video.values()) else "; install av from PyPI, its wheels have both"),
        f"windows      {_yes(found['windows'])}"
        + (
            ""
            if found["windows"]
            else "; warpfluid draws without them; that of `preview` needs libegl1, libgl1-mesa-dri"
        ),
    ]


def _packages() -> dict[str, str | None]:
    found = {}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = None
    return found


def _devices() -> list[dict]:
    """Return the devices Warp can use, the one that `auto` means first."""
    import warp as wp

    from warpfluid.device import pick_device
    from warpfluid.footage.estimate import machine_memory

    best = pick_device("auto")
    devices = sorted(wp.get_devices(), key=lambda device: device != best)
    return [
        {"name": str(d), "description": d.name, "memory": d.total_memory if d.is_cuda else machine_memory()}
        for d in devices
    ]


def _kernel_cache() -> dict:
    """Return where compiled kernels are, whether any are, and whether they outlast this process."""
    import warp as wp

    from warpfluid.device import start_warp

    start_warp()
    folder = Path(wp.config.kernel_cache_dir)
    lasting = os.access(folder, os.W_OK) and Path(tempfile.gettempdir()) not in folder.parents
    return {"folder": str(folder), "warm": any(folder.glob("wp_warpfluid*")), "lasting": lasting}


def _has_codec(name: str, mode: str) -> bool:
    try:
        import av

        return bool(av.Codec(name, mode))
    except Exception:  # a broken library is as good as none
        return False


def drawing() -> str:
    """Return what pyvista can draw on here: a ``screen``, ``memory`` alone, or ``nothing``."""
    command = [sys.executable, "-c", DRAW]
    try:
        found = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return "nothing"
    if found.returncode != 0:
        return "nothing"
    return "memory" if any(name in found.stdout for name in SCREENLESS) else "screen"


def _yes(flag: bool) -> str:
    return "yes" if flag else "no"
