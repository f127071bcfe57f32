"""
Fig. 17: a tree
===============

The limit of histograms that the paper names: branches go on, and histograms do not know that. A few degrees beside
the inputs the trunk is scattered. Portilla and Simoncelli's statistics, which the paper proposes to try, know how
coefficients go together along a structure.
"""

import numpy as np
from common import FLOOR_DEG, floor, model, pick, project, save, score, show, tell, views_of
from gallery import plot
from trees import tree, trunk_contrast

ANGLES = np.arange(0, 91, 5)
BESIDE = (5, 10, 15, 20, 45)
FAR = (ANGLES >= 20) & (ANGLES <= 70)

# %%
# Front and side of a tree that is known from all sides.

true = tree(*pick((32, 48), (64, 96), (128, 192)))
views = views_of(true, (0, 90))
ways = {
    "LSM": ("LSM", {}),
    "ours, paper": ("ours, paper", {}),
    "ours, default": ("ours, default", {}),
    "default, Portilla-Simoncelli": ("ours, default", {"transfer": "portilla-simoncelli"}),
    "default, texture optimisation": ("ours, default", {"transfer": "texture-optimization", "patch": 8}),
}
made = {name: model(views, method, **changes) for name, (method, changes) in ways.items()}

# %%
# Contrast of the trunk with what is beside it, over the truth's; and the share of the heights at which it is gone, with
# less than a third of the truth's contrast, between 20 and 70 degrees.

real = trunk_contrast(project(true, ANGLES), ANGLES)
curves = {name: trunk_contrast(project(found["volume"], ANGLES), ANGLES) for name, found in made.items()}
rows = {}
for name, curve in curves.items():
    share = curve.mean(axis=1) / real.mean(axis=1)
    shares = {f"trunk at {angle}": float(share[list(ANGLES).index(angle)]) for angle in BESIDE}
    shares["gone"] = float((curve < real / 3)[FAR].mean())
    rows[name] = shares | score(made[name]["volume"], true, (0, 90)) | {"seconds": float(made[name]["seconds"])}
rows[f"truth, {FLOOR_DEG} degrees aside"] = floor(true, (0, 90))
tell("fig17", rows)

save("fig17", show({name: found["volume"] for name, found in made.items()} | {"truth": true}, (0, 5, 10, 20, 45)))
lines = {name: (ANGLES, curve.mean(axis=1)) for name, curve in (curves | {"truth": real}).items()}
save("fig17_contrast", plot(lines, "contrast of the trunk by angle [degree]"))
