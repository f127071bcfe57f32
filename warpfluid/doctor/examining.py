"""Versions, devices, folders and abilities as plain tables, whatever is missing."""

import os
import shutil
import sys
import tempfile
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path

from warpfluid import __version__
from warpfluid.doctor.farm import examine_cluster
from warpfluid.doctor.windows import drawing
from warpfluid.errors import describe

PACKAGES = ("warp-lang", "numpy", "scipy", "scikit-image", "OpenEXR", "av", "pyvista", "cyclopts", "rich")
READS = ("h264", "hevc", "prores", "vp9", "av1", "dnxhd", "mjpeg")
WRITES = "libx264"
COMPILED = (".o", ".ptx", ".cubin")  # what Warp makes of kernels
BINDINGS = ("openvdb", "pyopenvdb")  # of OpenVDB, as different builds call them


def examine(device: str | None = None, cluster: str | None = None) -> dict:
    """Return versions, devices and abilities as plain tables, whatever is missing.

    Args:
        device: The one that commands are to use; the first GPU, or the CPU, by default.
        cluster: Address of the scheduler that they are to use.
    """
    return {
        "versions": {"warpfluid": __version__, "python": sys.version.split()[0], **_packages()},
        **_computing(device),
        "disk": {"folder": os.getcwd(), "free": shutil.disk_usage(".").free},
        "video": {"read": [name for name in READS if _has_codec(name, "r")], "write": _has_codec(WRITES, "w")},
        "windows": drawing(),
        "cluster": examine_cluster(cluster),
        "programs": {"blender": shutil.which("blender"), "openvdb": next(filter(_is_there, BINDINGS), None)},
    }


def complaints(found: dict) -> list[str]:
    """Return why warpfluid cannot work here as it is asked to; nothing if it can."""
    lacks = [f"{name} is not installed" for name, number in found["versions"].items() if number is None]
    broken = [f"{one['name']}: {one['error']}" for one in found["devices"] if one["error"]]
    cluster = found["cluster"]
    silent = cluster["address"] and not cluster["workers"]
    return lacks + found["errors"] + broken + ([f"{cluster['address']} has no workers"] if silent else [])


def _packages() -> dict[str, str | None]:
    found = {}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = None
    return found


def _computing(device: str | None) -> dict:
    """Return devices, threads, memory and the folder of compiled kernels, or why nothing can be computed."""
    found = {"devices": [], "threads": None, "memory": {}, "kernels": None, "errors": []}
    try:
        from warpfluid.device import pick_device
        from warpfluid.kernels.launch import thread_count
        from warpfluid.memory import free_memory, memory_limit

        best = pick_device(device)
        found |= {"devices": _devices(best), "kernels": _kernel_cache(), "threads": thread_count()}
        found["memory"] = {"total": memory_limit(), "free": free_memory()}
    except Exception as error:  # Warp, or what it needs, may be broken in any way
        found["errors"] = [describe(error)]
    return found


def _devices(best) -> list[dict]:
    """Return the devices Warp can use, the one that commands use first."""
    import warp as wp

    from warpfluid.memory import memory_limit

    devices = sorted(wp.get_devices(), key=lambda device: device != best)
    return [
        {
            "name": str(d),
            "description": d.name,
            "memory": d.total_memory if d.is_cuda else memory_limit(),
            "error": _fault(d),
        }
        for d in devices
    ]


def _fault(device) -> str | None:
    """Return what goes wrong when numbers go to a device and come back; None if nothing does."""
    import numpy as np
    import warp as wp

    try:
        back = wp.array(np.arange(3.0, dtype=np.float32), device=device).numpy()
    except RuntimeError as error:
        return describe(error)
    return None if back.tolist() == [0, 1, 2] else f"numbers come back as {back.tolist()}"


def _kernel_cache() -> dict:
    """Return where compiled kernels are, how large they are, and whether they outlast this process."""
    import warp as wp

    folder = Path(wp.config.kernel_cache_dir)
    lasting = os.access(folder, os.W_OK) and Path(tempfile.gettempdir()) not in folder.parents
    size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
    warm = any(file.is_file() and file.suffix in COMPILED for file in folder.glob("wp_warpfluid*/*"))
    begun = not warm and any(folder.glob("wp_warpfluid*"))
    return {"folder": str(folder), "warm": warm, "begun": begun, "lasting": lasting, "bytes": size}


def _has_codec(name: str, mode: str) -> bool:
    try:
        import av

        return bool(av.Codec(name, mode))
    except Exception:  # a broken library is as good as none
        return False


def _is_there(module: str) -> bool:
    try:
        return find_spec(module) is not None
    except (ImportError, ValueError):
        return False
