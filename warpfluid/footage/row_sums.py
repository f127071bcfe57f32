"""Row sums of two views: how far they disagree, and the remedy.

Light that no medium absorbs has the same total in every image row of every view.  That checks alignment,
exposure and matting without any ground truth.
"""

from dataclasses import dataclass

import numpy as np

LARGEST_OFFSET = 8  # frames
LARGEST_SHIFT = 16  # pixels


@dataclass(frozen=True, kw_only=True)
class Remedy:
    """How row sums disagree with those of another view, and what would mend it.

    Attributes:
        disagreement: Rms of the difference over the rms of the row sums, 0 to about 1.4.
        time_offset: Play the view this much later [frame], as ``--view-time`` does.
        vertical_shift: Move its pictures up by this much [pixel].
        exposure_scale: Multiply them by this.
        disagreement_after: What would be left.
    """

    disagreement: float
    time_offset: int
    vertical_shift: int
    exposure_scale: float
    disagreement_after: float


def compare_row_sums(reference: np.ndarray, sums: np.ndarray) -> Remedy:
    """Return how far row sums disagree, and the whole offset, shift and scale that mend it.

    Where several remedies do nearly as well, the smallest is given: a steady flame fits at any time.

    Args:
        reference: Row sums of the first view, shape (frame, v).
        sums: Those of another view, same shape.
    """
    offsets = min(LARGEST_OFFSET, len(sums) // 4)
    shifts = min(LARGEST_SHIFT, sums.shape[1] // 4)
    found = []
    for offset in range(-offsets, offsets + 1):
        for shift in range(-shifts, shifts + 1):
            a, b = _overlap(reference, sums, offset, shift)
            scale = rms(a) / rms(b) if b.any() else 1.0
            found.append((disagreement(a, scale * b), abs(offset) + abs(shift), offset, shift, scale))
    enough = 1.05 * min(found)[0] + 0.002
    after, _, offset, shift, scale = min((f for f in found if f[0] <= enough), key=lambda f: (f[1], f[0]))
    return Remedy(
        disagreement=disagreement(reference, sums),
        time_offset=offset,
        vertical_shift=shift,
        exposure_scale=float(scale),
        disagreement_after=after,
    )


def _overlap(a: np.ndarray, b: np.ndarray, offset: int, shift: int) -> tuple[np.ndarray, np.ndarray]:
    """Return what remains of both row sums when b is played later by offset and moved up by shift."""
    for axis, by in ((0, offset), (1, shift)):
        length = a.shape[axis]
        first = [slice(None)] * 2
        second = [slice(None)] * 2
        first[axis] = slice(max(by, 0), length + min(by, 0))
        second[axis] = slice(max(-by, 0), length + min(-by, 0))
        a, b = a[tuple(first)], b[tuple(second)]
    return a, b


def rms(values: np.ndarray) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def disagreement(a: np.ndarray, b: np.ndarray) -> float:
    """Return the rms of the difference over the rms of both."""
    both = np.sqrt((rms(a) ** 2 + rms(b) ** 2) / 2)
    return float(rms(a - b) / both) if both > 0 else 0.0
