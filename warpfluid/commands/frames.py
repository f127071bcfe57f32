"""The frames of a shot, made by one process or many, and written down as they come."""

from dataclasses import dataclass, field
from pathlib import Path

from warpfluid.cluster.pools import Asked, open_pool
from warpfluid.cluster.spread import Chain, spread
from warpfluid.errors import CannotWriteError, changed_since, describe, writing
from warpfluid.files.sequences import format_frames
from warpfluid.footage.shot import Shot
from warpfluid.progress import FrameBar, Progress
from warpfluid.run import RECORDS, SETTINGS, Run
from warpfluid.settings import Settings


@dataclass(frozen=True, kw_only=True)
class Work:
    """What is to be made.

    Attributes:
        run: Where to write; begun already.
        shot: The footage.
        settings: All choices made.
        records: Of the frames that the run has.
        need: Memory of a frame [byte].
        debug_dir: Folder for the pictures of every iteration.
        failed: What went wrong, by frame.
    """

    run: Run
    shot: Shot
    settings: Settings
    records: dict[int, dict]
    need: int
    debug_dir: Path | None = None
    failed: dict[str, str] = field(default_factory=dict)


def check_footage(run: Run, shot: Shot, settings: Settings) -> None:
    """Check that the pictures of finished frames are still the same; others may have come since.

    Of other views nothing is said: ``Run.begin`` refuses them.

    Raises:
        ValueError: If any has changed.
    """
    there = (run.folder / SETTINGS).is_file()
    if not there or run.settings().get("views") != settings.to_dict()["views"]:
        return
    changed: dict[str, list[int]] = {}
    for frame, record in run.records().items():
        if "inputs" not in record or not all(frame in source.frames for source in shot.sources):
            continue
        for angle, digest in shot.hashes(frame).items():
            if record["inputs"].get(angle, digest) != digest:
                changed.setdefault(angle, []).append(frame)
    if changed:
        found = ", ".join(
            f"the footage at {angle} degrees of frame{'s' * (len(frames) > 1)} {format_frames(frames)}"
            for angle, frames in changed.items()
        )
        raise ValueError(changed_since(run.folder, [found]))


def reconstruct_frames(work: Work, asked: Asked, device, log: Progress) -> None:
    """Make the frames that a run lacks, and those that would be made otherwise now; what fails is noted.

    Args:
        work: What is to be made.
        asked: Who shall do it, reached.
        device: The Warp device that one worker would use.
        log: Progress.

    Raises:
        KeyboardInterrupt: If it is stopped; it says how to go on.
    """
    from warpfluid.reconstruction.systems import round_count

    frames, chains = _plan(work, log)
    if not chains:
        return
    if not asked.is_alone and len(chains) == 1 < len(frames):
        log.notes(["each frame builds on the one before: cut the shot with --piece, or choose --coherence none"])
    count = 0
    try:
        with (
            log.frames(frames, round_count(work.settings.reconstruct)) as bar,
            _open(work, asked, device, len(chains), bar, log) as pool,
        ):
            for task, outcome in spread(chains, pool):
                _note(work, {"frame": task.frame, **outcome}, bar)
                count += 1
    except KeyboardInterrupt as stop:
        there = f"stopped after {count} of {len(frames)} frames"
        raise KeyboardInterrupt(f"{there}; to continue: warpfluid reconstruct -o {work.run.folder} --resume") from stop
    except CannotWriteError as error:
        work.failed["the records"] = describe(error)
    except ConnectionError as error:
        work.failed["the cluster"] = describe(error)
    _name_the_rest(work)


def _plan(work: Work, log: Progress) -> tuple[list[int], list[Chain]]:
    """Return the frames to make if all succeed, and chains that make them, or fewer or more where some do not."""
    from warpfluid.reconstruction.pieces import frame_chain, keep_lasting, make_pieces

    def forget(frames: list[int]) -> None:
        which = f"frames {format_frames(frames)} are" if len(frames) > 1 else f"frame {frames[0]} is"
        log.notes([f"{which} made again: what comes before has changed"])
        with writing(work.run.folder / RECORDS):
            work.run.forget(frames)

    first = work.run.settings()["made-with"].get("first")
    pieces, wanted = make_pieces(work.shot, work.settings.reconstruct, first), work.shot.frames
    seen = [frame for frame in {*wanted, *work.records} if all(frame in source.frames for source in work.shot.sources)]
    records, known = keep_lasting(work.records, seen), sorted(seen)
    frames = pieces.to_make(wanted, known, records)
    if len(frames) < len(wanted):
        log.line(f"resume  {len(wanted) - len(frames)} of {len(wanted)} frames are there")
    others = [frame for frame in pieces.to_make(known, known, records) if frame not in wanted]
    if others:
        log.notes([_name_others(others, work.run)])
    groups = [group for group in pieces.chains(known) if not set(frames).isdisjoint(group)]
    return frames, [frame_chain(pieces, group, wanted, known, records, forget) for group in groups]


def _name_others(frames: list[int], run: Run) -> str:
    """Return what is to be said of frames that are there, and go otherwise with what is asked for now."""
    named = format_frames(frames)
    which = f"frames {named} are" if len(frames) > 1 else f"frame {named} is"
    go_on = f"warpfluid reconstruct -o {run.folder} --resume --frames {named}"
    return f"{which} kept, but would be made otherwise beside those that are asked for now; to make them, too: {go_on}"


def _open(work: Work, asked: Asked, device, tasks: int, bar: FrameBar, log: Progress):
    """Return who works."""
    from warpfluid.reconstruction.sequence import FrameJob
    from warpfluid.report.panels import panel_writer

    observer = panel_writer(work.debug_dir, work.settings.output.look) if work.debug_dir else None
    job = FrameJob(work.shot, work.settings, work.run, observer)
    return open_pool(job, asked, device, tasks=tasks, need=work.need, progress=bar.iteration, say=log.line)


def _note(work: Work, record: dict, bar: FrameBar) -> None:
    """Write down what came of a frame."""
    if "error" in record:
        work.failed[f"frame {record['frame']}"] = record["error"]
    else:
        work.run.add_record(record)
    bar.finished(record)


def _name_the_rest(work: Work) -> None:
    """Note the frames that were not even tried."""
    records = work.run.records()
    left = [frame for frame in work.shot.frames if frame not in records and f"frame {frame}" not in work.failed]
    if left:
        work.failed[f"frames {format_frames(left)}"] = "not made"
