"""All the numbers, what they see and where their good values are."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from warpfluid.metrics.pictures import (
    band_w1,
    gradient_ratio,
    gradient_w1,
    log_spectrum,
    magnitudes,
    patch_swd,
    perimeter,
    psnr,
    row_mass,
    silhouette,
    ssim,
    streak,
    wasserstein,
)

SMALLEST_SIDE = 25  # three Laplacian levels of it still hold a 7 x 7 patch


Group = Literal["given", "tuned", "independent", "physical", "pixels", "motion", "volume"]
UNRANKED = ("tuned", "pixels")  # matched by the method itself; or better for a grey average than for a flame


@dataclass(frozen=True)
class Metric:
    """One number of the table.

    The method itself matches what is ``tuned`` and knows nothing of what is ``independent``; ``physical`` compares
    light and place; ``pixels`` are those of unseen views. What has no ``measure`` needs more than a picture and its
    truth: ``given`` the views that the volume was made of, ``motion`` the next frame, ``volume`` the volume.
    """

    name: str  # key in the results
    label: str  # for people
    best: Literal["low", "high", "one"]  # where the good values are
    group: Group
    meaning: str  # what it sees
    measure: Callable[[np.ndarray, np.ndarray], float] | None = None
    anywhere: bool = True  # holds between views of one moment from any two angles

    @property
    def ranks(self) -> bool:
        """Whether a better value is a better result."""
        return self.group not in UNRANKED

    def badness(self, value: float) -> float:
        """Return how far a value is from the best one, for ranking."""
        return {"low": value, "high": -value, "one": abs(value - 1)}[self.best]


def compare_pictures(candidate: np.ndarray, truth: np.ndarray) -> dict[str, float]:
    """Measure a picture against the true picture at the same angle.

    Args:
        candidate: Grey picture, shape (rows, columns).
        truth: The true one, same shape.

    Returns:
        The value of every metric of pictures, by name, in the order of ``METRICS``.

    Raises:
        ValueError: If the shapes differ or are too small, a value is not finite, or the truth is black.
    """
    candidate, truth = _pair(candidate, truth)
    return {m.name: float(m.measure(candidate, truth)) for m in METRICS.values() if m.measure}


def appearance_distance(candidate: np.ndarray, references: Sequence[np.ndarray]) -> dict[str, float]:
    """Measure a picture against footage from other angles, for want of the truth.

    Only metrics that hold between different angles take part. Views of one fluid differ, too: the references'
    distance from each other is the floor, not zero.

    Args:
        candidate: Grey picture, shape (rows, columns).
        references: Pictures of the same moment from any angle, same shape.

    Returns:
        The mean over the references of every metric that needs no truth, by name.

    Raises:
        ValueError: As ``compare_pictures``, or if there are no references.
    """
    if len(references) == 0:
        raise ValueError("references is empty; give at least one input picture")
    pairs = [_pair(candidate, reference) for reference in references]
    chosen = [m for m in METRICS.values() if m.anywhere and m.measure]
    return {m.name: float(np.mean([m.measure(*pair) for pair in pairs])) for m in chosen}


METRICS: dict[str, Metric] = {
    metric.name: metric
    for metric in (
        Metric("input_psnr", "PSNR, given views [dB]", "high", "given", "how exactly the footage comes back"),
        Metric("input_ssim", "SSIM, given views", "high", "given", "the same, by structure"),
        Metric("intensity_w1", "Intensity W1", "low", "tuned", "grey values", wasserstein),
        Metric("band_w1", "Sub-band W1", "low", "tuned", "detail by scale and direction", band_w1),
        Metric("patch_swd", "Patch SWD", "low", "independent", "small patches at three scales", patch_swd),
        Metric("log_spectrum", "Log spectrum", "low", "independent", "blur, over-sharpening", log_spectrum),
        Metric("gradient_w1", "Gradient W1", "low", "independent", "steepness of edges", gradient_w1),
        Metric("magnitudes", "Magnitudes", "low", "independent", "filaments against speckle", magnitudes),
        Metric("perimeter", "Perimeter", "low", "independent", "wisps against blobs", perimeter),
        Metric("gradient_ratio", "Gradient ratio", "one", "independent", "sharpness across", gradient_ratio),
        Metric("streak", "Streak", "one", "independent", "combs between heights", streak),
        Metric("row_mass", "Row mass", "low", "physical", "light at every height", row_mass),
        Metric("silhouette", "Silhouette", "low", "physical", "lit area in its place", silhouette, False),
        Metric("psnr", "PSNR, unseen views [dB]", "high", "pixels", "pixel by pixel: favours blur", psnr, False),
        Metric("ssim", "SSIM, unseen views", "high", "pixels", "structure in its place: favours blur", ssim, False),
        Metric("total", "Total density", "one", "physical", "all light, over the truth's"),
        Metric("left_over", "Left by motion", "one", "motion", "above one is flicker, below is calmer"),
        Metric("grid_index", "Grid index", "one", "volume", "slices woven along the rays"),
    )
}


def _pair(candidate: np.ndarray, truth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return both pictures as float64, checked."""
    pair = np.asarray(candidate, np.float64), np.asarray(truth, np.float64)
    shapes = pair[0].shape, pair[1].shape
    if shapes[0] != shapes[1] or pair[0].ndim != 2:
        found = " and ".join(map(str, shapes))
        raise ValueError(f"candidate and truth have shapes {found}; two grey pictures of one size are needed")
    if min(shapes[0]) < SMALLEST_SIDE:
        raise ValueError(f"pictures are {shapes[0]}; at least {SMALLEST_SIDE} pixels a side are needed")
    for name, picture in zip(("candidate", "truth"), pair, strict=True):
        if not np.isfinite(picture).all():
            raise ValueError(f"{name} holds values that are not finite; replace them by 0 first")
    if not (pair[1] > 0).any():
        raise ValueError("truth is black everywhere, so nothing can be measured in it; leave this frame out")
    return pair
