"""
One view
========

A single clip is what most people have. The paper uses the front picture as the side picture too; the volume is then
symmetric, and square from above. Here the front alone is a measurement. The mirrored front says what the side looks
like, and the hull is a circle at every height. What is behind is invented, in the style of the front.
"""

# %%
# The same front, once with the paper's choices and once with ours.

import numpy as np
from gallery import sample, save, stack

import warpfluid as wf
from warpfluid.rendering.turntable import slices_picture, strip

front = sample(width=64, sides=("front",))
paper = wf.reconstruct(front, wf.ReconstructOptions.paper(), device="cpu")
ours = wf.reconstruct(front, device="cpu")

# %%
# Above the paper's choices, below ours, from 0 to 180 degrees; then slices from above.

angles_deg = (0, 30, 60, 90, 120, 150, 180)
save("04_views.png", stack([strip(result.volume, angles_deg) for result in (paper, ours)]))
heights = [int(part * (front.size[1] - 1)) for part in (0.15, 0.3, 0.45, 0.6, 0.75)]
slices = [slices_picture(result.volume, heights) for result in (paper, ours)]
save("04_slices.png", stack(slices).repeat(2, axis=0).repeat(2, axis=1))

# %%
# The paper's volume is its own mirror image in the diagonal plane x = z.

for name, result in (("paper", paper), ("ours", ours)):
    swapped = result.volume.transpose(1, 0, 2)
    alike = np.corrcoef(result.volume.ravel(), swapped.ravel())[0, 1]
    print(f"{name:>5}: correlation of the volume with its mirror image {alike:.3f}")
