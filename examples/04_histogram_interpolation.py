"""
Histogram interpolation (Fig. 5)
================================

A view between two inputs should have a histogram between theirs. Eq. 4 interpolates every bin linearly,

    c_q = ((r - q) phi(i_p) + (q - p) phi(i_r)) / (r - p),

and the sub-band of the view at q is changed, value by value, until it has that histogram. Here no bins are chosen:
the weighted pool of both samples is the limit of infinitely many.
"""

# %%
# A sub-band of both inputs, as in the paper: third scale, fourth orientation. The rendered view at 30 degrees comes
# from least squares, and its sub-band is far too flat.

import numpy as np
from gallery import band_shown, panel, plot, sample, save

import warpfluid as wf
from warpfluid.reconstruction.histogram import density_mixture, match, rank_grid
from warpfluid.reconstruction.pyramid import SteerablePyramid

KEY = (2, 3)
views = sample()
rendered = wf.reconstruct(views, wf.ReconstructOptions(method="lsm"), device="cpu").render([30])
pyramid = SteerablePyramid(views.size)
p, q, r = (pyramid.build(image)[KEY] for image in (views.images[0], rendered[0], views.images[1]))

# %%
# The target: one third of the way from the histogram at 0 to the one at 90 degrees, read at a grid of ranks.

ranks = rank_grid(q.size)
levels = (ranks + 0.5) / q.size
target = density_mixture(np.sort(p, axis=None), np.sort(r, axis=None), [30 / 90], levels)
matched = match(q.reshape(1, -1), target, ranks).reshape(q.shape)
save(
    "04_bands.png",
    panel(
        {
            "0 degrees": band_shown(p, 4),
            "30, rendered": band_shown(q, 4),
            "30, matched": band_shown(matched, 4),
            "90 degrees": band_shown(r, 4),
        }
    ),
)
for name, band in (("0 degrees", p), ("30 rendered", q), ("30 matched", matched), ("90 degrees", r)):
    print(f"{name:>12}: standard deviation {band.std():.2f}")

# %%
# The tails of the histograms, which hold the visible wisps. The rendered view has too few strong coefficients; after
# matching, the histogram at 30 degrees lies between those of the inputs.

edges = np.linspace(8, 80, 13)


def share(band):
    """Return the share of the coefficients in each interval of magnitude."""
    return np.histogram(np.abs(band), edges)[0] / band.size


curves = {"0 degrees": p, "30, matched": matched, "90 degrees": r, "30, rendered": q}
middle = (edges[1:] + edges[:-1]) / 2
save(
    "04_histograms.png",
    plot({name: (middle, share(band)) for name, band in curves.items()}, "share over the coefficient's magnitude"),
)
