"""What runs and USD stages hold."""

import re
from pathlib import Path

from warpfluid.files.sequences import format_frames, parse_frames
from warpfluid.run import BODIES, CHECKPOINT, FILM, PAGE, Run
from warpfluid.volumes import file_facts


def explain_run(path: Path) -> dict:
    """Return what a run was made of, and what there is of it.

    Raises:
        ValueError: If its files are damaged.
        OSError: If they cannot be read.
    """
    run = Run(path)
    document, records = run.settings(), run.records()
    frames, warnings = list(records), []
    grids = []
    if frames:
        grids = [
            {"name": grid.name, "type": grid.kind, "size": _size(grid), "voxel_size": grid.voxel_size, "up": grid.up}
            for grid in file_facts(run.volume_path(frames[0]))
        ]
    warnings += _unfinished(run, document, frames)
    damaged = [frame for frame in frames if not run.is_whole(frame)]
    if damaged:
        warnings.append(f"frame {format_frames(damaged)} is damaged: the same command with --resume makes it anew")
    there = [name for name in (PAGE, FILM, CHECKPOINT, BODIES) if (path / name).is_file()]
    simulated = "simulate" in document
    box = " x ".join(map(str, document.get("size", ())))
    return {
        "kind": "run of simulate" if simulated else "run of reconstruct",
        "made_of": document.get("source") or document.get("views") or f"an empty box of {box}",
        "made_with": {name: str(document.get("made-with", {}).get(name)) for name in ("warpfluid", "device", "system")},
        "frames": format_frames(frames) if frames else None,
        "count": len(frames),
        "bytes": sum(run.volume_path(frame).stat().st_size for frame in frames),
        "grids": grids,
        "files": there,
        "warnings": warnings,
    }


def _unfinished(run: Run, document: dict, frames: list[int]) -> list[str]:
    """Return what a run that was broken off lacks, and the command that makes it."""
    command = "simulate" if "simulate" in document else "reconstruct"
    go_on = f"warpfluid {command} -o {run.folder} --resume"
    section = document.get("simulate" if "simulate" in document else "input", {})
    asked = document.get("made-with", {}).get("frames") or section.get("frames")
    lacking = [frame for frame in parse_frames(asked) if frame not in frames] if asked else []
    if lacking:
        count = len(parse_frames(asked))
        return [f"{count - len(lacking)} of {count} frames, not finished, without {format_frames(lacking)}: {go_on}"]
    if not frames:
        return [f"no frame is finished: {go_on}"]
    wanted = {FILM: "turntable", PAGE: "report"}
    output = document.get("output", {})
    missing = [file for file, name in wanted.items() if output.get(name) and not (run.folder / file).is_file()]
    return [f"{' and '.join(missing)} {'lack' if len(missing) > 1 else 'lacks'}: {go_on}"] if missing else []


def explain_stage(path: Path) -> dict:
    """Return what a USD stage in text shows, as far as its lines tell.

    Raises:
        ValueError: If it is no such text.
        OSError: If it cannot be read.
    """
    text = path.read_bytes().decode(errors="replace")
    if not text.startswith("#usda"):
        raise ValueError(f"{path}: this is no USD stage in text (.usda)")
    layer = {
        name: (re.search(rf"^\s*{name} = (\S+)", text, re.MULTILINE) or ["", ""])[1].strip('"')
        for name in ("upAxis", "metersPerUnit", "startTimeCode", "endTimeCode", "timeCodesPerSecond")
    }
    assets = sorted(set(re.findall(r"@([^@\n]+)@", text)))
    missing = [asset for asset in assets if "://" not in asset and not (path.parent / asset).exists()]
    prims = re.findall(r'^\s*def (\w+) "([^"]+)"', text, re.MULTILINE)
    warnings = (
        [f"{len(missing)} of {len(assets)} files that it shows are not there, as {missing[0]}"] if missing else []
    )
    return {
        "kind": "USD stage",
        "layer": layer,
        "prims": [{"type": kind, "name": name} for kind, name in prims[:50]],
        "files": len(assets),
        "warnings": warnings,
    }


def _size(grid) -> list[int]:
    return (grid.whole[1] - grid.whole[0] + 1).tolist() if grid.whole is not None else [0, 0, 0]
