"""The flow of a whole shot as files: every view, from each frame to the next."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import warp as wp

from warpfluid.footage.matting import LIT
from warpfluid.footage.shot import Shot
from warpfluid.footage.sources import spread
from warpfluid.motion.flow_files import saturated_speed, write_flow
from warpfluid.motion.optical_flow import optical_flow

SAMPLED_PAIRS = 3  # decide on one speed of full saturation, so that the colours of a shot do not flicker


@dataclass(frozen=True, kw_only=True)
class PairFlow:
    """The flow of one view from a frame to the next; speeds over the lit pixels of the earlier picture [pixel]."""

    frame: int
    later: int
    angle_deg: float
    median: float
    fast: float  # 95 % of the pixels are slower
    files: tuple[str, ...]

    def to_dict(self) -> dict:
        """Return plain numbers, strings and lists."""
        return asdict(self) | {"files": list(self.files)}

    def line(self) -> str:
        """Return a summary in plain text."""
        speeds = f"median {self.median:.2f}, 95 % below {self.fast:.2f} px"
        return f"frame {self.frame} to {self.later}  view {self.angle_deg:g}  {speeds}  {self.files[0]}"


def write_shot_flow(shot: Shot, folder: str | Path, *, method: str, device: wp.Device) -> Iterator[PairFlow]:
    """Measure and write the flow of every view between successive frames, pair after pair.

    Args:
        shot: Footage of one or more views; nothing is written of a single frame.
        folder: Where to write, see ``write_flow``; it must exist.
        method: Optical flow, see ``optical_flow``.
        device: Where to compute.

    Yields:
        What was written for a frame and a view, once it is.

    Raises:
        OSError: If a file cannot be written.
    """
    pairs = list(pairwise(shot.frames))
    sample = [flow for pair in spread(pairs, SAMPLED_PAIRS) for flow, _ in _measure(shot, pair, method, device)]
    full = saturated_speed(np.stack(sample, axis=1)) if sample else 1.0
    for frame, later in pairs:
        measured = _measure(shot, (frame, later), method, device)
        for angle_deg, (flow, lit) in zip(shot.angles_deg, measured, strict=True):
            files = write_flow(folder, frame, angle_deg, flow, full=full)
            speeds = np.hypot(*flow)[lit] if lit.any() else np.zeros(1)
            median, fast = (float(speed) for speed in np.percentile(speeds, [50, 95]))
            yield PairFlow(
                frame=frame,
                later=later,
                angle_deg=angle_deg,
                median=median,
                fast=fast,
                files=tuple(map(str, files)),
            )


def _measure(
    shot: Shot, frames: tuple[int, int], method: str, device: wp.Device
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Measure the flow of each view between two frames, and where its first picture is lit."""
    now, later = map(shot.views, frames)
    for a, b in zip(now.images, later.images, strict=True):
        yield optical_flow(a, b, method=method, white=now.white, device=device), a > LIT
