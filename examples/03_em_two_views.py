"""
Two views: least squares against appearance transfer
====================================================

The method in one call (Fig. 3). The M-step renders the volume from all around and gives every picture the sub-band
histograms of its two neighbouring inputs. The E-step fits the volume to these pictures. The energy (Eq. 1) falls.
"""

# %%
# Front and side of the packaged fire. ``reconstruct`` returns the volume, and that of least squares, its start.

import numpy as np
from gallery import plot, sample, save, stack

import warpfluid as wf
from warpfluid.rendering.turntable import slices_picture, strip

views = sample(width=64)
result = wf.reconstruct(views, device="cpu")
print(result)

# %%
# Least squares above, appearance transfer below, from 0 to 90 degrees; then slices from above of both.

angles_deg = (0, 15, 30, 45, 60, 75, 90)
save("03_views.png", stack([strip(volume, angles_deg) for volume in (result.initial, result.volume)]))
heights = [int(part * (views.size[1] - 1)) for part in (0.15, 0.3, 0.45, 0.6, 0.75)]
white = float(np.quantile(result.volume[result.volume > 0], 0.999))
slices = [slices_picture(volume, heights, white=white) for volume in (result.initial, result.volume)]
save("03_slices.png", stack(slices).repeat(2, axis=0).repeat(2, axis=1))

# %%
# The energy after each M-step and after each E-step. Both fall from one iteration to the next. Within an iteration the
# E-step lowers it; the M-step is an approximation and may raise it (here it does, once).

iterations = np.arange(len(result.energies)) + 1
after_m, after_e = result.energies.T / 1e6
save(
    "03_energy.png",
    plot(
        {"after the M-step": (iterations, after_m), "after the E-step": (iterations, after_e)},
        "energy (Eq. 1) [million] over the iteration",
    ),
)
assert (np.diff(result.energies, axis=0) < 0).all()
assert (after_e < after_m).all()

# %%
# The inputs are met almost exactly.

for angle, image in zip(views.angles_deg, views.images, strict=True):
    error = np.sqrt(np.mean((result.render([angle])[0] - image) ** 2))
    print(f"view {angle:g}: {20 * np.log10(255 / error):.1f} dB")
