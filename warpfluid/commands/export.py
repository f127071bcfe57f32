"""From volumes to files of other programs, frame by frame."""

import json
import shutil
from pathlib import Path

from warpfluid.errors import describe
from warpfluid.exporting.frame import Prepared, lit_box, prepare
from warpfluid.exporting.record import Record
from warpfluid.exporting.scene import BLENDER_SCENE, Body, body_facts, find_bodies, scene_facts, write_stage
from warpfluid.files.folders import check_writable
from warpfluid.files.sequences import format_frames, parse_frames
from warpfluid.options import ExportOptions
from warpfluid.outcome import name_failures
from warpfluid.progress import Progress
from warpfluid.volumes import Lattice, VolumeSequence, check_room, file_facts, open_volumes

STAGE, SCRIPT = "volumes.usda", "open_in_blender.py"


def export(source: str, out: Path, options: ExportOptions, *, resume: bool, overwrite: bool, common) -> int:
    """Write volumes in another format; return the exit code.

    Args:
        source: A run or volumes.
        out: Folder to write to.
        options: How.
        resume: Keep frames that are there.
        overwrite: Replace an earlier export.
        common: What most commands take.

    Raises:
        ValueError: If anything that is asked for is wrong.
        OSError: If the source cannot be read or the folder not written.
    """
    log = Progress(quiet=common.quiet, verbose=common.verbose)
    check_writable(out)
    sequence = open_volumes(source, grid=options.grid, up=options.source_up, unchecked=True)
    check_room(sequence.shape, _numbers(sequence, options))
    frames = _wanted(sequence, options)
    lit = lit_box(sequence) if options.crop else None
    bodies = find_bodies(sequence, options)
    record = Record(out)
    facts = scene_facts(sequence, options)
    record.begin(Path(source).expanduser(), options, facts, resume=resume, overwrite=overwrite)
    log.notes(sequence.messages)
    failed = _export_frames(sequence, frames, options, lit, record, log)
    written = [str(out / facts["file"]) for facts in record.content["frames"].values()]
    if written:
        written += _write_scene(record, out, options, bodies)
    _show(record, out, written, failed, common)
    return name_failures(failed, "the others are written; mend these, then go on with --resume")


def write_frame(path: Path, prepared: Prepared, frame: int, options: ExportOptions) -> None:
    """Write a frame in the format that is asked for.

    Raises:
        ValueError: If the format cannot hold a value.
        OSError: If the file cannot be written.
    """
    file = prepared.file
    place = {"voxel_size": file.voxel_size, "origin": file.origin}
    if options.ending == "vdb":
        from warpfluid.files.vdb import write_vdb

        write_vdb(path, file.grids, **place, half=options.half, up=options.file_up, metadata={"frame": frame})
    elif options.ending == "nvdb":
        from warpfluid.files.nvdb import write_nvdb

        write_nvdb(path, file.grids, **place, up=options.file_up, packed=not options.plain)
    elif options.ending == "vti":
        from warpfluid.files.vti import write_vti

        write_vti(path, file.grids, **place, up=options.file_up)
    else:
        from warpfluid.files.npz import write_npz_grids

        write_npz_grids(path, file.grids, **place, half=options.half, frame=frame)


def _numbers(sequence: VolumeSequence, options: ExportOptions) -> int:
    """Return how many numbers of a voxel are read of the first frame; of a damaged one, which fails later, one."""
    try:
        facts = file_facts(sequence.files[sequence.frames[0]])
    except (ValueError, OSError):
        return 1
    asked = None if options.grids is None else [name.strip() for name in options.grids.split(",")]
    kinds = [grid.kind for grid in facts if grid.readable and (asked is None or grid.name in asked)]
    return sum(3 if kind == "vec3s" else 1 for kind in kinds)


def _wanted(sequence: VolumeSequence, options: ExportOptions) -> tuple[int, ...]:
    wanted = tuple(parse_frames(options.frames)) if options.frames else sequence.frames
    missing = sorted(set(wanted) - set(sequence.frames))
    if missing:
        have = format_frames(sequence.frames)
        raise ValueError(f"{sequence.name} lacks frame {format_frames(missing)} (it has {have}): choose with --frames")
    return wanted


def _export_frames(
    sequence: VolumeSequence,
    frames: tuple[int, ...],
    options: ExportOptions,
    lit: Lattice | None,
    record: Record,
    log: Progress,
) -> dict[str, str]:
    """Write frames; return what failed."""
    failed, hashes = {}, sequence.hashes()
    left = [frame for frame in frames if not record.has(frame, hashes[str(frame)])]
    if len(left) < len(frames):
        log.line(f"resume  {len(frames) - len(left)} of {len(frames)} frames are there")
    try:
        for frame in left:
            try:
                log.line(_export_frame(sequence, frame, options, lit, record, hashes[str(frame)]))
            except (ValueError, OSError) as error:
                failed[f"frame {frame}"] = describe(error)
                log.line(f"frame   {frame} failed: {describe(error)}")
                log.stack()
    except KeyboardInterrupt as stop:
        done = len(record.content["frames"])
        raise KeyboardInterrupt(f"stopped, {done} frames are there; the same command with --resume goes on") from stop
    return failed


def _export_frame(
    sequence: VolumeSequence, frame: int, options: ExportOptions, lit: Lattice | None, record: Record, source_hash: str
) -> str:
    """Write a frame and note it; return what is said of it."""
    path = record.path.with_name(f"density.{frame:04d}.{options.ending}")
    prepared = prepare(sequence, frame, options, lit)
    write_frame(path, prepared, frame, options)
    place = {"voxel_size": prepared.file.voxel_size, "origin": list(prepared.file.origin)}
    shape = list(next(iter(prepared.file.grids.values())).shape[:3])
    record.add(frame, {"file": path.name, "source_hash": source_hash, **place, "shape": shape, **prepared.facts})
    return _line(frame, path, prepared)


def _line(frame: int, path: Path, prepared: Prepared) -> str:
    """Return what is said of a frame."""
    grids = " ".join(prepared.file.grids)
    lost = prepared.facts["mass_dropped"]
    parts = [f"{path.name}  {path.stat().st_size / 1e6:.1f} MB  {grids}"]
    parts += [f"{lost:.2g} of the density dropped"] if lost else []
    parts += [f"{count} voxels of {name} repaired" for name, count in prepared.facts.get("repaired", {}).items()]
    return f"frame   {frame}  {', '.join(parts)}"


def _write_scene(record: Record, out: Path, options: ExportOptions, bodies: list[Body]) -> list[str]:
    """Write the stage or the script that shows the volumes; return its path."""
    if options.format == "usda":
        write_stage(out / STAGE, record.content, bodies, options)
        return [str(out / STAGE)]
    if options.format == "blender":
        record.content["bodies"] = body_facts(bodies)
        record.write()
        shutil.copyfile(BLENDER_SCENE, out / SCRIPT)
        return [str(out / SCRIPT)]
    return []


def _show(record: Record, out: Path, written: list[str], failed: dict[str, str], common) -> None:
    """Print the result."""
    if common.json:
        frames = {
            frame: {k: v for k, v in facts.items() if k != "source_hash"}
            for frame, facts in record.content["frames"].items()
        }
        print(json.dumps({"folder": str(out), "files": written, "frames": frames, "failed": failed}))
    elif written:
        print("\n".join(written))
