"""
Fig. 5: histogram interpolation and matching
============================================

The third-scale, fourth-orientation sub-band of a rendered view between two inputs gets the histogram that Eq. 4 puts
between theirs, value by value. No bins are chosen for that: the weighted pool of both samples is the limit of
infinitely many. Only the distances are measured in bins, as the paper has them.
"""

import numpy as np
from common import model, pick, project, save, tell
from gallery import band_shown, panel, plot, sample

from warpfluid.reconstruction.histogram import density_mixture, match, rank_grid
from warpfluid.reconstruction.pyramid import SteerablePyramid

KEY, BINS = pick((0, 3), (2, 3), (2, 3)), 32
ANGLES, AT = (0, 30, 90), 30

# %%
# The inputs' sub-bands, the one of least squares rendered at 30 degrees, and what matching makes of it.

views = sample(width=pick(32, 96, 96))
images = [views.images[0], project(model(views, "LSM")["volume"], [AT])[0], views.images[1]]
pyramid = SteerablePyramid(views.size, KEY[0] + 1)
p, q, r = (pyramid.build(image)[KEY] for image in images)
ranks = rank_grid(q.size)
target = density_mixture(np.sort(p, axis=None), np.sort(r, axis=None), [AT / 90], (ranks + 0.5) / q.size)
matched = match(q.reshape(1, -1), target, ranks).reshape(q.shape)

# %%
# Eq. 4 in bins, and how far the bands are from it: half the sum over bins, 0 to 1.

reach = float(max(np.abs(p).max(), np.abs(r).max()))
edges = np.linspace(-reach, reach, BINS + 1)
shares = {
    name: np.histogram(band, edges)[0] / band.size
    for name, band in (("0 degrees", p), ("30, rendered", q), ("30, matched", matched), ("90 degrees", r))
}
wanted = (90 - AT) / 90 * shares["0 degrees"] + AT / 90 * shares["90 degrees"]
rows = {name: {"distance from Eq. 4": float(np.abs(share - wanted).sum() / 2)} for name, share in shares.items()}
rows["one coefficient in another bin"] = {"distance from Eq. 4": 1 / q.size}
tell("fig05", rows)

# %%
# Bands, and the tails of their histograms.

zoom = 2 ** KEY[0]
pictures = {"0 degrees": p, "30, rendered": q, "30, matched": matched, "90 degrees": r}
middle = (edges[1:] + edges[:-1]) / 2
tail = middle > 0.08 * reach
curves = {
    name: (middle[tail], 100 * share[tail]) for name, share in (shares | {"Eq. 4": wanted}).items() if name[:2] != "30"
}
curves["30, matched"] = (middle[tail], 100 * shares["30, matched"][tail])
save("fig05", panel({name: band_shown(band, zoom) for name, band in pictures.items()}))
save("fig05_histograms", plot(curves, "share of the coefficients [%] over the coefficient"))
