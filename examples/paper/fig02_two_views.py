"""
Fig. 2: a pair of views, least squares against appearance transfer
==================================================================

The packaged fire from front and side. Nobody knows its other sides: unseen views are measured against the inputs, and
the floor is how far the two inputs are from each other.
"""

import numpy as np
from common import METHODS, SCORES, model, pick, pictures, save, show, tell
from gallery import sample

from warpfluid.metrics import appearance_distance, grid_index

ANGLES = (0, 15, 30, 45, 60, 75, 90)
UNSEEN = (15, 30, 45, 60, 75, 105, 120, 135, 150, 165)

# %%
# The systems that the figure shows, and the way there.

views = sample(width=pick(32, 64, 96))
inputs = views.pictures()
volumes = {name: model(views, name)["volume"] for name in METHODS}
floors = [appearance_distance(inputs[0], inputs[1:]), appearance_distance(inputs[1], inputs[:1])]


def mean(found: list[dict]) -> dict[str, float]:
    """Return the mean of each score."""
    return {name: float(np.mean([row[name] for row in found])) for name in SCORES}


rows = {
    name: mean([appearance_distance(seen, inputs) for seen in pictures(volume, UNSEEN)])
    | {"grid_index": grid_index(volume)}
    for name, volume in volumes.items()
}
tell("fig02", rows | {"the inputs, from each other": mean(floors)})

# %%
# The leftmost and the rightmost picture of a row are at the inputs' angles.

chosen = ("LSM", "ours, paper", "ours, default")
save("fig02", show({name: volumes[name] for name in chosen}, ANGLES, slices=2))
