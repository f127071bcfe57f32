"""
Fig. 4: the steerable pyramid
=============================

Appearance is described by the histograms of a picture's sub-bands. The third-order steerable pyramid splits a picture
into scales, and every scale into four orientations: here four of a picture of the packaged fire, the finest residual
left out as in the paper. It is a tight frame: coefficients have the pixels' energy, and it collapses to its picture.
"""

import numpy as np
from common import pick, save, tell
from gallery import band_shown, captioned, in_a_row, panel, sample, shown, stack

from warpfluid.reconstruction.pyramid import LOWPASS, SteerablePyramid

HEIGHT = pick(2, 4, 4)

# %%
# Columns are orientations. Coarse scales are enlarged to the size of the finest.

image = sample(width=pick(32, 96, 96)).images[0]
pyramid = SteerablePyramid(image.shape, HEIGHT)
bands = pyramid.build(image)
rows = [
    captioned(in_a_row(band_shown(bands[scale, k], 2**scale) for k in range(4)), f"scale {scale + 1}")
    for scale in range(HEIGHT)
]
picture = shown(image, zoom=1)
lowest = band_shown(bands[LOWPASS], 2**HEIGHT)[: picture.shape[0], : picture.shape[1]]
save("fig04", stack([panel({"picture": picture, "low-pass residual": lowest}), *rows]))

# %%
# Collapsing inverts building; coefficients have the energy of the pixels; a turned picture has turned bands.

turned = SteerablePyramid(image.T.shape, HEIGHT).build(np.rot90(image))
pairs = [(turned[0, (k + 2) % 4], np.rot90(bands[0, k])) for k in range(4)]
error = max(float(np.abs(np.abs(a) - np.abs(b)).max()) for a, b in pairs)
energy = sum(float((band.astype(np.float64) ** 2).sum()) for band in bands.values())
tell(
    "fig04",
    {
        f"{HEIGHT} scales, third order": {
            "largest error after collapsing [grey level]": float(np.abs(pyramid.collapse(bands) - image).max()),
            "energy over the pixels'": energy / float((image.astype(np.float64) ** 2).sum()),
            "finest bands of the picture turned by 90 degrees, largest difference": error,
            "largest coefficient of them": float(max(np.abs(bands[0, k]).max() for k in range(4))),
        }
    },
)
