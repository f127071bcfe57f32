"""Frame after frame: a shot becomes a run on disk."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from warpfluid.footage.shot import Shot
from warpfluid.footage.tone import apply_shoulder
from warpfluid.metrics import psnr
from warpfluid.reconstruction.coherence import follow
from warpfluid.reconstruction.em import reconstruct
from warpfluid.reconstruction.pieces import FrameTask
from warpfluid.reconstruction.result import Observer, Reconstruction
from warpfluid.run import Run, stored
from warpfluid.settings import Settings
from warpfluid.views import Views

Progress = Callable[[int, int, float], None]
Before = tuple[int, np.ndarray, Views]


@dataclass
class FrameJob:
    """Reconstructs frames of a shot into a run; it can be sent to another process.

    Attributes:
        shot: The footage.
        settings: The method and the form of the files; choices left to the footage are made for the whole shot, or
            the frames would flicker (``Inspection.options``).
        run: Where to write; begun already.
        observer: Called with a frame, returns what its iterations are shown to.
    """

    shot: Shot
    settings: Settings
    run: Run
    observer: Callable[[int], Observer] | None = None
    _last: Before | None = None
    _lead: tuple[tuple[int, ...], Before | None] = ((), None)

    def __getstate__(self) -> dict:
        """Return what another process needs."""
        return self.__dict__ | {"_last": None, "_lead": ((), None)}

    def __call__(self, task: FrameTask, device, progress: Progress) -> dict:
        """Reconstruct a frame and write its volume.

        Args:
            task: The frame, and what it starts from.
            device: Where to compute.
            progress: Called with frame, iteration and energy.

        Returns:
            Its record, to be added to the run.

        Raises:
            ValueError: If it cannot be made.
            OSError: If its pictures cannot be read.
            CannotWriteError: If its volume cannot be written.
        """
        begin = time.perf_counter()
        before = self._before(task, device)
        towards = (self._led(task.towards, device)[1], task.weight) if task.towards else None
        told = {"progress": progress, "observer": self.observer}
        result, views, carried = self._model(task.frame, before, device, towards=towards, **told)
        record = {
            "carried": carried,
            **task.to_dict(),
            "origin": self.run.volume_id(task.before) if task.before is not None else None,
            "inputs": self.shot.hashes(task.frame),
            **_numbers(result, views, self.settings.reconstruct.shoulder),
            "seconds": round(time.perf_counter() - begin, 3),
        }
        output = self.settings.output
        record = self.run.write_volume(task.frame, result.volume, output, record)
        self._last = task.frame, stored(result.volume, output), views
        return record | {"volume": self.run.volume_id(task.frame)}

    def _before(self, task: FrameTask, device) -> Before | None:
        """Return number, volume and views of the frame before: of this run, or made to lead up to this one."""
        if task.before is not None:
            if self._last is None or self._last[0] != task.before:
                self._last = task.before, self.run.volume(task.before), self.shot.views(task.before)
            return self._last
        return self._led(task.lead, device) if task.lead else None

    def _led(self, frames: tuple[int, ...], device) -> Before:
        """Return number, volume and views of the last of some frames, which are not kept; the first starts anew."""
        there, before = self._lead
        if frames[: len(there)] != there:
            there, before = (), None
        for frame in frames[len(there) :]:
            result, views, _ = self._model(frame, before, device)
            before = frame, stored(result.volume, self.settings.output), views
        self._lead = frames, before
        return before

    def _model(
        self, frame: int, before: Before | None, device, *, progress=None, observer=None, towards=None
    ) -> tuple[Reconstruction, Views, bool]:
        """Return a frame's reconstruction and views, and whether it was carried from the one before."""
        views, options = self.shot.views(frame), self.settings.reconstruct
        report = (lambda iteration, energy: progress(frame, iteration, energy)) if progress else None
        watched = {"progress": report, "observe": observer(frame) if observer else None, "device": device}
        result = follow(before[1], before[2], views, options, towards=towards, **watched) if before else None
        if result is not None:
            return result, views, True
        return reconstruct(views, options, **watched), views, False


def _numbers(result: Reconstruction, views: Views, shoulder: float) -> dict:
    """Return what a record tells of a reconstruction."""
    rendered = apply_shoulder(result.render(views.angles_deg), shoulder)
    return {
        "energies": result.energies.tolist(),
        **({"walk": result.walk.round(6).tolist()} if len(result.walk) else {}),
        "hull_share": result.hull_share,
        "input_psnr": [round(psnr(*pair, views.white), 2) for pair in zip(rendered, views.images, strict=True)],
        "total": float(result.volume.sum(dtype=np.float64)),
    }
