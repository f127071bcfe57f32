"""Volumes of fire, smoke, explosions and splashes from one or a few videos.

    import warpfluid as wf

    views = wf.Views.from_pictures([front, side], [0, 90])
    result = wf.reconstruct(views)
    wf.write_vdb("fire.0001.vdb", {"density": result.density})

Names are imported when they are first used, so that importing the package is quick.
"""

import importlib

__version__ = "0.1.0"

_HOMES = {
    "InputOptions": "warpfluid.options",
    "Inspection": "warpfluid.footage.inspection",
    "OutputOptions": "warpfluid.options",
    "Projector": "warpfluid.projector",
    "ReconstructOptions": "warpfluid.options",
    "Reconstruction": "warpfluid.reconstruction.result",
    "Run": "warpfluid.run",
    "Views": "warpfluid.views",
    "compare_pictures": "warpfluid.metrics",
    "inspect_shot": "warpfluid.footage.inspection",
    "open_shot": "warpfluid.footage.shot",
    "open_volumes": "warpfluid.volumes",
    "read_vdb": "warpfluid.files.vdb",
    "reconstruct": "warpfluid.reconstruction.em",
    "render_turntable": "warpfluid.rendering.turntable",
    "write_turntable": "warpfluid.rendering.turntable",
    "write_npz": "warpfluid.files.npz",
    "write_nvdb": "warpfluid.files.nvdb",
    "write_vdb": "warpfluid.files.vdb",
    "write_vti": "warpfluid.files.vti",
}

__all__ = ["__version__", *_HOMES]


def __getattr__(name: str):
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'warpfluid' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
