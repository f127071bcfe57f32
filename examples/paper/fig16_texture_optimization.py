"""
Fig. 16: texture optimisation instead of histograms
===================================================

The paper's negative result: patches of the inputs (Kwatra et al. 2005) in place of histograms in the M-step, with
patches of three sizes. Constraints so tight that the energy no longer falls, and volumes that are too dense.
"""

import numpy as np
from common import model, pick, save, score, show, tell, views_of
from gallery import plot
from scenes import size, truth

PATCHES = pick((8,), (8, 16, 32), (8, 16, 32))

# %%
# A single view, as in the paper; there it has 141 x 100 pixels.

true = truth("fire")
views = views_of(true, (0,))
patches = [min(patch, min(size()) // 2) for patch in PATCHES]
ways = {"histograms": {}} | {
    f"texture optimisation, patches of {patch}": {"transfer": "texture-optimization", "patch": patch}
    for patch in dict.fromkeys(patches)
}
made = {name: model(views, "ours, paper", **changes) for name, changes in ways.items()}


def density(volume: np.ndarray) -> float:
    """Return the share of the box in which there is more than a hundredth of the densest."""
    return float((volume > 0.01 * volume.max()).mean())


rows = {}
for name, found in made.items():
    after_m, after_e = found["energies"].T
    rows[name] = score(found["volume"], true, (0, 90), given_deg=(0,)) | {
        "filled": density(found["volume"]),
        "energy, last/first": after_e[-1] / after_m[0],
        "rises": int((np.diff(after_e) > 0).sum()),
        "seconds": float(found["seconds"]),
    }
rows["truth"] = {"filled": density(true)}
tell("fig16", rows)

# %%
# Views and slices; and the energies, each over its first.

save("fig16", show({name: found["volume"] for name, found in made.items()} | {"truth": true}, (0, 30, 60), slices=3))
x = np.arange(1, len(made["histograms"]["energies"]) + 1)
curves = {name: (x, found["energies"][:, 1] / found["energies"][0, 0]) for name, found in made.items()}
save("fig16_energy", plot(curves, "energy after the E-step over the first, by iteration"))
