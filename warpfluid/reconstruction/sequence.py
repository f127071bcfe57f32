"""Frame after frame: a shot becomes a run on disk."""

import time
from collections.abc import Callable, Iterable, Iterator

import numpy as np

from warpfluid.errors import describe
from warpfluid.footage.shot import Shot
from warpfluid.metrics import psnr
from warpfluid.reconstruction.coherence import follow
from warpfluid.reconstruction.em import reconstruct
from warpfluid.reconstruction.inputs import apply_shoulder
from warpfluid.reconstruction.result import Observer
from warpfluid.run import Run, stored
from warpfluid.settings import Settings
from warpfluid.views import Views

FARTHEST = 2  # pictures that a frame is carried over; across a wider gap motion cannot be measured

Progress = Callable[[int, int, float], None]


def reconstruct_frames(
    shot: Shot,
    settings: Settings,
    run: Run,
    *,
    device=None,
    frames: Iterable[int] | None = None,
    progress: Progress | None = None,
    observer: Callable[[int], Observer] | None = None,
) -> Iterator[dict]:
    """Reconstruct frames into a run, one after the other, each from the one before where that is coherent.

    Args:
        shot: The footage.
        settings: The method and the form of the files; choices left to the footage are made for the whole shot, or
            the frames would flicker (``Inspection.options``).
        run: Where to write; begun already.
        device: Where to compute.
        frames: Which frames; all of the shot by default.
        progress: Called with frame, iteration and energy.
        observer: Called with a frame, returns what its iterations are shown to.

    Yields:
        The record of every frame; one that failed has the key ``error``.
    """
    before: tuple[int, np.ndarray, Views] | None = None
    for frame in shot.frames if frames is None else frames:
        try:
            if settings.reconstruct.coherence == "flow":
                before = _frame_before(shot, run, frame, before)
            record, volume, views = _reconstruct_frame(shot, settings, run, frame, before, device, progress, observer)
            before = (frame, volume, views)
            yield record
        except Exception as error:  # one frame must not end the run, whichever library gave up
            yield {"frame": frame, "error": describe(error)}


def _frame_before(shot: Shot, run: Run, frame: int, latest: tuple | None) -> tuple[int, np.ndarray, Views] | None:
    """Return number, volume and views of the frame before, from this run or from an earlier part of it."""
    done = run.records()
    wanted = max((number for number in {*shot.frames, *done} if number < frame), default=None)
    if wanted not in done or frame - wanted > FARTHEST * shot.step:
        return None
    return latest if latest and latest[0] == wanted else (wanted, run.volume(wanted), shot.views(wanted))


def _reconstruct_frame(
    shot: Shot, settings: Settings, run: Run, frame: int, before: tuple | None, device, progress, observer
) -> tuple[dict, np.ndarray, Views]:
    """Reconstruct and write a frame; return its record, its volume as stored, and its views."""
    begin, result = time.perf_counter(), None
    views, options = shot.views(frame), settings.reconstruct
    report = (lambda iteration, energy: progress(frame, iteration, energy)) if progress else None
    observe = observer(frame) if observer else None
    if before and options.coherence == "flow" and options.method == "appearance-transfer":
        result = follow(before[1], before[2], views, options, progress=report, observe=observe, device=device)
    carried = result is not None
    if not carried:
        result = reconstruct(views, options, progress=report, observe=observe, device=device)
    rendered = apply_shoulder(result.render(views.angles_deg), options.shoulder)
    record = {
        "carried": carried,
        "energies": result.energies.tolist(),
        **({"walk": result.walk.round(6).tolist()} if len(result.walk) else {}),
        "hull_share": result.hull_share,
        "input_psnr": [round(psnr(*pair, views.white), 2) for pair in zip(rendered, views.images, strict=True)],
        "total": float(result.volume.sum(dtype=np.float64)),
        "seconds": round(time.perf_counter() - begin, 3),
    }
    written = run.write_frame(frame, result.volume, settings.output, record)
    return written, stored(result.volume, settings.output), views
