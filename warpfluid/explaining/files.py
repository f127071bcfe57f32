"""What a file is, by its ending."""

from pathlib import Path

from warpfluid.explaining.exports import explain_export, explain_folder
from warpfluid.explaining.papers import PAPERS, explain_paper
from warpfluid.explaining.pictures import explain_exr, explain_picture, explain_video
from warpfluid.explaining.scenes import explain_run, explain_stage
from warpfluid.explaining.volumes import explain_volume
from warpfluid.files.images import IMAGE_SUFFIXES
from warpfluid.run import SETTINGS
from warpfluid.volumes import ENDINGS, EXPORT

VIDEOS = (".mp4", ".mov", ".mkv", ".avi", ".webm", ".m4v", ".mxf", ".mpg", ".mpeg", ".webp", ".gif")


def explain(path: Path) -> dict:
    """Return what a file or a run is, as plain values for JSON.

    Args:
        path: A volume, a picture, a video, a USD stage, or a folder of a run, an export, volumes or pictures.

    Raises:
        ValueError: If it is damaged, or of no known kind.
        OSError: If it cannot be read.
    """
    if path.is_dir():
        marks = {SETTINGS: explain_run, EXPORT: explain_export}
        known = (function for name, function in marks.items() if (path / name).is_file())
        return {"path": str(path), **next(known, explain_folder)(path)}
    ending, size = path.suffix.lower(), path.stat().st_size
    kinds = {
        **dict.fromkeys(VIDEOS, explain_video),
        **dict.fromkeys((*IMAGE_SUFFIXES, ".hdr"), explain_picture),
        ".exr": explain_exr,
        ".usda": explain_stage,
        **dict.fromkeys(PAPERS, explain_paper),
        **dict.fromkeys(ENDINGS, explain_volume),
    }
    if ending not in kinds:
        raise ValueError(
            f"{path}: {ending or 'a file without an ending'} is not known; known are {' '.join(sorted(kinds))}"
        )
    return {"path": str(path), "bytes": size, **kinds[ending](path)}
