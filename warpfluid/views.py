"""The images and angles of one frame: what the reconstruction of Section 3 starts from."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warpfluid.footage import matting

SMALLEST = 8  # pixels; below this there is no pyramid to speak of
SAME_ANGLE_DEG = 1e-3


@dataclass(frozen=True, eq=False)
class Views:
    """Images and angles of one frame (I and Θ of the paper).

    Orthographic cameras turn about the vertical axis: the picture at angle t has
    ``u = x cos t + z sin t`` to the right and ``v = y`` up.

    Attributes:
        images: Light on black, float32, shape (view, u, v), v up and contiguous; Warp arrays are taken too.
            An image may be black all over: a shot may begin before its fire does.
        angles_deg: One angle a view, no two of them equal or 180 apart.
        white: Pixel value of white.

    Raises:
        ValueError: If the images or angles cannot be those of one fluid.
    """

    images: np.ndarray
    angles_deg: tuple[float, ...]
    white: float = 255.0

    def __post_init__(self):
        images = self.images.numpy() if hasattr(self.images, "numpy") else self.images
        images = np.ascontiguousarray(images, dtype=np.float32)
        angles_deg = tuple(float(angle) for angle in np.atleast_1d(self.angles_deg))
        _check_images(images)
        if len(angles_deg) != len(images):
            raise ValueError(f"{len(images)} images came with {len(angles_deg)} angles_deg: give one angle a view")
        problems = angle_problems(angles_deg)
        if problems:
            raise ValueError("\n".join(problems))
        _check_white(self.white)
        object.__setattr__(self, "images", images)
        object.__setattr__(self, "angles_deg", angles_deg)
        object.__setattr__(self, "white", float(self.white))

    @classmethod
    def from_pictures(
        cls, pictures: Sequence[np.ndarray], angles_deg: Sequence[float], white: float | None = None
    ) -> "Views":
        """Make views of pictures as files hold them, their luminance scaled to 0..255.

        Args:
            pictures: One a view, shape (rows, columns) or (rows, columns, 1, 3 or 4), top row first, of any
                type; alpha is left out.
            angles_deg: One angle a view.
            white: Pixel value that becomes 255.  By default 255 for uint8, 65535 for uint16, and for other
                types the brightest value of all pictures.

        Raises:
            ValueError: If the pictures have other shapes, or unlike ones, or the views are refused.
        """
        pictures = [np.asarray(p.numpy() if hasattr(p, "numpy") else p) for p in pictures]
        greys = [matting.luminance(picture) for picture in pictures]
        shapes = sorted({grey.shape for grey in greys})
        if not greys or len(shapes) > 1:
            found = " and ".join(f"{columns} x {rows}" for rows, columns in shapes) or "none"
            raise ValueError(f"pictures must be of one size, found {found}: crop or resize them")
        if white is not None:
            _check_white(white)
        brightest = max((float(grey.max()) for grey in greys if grey.size), default=0.0)
        whites = [white or _full_range(picture.dtype) or brightest or 1.0 for picture in pictures]
        with np.errstate(invalid="ignore", over="ignore"):  # the check of the images names what is not finite
            images = [matting.to_image(grey * (255.0 / top)) for grey, top in zip(greys, whites, strict=True)]
        return cls(np.stack(images), tuple(angles_deg))

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of an image (u, v) [pixel]."""
        return self.images.shape[1:]

    def pictures(self) -> list[np.ndarray]:
        """Return the images as files hold them: float32 (rows, columns), top row first."""
        return [np.ascontiguousarray(image.T[::-1]) for image in self.images]

    def row_sums(self) -> np.ndarray:
        """Return the light in each image row, shape (view, v): equal in all views of one emissive fluid."""
        return self.images.sum(axis=1, dtype=np.float64)


def angle_problems(angles_deg: Sequence[float]) -> list[str]:
    """Return a sentence for each angle that is not finite, and each pair that shows one picture twice."""
    problems = [f"angle {angle} is not a finite number of degrees" for angle in angles_deg if not np.isfinite(angle)]
    finite = [angle for angle in angles_deg if np.isfinite(angle)]
    for second, b in enumerate(finite):
        for a in dict.fromkeys(finite[:second]):  # of two that are the same one is enough
            apart = abs(a - b) % 360.0
            if min(apart, 360.0 - apart) < SAME_ANGLE_DEG:
                problems.append(f"angles {a:g} and {b:g} are the same: give each view its own angle, in degrees")
            elif abs(apart - 180.0) < SAME_ANGLE_DEG:
                problems.append(
                    f"angles {a:g} and {b:g} are 180 degrees apart: one view is the mirror image of "
                    "the other and tells nothing new; leave one out"
                )
    return problems


def _check_images(images: np.ndarray) -> None:
    """Refuse images that are not finite light of a workable size."""
    if images.ndim != 3 or len(images) == 0:
        raise ValueError(f"images must have the shape (view, u, v), at least one view, not {images.shape}")
    if min(images.shape[1:]) < SMALLEST:
        u, v = images.shape[1:]
        raise ValueError(f"images are {u} x {v} pixels: a view must have at least {SMALLEST} x {SMALLEST}")
    if not np.isfinite(images).all():
        raise ValueError("images hold values that are infinite or not numbers: replace them, say by 0")
    if images.min() < 0:
        raise ValueError(f"images hold negative light, down to {images.min():g}: clip them at 0")


def _check_white(white: float) -> None:
    if not (np.isfinite(white) and white > 0):
        raise ValueError(f"white must be a positive pixel value, found {white}")


def _full_range(dtype: np.dtype) -> float | None:
    """Return the white of the integer types that pictures are stored in."""
    return {np.dtype(np.uint8): 255.0, np.dtype(np.uint16): 65535.0}.get(dtype)
