"""
Fig. 11: single views
=====================

Fire, smoke, an explosion and a splash from the front alone. The paper takes the front as the side, too: the volume is
symmetric, and should be round where stochastic tomography is square and woven. By default the side is another one.
"""

import numpy as np
from common import arguments, floor, model, save, score, show, tell, views_of
from scenes import KINDS, truth

SYSTEMS = ("LSM", "ST-SAD", "ours, paper", "ours, default")
ANGLES = (0, 30, 45, 60, 90)


def symmetry(volume: np.ndarray) -> float:
    """Return the rms difference of a volume from its mirror image in x = z, over its rms."""
    return float(np.sqrt(((volume - volume.transpose(1, 0, 2)) ** 2).mean() / (volume**2).mean()))


# %%
# Every kind of fluid with every system.

rows = {}
for kind in list(KINDS)[: 1 if arguments().scale == 0 else 4]:
    true = truth(kind)
    views = views_of(true, (0,))
    volumes = {name: model(views, name)["volume"] for name in SYSTEMS}
    for name, volume in volumes.items():
        rows[f"{kind}: {name}"] = score(volume, true, (0, 90), given_deg=(0,)) | {"symmetry": symmetry(volume)}
    rows[f"{kind}: truth, 10 degrees aside"] = floor(true, (0, 90))
    save(f"fig11_{kind}", show(volumes | {"truth": true}, ANGLES, slices=3))
tell("fig11", rows)
