"""Frame after frame: a shot becomes a run on disk."""

import time
from collections.abc import Callable, Iterable, Iterator

import numpy as np

from warpfluid.errors import describe
from warpfluid.metrics import psnr
from warpfluid.reconstruction.em import reconstruct
from warpfluid.reconstruction.inputs import apply_shoulder
from warpfluid.run import Run
from warpfluid.settings import Settings
from warpfluid.shot import Shot

Progress = Callable[[int, int, float], None]


def reconstruct_frames(
    shot: Shot,
    settings: Settings,
    run: Run,
    *,
    device=None,
    frames: Iterable[int] | None = None,
    progress: Progress | None = None,
) -> Iterator[dict]:
    """Reconstruct frames into a run, one after the other.

    Args:
        shot: The footage.
        settings: The method and the form of the files; choices left to the footage are made for the whole shot, or
            the frames would flicker (``Inspection.options``).
        run: Where to write; begun already.
        device: Where to compute.
        frames: Which frames; all of the shot by default.
        progress: Called with frame, iteration and energy.

    Yields:
        The record of every frame; one that failed has the key ``error``.
    """
    for frame in shot.frames if frames is None else frames:
        try:
            yield _reconstruct_frame(shot, settings, run, frame, device, progress)
        except Exception as error:  # one frame must not end the run, whichever library gave up
            yield {"frame": frame, "error": describe(error)}


def _reconstruct_frame(shot: Shot, settings: Settings, run: Run, frame: int, device, progress: Progress | None) -> dict:
    begin = time.perf_counter()
    views = shot.views(frame)
    report = (lambda iteration, energy: progress(frame, iteration, energy)) if progress else None
    result = reconstruct(views, settings.reconstruct, progress=report, device=device)
    rendered = apply_shoulder(result.render(views.angles_deg), settings.reconstruct.shoulder)
    record = {
        "energies": result.energies.tolist(),
        "hull_share": result.hull_share,
        "input_psnr": [round(psnr(*pair, views.white), 2) for pair in zip(rendered, views.images, strict=True)],
        "total": float(result.volume.sum(dtype=np.float64)),
        "seconds": round(time.perf_counter() - begin, 3),
    }
    return run.write_frame(frame, result.volume, settings.output, record)
