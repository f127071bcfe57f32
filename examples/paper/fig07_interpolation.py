"""
Figs. 7 and 8: histogram interpolation off, on, and with the true histograms
============================================================================

Appearance transfer to views of the least squares volume between front and side. Without interpolation all views get
the front's histograms, which leaves artefacts around the fire; the true ones are hardly better than Eq. 4.
"""

import numpy as np
from common import model, project, save, score, tell, views_of
from gallery import captioned, stack
from scenes import truth

from warpfluid.metrics import compare_pictures
from warpfluid.reconstruction.appearance import AppearanceTransfer
from warpfluid.rendering.ramps import apply_ramp
from warpfluid.rendering.turntable import in_a_row

ANGLES = (15, 30, 45, 60, 75)
SHOWN = ("intensity_w1", "band_w1", "patch_swd", "log_spectrum", "silhouette")

# %%
# One M-step, three times. What is black stays black: it is outside of the visual hull.

true = truth("fire")
views = views_of(true, (0, 90))
rendered = project(model(views, "LSM")["volume"], ANGLES)
wanted = project(true, ANGLES)
inputs = {
    "off: the front's": (views.images, (0, 90), "first"),
    "on: Eq. 4": (views.images, (0, 90), "density"),
    "true histograms": (wanted, ANGLES, "density"),
}
rows = {"least squares": rendered}
for name, (images, angles_deg, mixture) in inputs.items():
    make = AppearanceTransfer(np.asarray(images), angles_deg, ANGLES, interpolation=mixture, part_highpass=False)
    rows[name] = make.transfer(rendered, rendered > 0)
rows["truth"] = wanted


def distance(images: np.ndarray) -> dict[str, float]:
    """Return the mean distance from the true views."""
    found = [compare_pictures(made.T[::-1], real.T[::-1]) for made, real in zip(images, wanted, strict=True)]
    return {name: float(np.mean([row[name] for row in found])) for name in SHOWN}


tell("fig07", {name: distance(images) for name, images in rows.items() if name != "truth"})

# %%
# The same choice made in every M-step of a whole reconstruction.

everywhere = views_of(true, np.arange(0, 180, 3))
volumes = {
    "off: the front's": model(views, "ours, paper", interpolation="first"),
    "on: Eq. 4": model(views, "ours, paper"),
    "true histograms": model(views, "ours, paper", statistics=everywhere),
}
tell("fig07_volumes", {name: score(made["volume"], true, (0, 90)) for name, made in volumes.items()})

# %%
# Fig. 7 as colours of fire; Fig. 8: the same in jet, the dim end stretched to show what floats around the fire.


def shown(ramp: str, white: float) -> np.ndarray:
    """Return a row a way, an angle a column."""
    picture = {name: apply_ramp(images.transpose(0, 2, 1)[:, ::-1], ramp, white) for name, images in rows.items()}
    large = {name: in_a_row(found.repeat(2, axis=1).repeat(2, axis=2)) for name, found in picture.items()}
    return stack([captioned(row, f"{name}: {', '.join(map(str, ANGLES))} degrees") for name, row in large.items()])


save("fig07", shown("fire", 255.0))
save("fig08", shown("jet", 100.0))
