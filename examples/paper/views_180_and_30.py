"""
The number of views for appearance transfer
===========================================

The paper takes 180 views and finds streaks with 30. How many a volume needs goes with its width: what counts is how far
the volume is from its look at angles that took no part, half-way between those that did.
"""

import numpy as np
from common import model, pick, save, score, show, tell, views_of
from scenes import size, truth

COUNTS = pick((12, 60), (6, 10, 20, 30, 60, 180), (30, 60, 180, 360))

# %%
# Views per voxel of width; scores at angles within the fan, and between its angles.

true = truth("fire")
views = views_of(true, (0, 90))
rows, volumes = {}, {}
for count in COUNTS:
    volume = model(views, "ours, paper", angles=count)["volume"]
    spacing = 180 / count
    within = np.unique(np.rint(np.arange(15, 180, 15) / spacing) * spacing)
    within = [angle for angle in within if angle % 90]
    inside, outside = (score(volume, true, (0, 90), at) for at in (within, np.array(within) + spacing / 2))
    rows[f"{count} views"] = {
        "views a voxel": count / size()[0],
        "patch_swd within": inside["patch_swd"],
        "patch_swd between": outside["patch_swd"],
        "band_w1 within": inside["band_w1"],
        "band_w1 between": outside["band_w1"],
        "grid_index": inside["grid_index"],
    }
    volumes[f"{count} views"] = volume
tell("views_180_and_30", rows)
save("views_180_and_30", show(volumes, (0, 27, 45, 63), slices=3))
