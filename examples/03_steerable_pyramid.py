"""
The steerable pyramid (Fig. 4)
==============================

Appearance is described by the histograms of a picture's sub-bands. The third-order steerable pyramid splits a
picture into scales, and every scale into four orientations. It is a tight frame: the coefficients have the same
energy as the pixels, and the pyramid collapses to the picture it was built from, for every size of picture.
"""

# %%
# Decompose a picture of fire into four scales. Images have the axes (u, v).

import numpy as np
from gallery import band_shown, in_a_row, panel, sample, save, shown, stack

from warpfluid.reconstruction.pyramid import HIGHPASS, LOWPASS, SteerablePyramid

image = sample().images[0]
pyramid = SteerablePyramid(image.shape, height=4)
bands = pyramid.build(image)
for scale in range(pyramid.height):
    print(f"scale {scale}: {pyramid.order + 1} bands of {pyramid.sizes[scale]}")

# %%
# The panels of Fig. 4: one row a scale, one column an orientation; grey is zero. Below are what is finer than all
# bands (left out in the paper's figure) and what is coarser.

rows = [in_a_row(band_shown(bands[scale, band]) for band in range(4)) for scale in range(4)]
save("03_bands.png", stack(rows))
save(
    "03_residuals.png",
    panel({"picture": shown(image, "gray"), "high-pass residual": band_shown(bands[HIGHPASS], zoom=2)}),
)

# %%
# Collapsing inverts building, and energy is preserved (Parseval).

error = np.abs(pyramid.collapse(bands) - image).max()
energy = sum(float(np.vdot(band, band)) for band in bands.values())
print(f"largest error after collapsing: {error:.1e} grey levels")
print(f"energy of the coefficients over that of the pixels: {energy / float(np.vdot(image, image)):.6f}")
print(f"low-pass residual: {bands[LOWPASS].shape}")
