"""What folders hold that no run is in: exports of ours, and sequences of volumes or pictures."""

import json
from dataclasses import asdict
from pathlib import Path

from warpfluid.explaining.pictures import explain_exr, explain_picture
from warpfluid.explaining.volumes import explain_volume
from warpfluid.files.images import IMAGE_SUFFIXES, is_of_views
from warpfluid.files.sequences import find_sequence, format_frames
from warpfluid.files.video import VIDEO_SUFFIXES
from warpfluid.options import ExportOptions
from warpfluid.volumes import EXPORT, find_volumes

OPENED_BY = {  # files that show all frames at once
    "open_in_blender.py": "opens it: blender --python {}",
    "volumes.usda": "opens it: as a USD stage, in Houdini, Omniverse, Maya or Blender",
}
CHANGES = (
    "half",
    "crop",
    "repair",
    "density_scale",
    "drop_below",
    "grids",
)  # worth a word where they are set


def explain_export(path: Path) -> dict:
    """Return what a folder of ``warpfluid export`` holds: of what it was made, how, and what of it is there.

    Raises:
        ValueError: If its record or its first volume is damaged.
        OSError: If they cannot be read.
    """
    content = _read(path / EXPORT)
    options, files = content["options"], content["files"]
    missing = [frame for frame, file in files.items() if not file.is_file()]
    there = {frame: file for frame, file in files.items() if frame not in missing}
    first = explain_volume(next(iter(there.values()))) if there else {"grids": [], "warnings": []}
    warnings = list(first["warnings"])
    if missing:
        warnings.append(f"frame {format_frames(missing)} is not there: the same export with --resume writes it")
    usual = asdict(ExportOptions())
    changed = {name: options[name] for name in CHANGES if options.get(name, usual[name]) != usual[name]}
    return {
        "kind": f"export of warpfluid {content.get('warpfluid')}",
        "made_of": content["source"],
        "frames": format_frames(files) if files else None,
        "count": len(there),
        "bytes": sum(file.stat().st_size for file in there.values()),
        "rate": content.get("fps"),
        "layer": {
            "format": options.get("format"),
            "up": content.get("up"),
            **{name.replace("_", " "): value for name, value in changed.items()},
            **{name: text.format(path / name) for name, text in OPENED_BY.items() if (path / name).is_file()},
        },
        "grids": first["grids"],
        "warnings": warnings,
    }


def explain_folder(path: Path) -> dict:
    """Return what the volumes, or else the pictures, in a folder are, by the first of them.

    Raises:
        ValueError: If there are none, or several sequences.
        OSError: If they cannot be read.
    """
    try:
        volumes = find_volumes(path)
    except ValueError as error:
        if "several" in str(error):
            raise
        return _footage(path)
    first = next(iter(volumes.values()))
    told = explain_volume(first)
    return told | {"kind": f"folder of {told['kind']}", "bytes": sum(file.stat().st_size for file in volumes.values())}


def _footage(path: Path) -> dict:
    """Return what clips and pictures there are, but for the picture that ``inspect`` itself leaves."""
    files = sorted(file for file in path.iterdir() if file.is_file() and not file.name.startswith("."))
    clips = [file for file in files if file.suffix.lower() in VIDEO_SUFFIXES]
    others = [file for file in files if file.suffix.lower() in IMAGE_SUFFIXES and not is_of_views(file)]
    if not clips:
        return _pictures(path)
    pictures = [f"and {len(others)} picture{'s' * (len(others) > 1)}"] if others else []
    return {
        "kind": f"folder of clips: warpfluid inspect --front {clips[0]} looks at one",
        "count": len(clips),
        "files": [*(file.name for file in clips), *pictures],
        "bytes": sum(file.stat().st_size for file in clips),
    }


def _pictures(path: Path) -> dict:
    try:
        pictures = find_sequence(path)
    except (ValueError, OSError) as error:
        kinds = sorted({file.suffix for file in path.iterdir() if file.suffix})
        raise ValueError(
            f"{path} is a folder without a run, volumes or pictures; it has {', '.join(kinds) or 'nothing'}"
        ) from error
    first = next(iter(pictures.values()))
    told = explain_exr(first) if first.suffix.lower() == ".exr" else explain_picture(first)
    frames = {"frames": format_frames(pictures), "count": len(pictures)}
    size = sum(file.stat().st_size for file in pictures.values())
    return told | frames | {"kind": f"folder of pictures, the first a {told['kind']}", "bytes": size}


def _read(path: Path) -> dict:
    """Return the record of an export, its files by frame."""
    try:
        content = json.loads(path.read_bytes())
        files = {int(frame): path.with_name(Path(facts["file"]).name) for frame, facts in content["frames"].items()}
        return {**content, "options": dict(content["options"]), "source": str(content["source"]), "files": files}
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise ValueError(f"{path} is damaged: export again with --overwrite") from error
