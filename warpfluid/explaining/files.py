"""What a file is, by its ending."""

from pathlib import Path

from warpfluid.explaining.pictures import explain_exr, explain_picture, explain_video
from warpfluid.explaining.scenes import explain_run, explain_stage
from warpfluid.explaining.volumes import explain_volume
from warpfluid.files.images import IMAGE_SUFFIXES
from warpfluid.run import SETTINGS
from warpfluid.volumes import ENDINGS

VIDEOS = (".mp4", ".mov", ".mkv", ".avi", ".webm", ".m4v", ".mxf", ".mpg", ".mpeg", ".webp", ".gif")


def explain(path: Path) -> dict:
    """Return what a file or a run is, as plain values for JSON.

    Args:
        path: A volume, a picture, a video, a USD stage, or the folder of a run.

    Raises:
        ValueError: If it is damaged, or of no known kind.
        OSError: If it cannot be read.
    """
    if path.is_dir():
        if not (path / SETTINGS).is_file():
            kinds = sorted({file.suffix for file in path.iterdir() if file.suffix})
            raise ValueError(f"{path} is a folder and no run; name files in it, it has {', '.join(kinds) or 'none'}")
        return {"path": str(path), **explain_run(path)}
    ending, size = path.suffix.lower(), path.stat().st_size
    kinds = {
        **dict.fromkeys(VIDEOS, explain_video),
        **dict.fromkeys((*IMAGE_SUFFIXES, ".hdr"), explain_picture),
        ".exr": explain_exr,
        ".usda": explain_stage,
        **dict.fromkeys(ENDINGS, explain_volume),
    }
    if ending not in kinds:
        raise ValueError(
            f"{path}: {ending or 'a file without an ending'} is not known; known are {' '.join(sorted(kinds))}"
        )
    return {"path": str(path), "bytes": size, **kinds[ending](path)}
