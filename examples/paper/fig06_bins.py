"""
Fig. 6: histograms change smoothly with the angle
=================================================

Nineteen views of the synthetic fire from 0 to 90 degrees. How a bin of their histograms changes, and the straight line
that Eq. 4 draws between the first and the last one.
"""

import numpy as np
from common import project, save, tell
from gallery import plot
from scenes import truth

BINS, SHOWN = 26, (5, 13, 21)  # of 256 grey levels; the paper shows three of its bins
ANGLES = np.arange(0, 91, 5)

# %%
# The share of lit pixels in each bin, at every angle.

images = project(truth("fire"), ANGLES)
edges = np.linspace(1, 255, BINS + 1)
shares = np.array([np.histogram(image, edges)[0] / max((image > 1).sum(), 1) for image in images])
part = (ANGLES / 90)[:, None]
straight = (1 - part) * shares[0] + part * shares[-1]
nearest = np.where(part < 0.5, shares[0], shares[-1])
front = np.broadcast_to(shares[0], shares.shape)

# %%
# Mean distance of the histograms between the inputs from the true ones: half the sum over bins, 0 to 1.

inner = slice(1, -1)
rows = {
    name: {
        "mean distance": float(np.abs(found - shares)[inner].sum(axis=1).mean() / 2),
        **{f"bin {k}": float(np.abs(found - shares)[inner, k - 1].mean() / shares[:, k - 1].mean()) for k in SHOWN},
    }
    for name, found in (("linear (Eq. 4)", straight), ("nearest input", nearest), ("front alone", front))
}
rows["one true view from the next, 5 degrees"] = {
    "mean distance": float(np.abs(np.diff(shares, axis=0)).sum(1).mean() / 2)
}
tell("fig06", rows)

# %%
# The transitions of three bins, as in the paper.

plots = [
    plot(
        {"observed": (ANGLES, shares[:, k - 1] * 100), "linear": (ANGLES, straight[:, k - 1] * 100)},
        f"bin {k}: share of lit pixels [%] over degrees",
        size=(380, 240),
    )
    for k in SHOWN
]
save("fig06", np.concatenate(plots, axis=1))
