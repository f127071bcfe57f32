"""
Visual hull and least squares
=============================

Two pictures do not determine a volume. What they do say is where it cannot be: a voxel that any view sees as black
is empty. The rest is the visual hull. Inside it, least squares (Eq. 3) finds a volume that agrees with the inputs.
"""

# %%
# The packaged fire, seen from the front and from the right side.

import numpy as np
from gallery import panel, sample, save, shown, stack

import warpfluid as wf
from warpfluid.rendering.turntable import slices_picture, strip

views = sample(width=64)
front, side = (shown(image, zoom=3) for image in views.images)
save("02_inputs.png", panel({"front, 0 degrees": front, "side, 90 degrees": side}))

# %%
# With two views at right angles the hull is a rectangle at every height. ``lsm`` solves for the volume inside it by
# conjugate gradients, and the number of steps is the only regularisation.

result = wf.reconstruct(views, wf.ReconstructOptions(method="lsm"), device="cpu")
print(f"the hull fills {result.hull_share:.1%} of the box")
for angle, image in zip(views.angles_deg, views.images, strict=True):
    error = result.render([angle])[0] - image
    print(f"view {angle:g}: rms error {np.sqrt(np.mean(error**2)):.2f} of 255 grey levels")

# %%
# The inputs are met, the views between are not: they are the blur that all possible fires have in common. Seen from
# above, the slices are woven along the two viewing directions. This is what appearance transfer removes.

angles_deg = (0, 15, 30, 45, 60, 75, 90)
heights = [int(part * (views.size[1] - 1)) for part in (0.15, 0.3, 0.45, 0.6, 0.75)]
from_above = slices_picture(result.volume, heights).repeat(2, axis=0).repeat(2, axis=1)
save("02_least_squares.png", stack([strip(result.volume, angles_deg), from_above]))
