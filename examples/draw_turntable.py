"""
The film at the top of the README
=================================

The two inputs, then the volume of least squares and that of appearance transfer, turning side by side. Writes
``turntable.webp``, and ``stills.png`` with seven angles of both.
"""

# %%
# Least squares is the first step of a reconstruction and is returned with it.

import numpy as np
from gallery import CAPTION, captioned, folder, sample, save, stack
from PIL import Image
from scipy.ndimage import zoom

import warpfluid as wf
from warpfluid.rendering.ramps import apply_ramp
from warpfluid.rendering.turntable import in_a_row, strip, turntable_angles

PICTURES, RATE, ZOOM = 72, 18.0, 3.0

views = sample()
result = wf.reconstruct(views)
print(result)

# %%
# Every picture has the same exposure, that of the footage. They are enlarged before they are coloured.


def enlarged(image: np.ndarray, factor: float = ZOOM) -> np.ndarray:
    """Return the middle three quarters of an image (u, v) as a smooth colour picture."""
    edge = len(image) // 8
    return apply_ramp(zoom(image[edge:-edge].T[::-1], factor, order=3, mode="nearest", grid_mode=True), "fire")


def turning(volume: np.ndarray) -> list[np.ndarray]:
    """Return the pictures of a full turn."""
    images = wf.Projector(turntable_angles(PICTURES), volume.shape).project(volume)
    return [enlarged(image) for image in images]


half = (ZOOM - CAPTION / views.size[1]) / 2
front, side = (enlarged(image, half) for image in views.images)
inputs = np.concatenate([captioned(front, "input: front"), captioned(side, "input: side")])

# %%
# One picture of the film: the inputs, least squares, appearance transfer.

film = []
for pair in zip(turning(result.initial), turning(result.volume), strict=True):
    film.append(in_a_row([inputs, captioned(pair[0], "least squares"), captioned(pair[1], "appearance transfer")]))

# %%
# The film repeats forever. WebP with losses takes a third of the space of a GIF.

path = folder() / "turntable.webp"
first, *others = [Image.fromarray(picture) for picture in film]
first.save(path, save_all=True, append_images=others, duration=round(1000 / RATE), loop=0, quality=75, method=4)
print(f"wrote {path}: {path.stat().st_size / 1000:.0f} kB, {first.width} x {first.height}, {len(film)} pictures")

# %%
# Stills for pages that do not move.

angles_deg = (0, 15, 30, 45, 60, 75, 90)
save("stills.png", stack([strip(volume, angles_deg) for volume in (result.initial, result.volume)]))
