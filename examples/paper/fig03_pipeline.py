"""
Fig. 3: the pipeline
====================

Inputs, the volume of least squares, and then again and again: render it, transfer the inputs' appearance to the views,
fit the volume to them. ``warpfluid reconstruct --debug-dir FOLDER`` writes the same panels of any run.
"""

import numpy as np
from common import pick, save, tell, views_of
from gallery import captioned, panel, shown, stack
from scenes import truth

import warpfluid as wf
from warpfluid.metrics import appearance_distance, grid_index
from warpfluid.options import ReconstructOptions
from warpfluid.report.panels import panels

# %%
# An observer is shown every iteration.

views, steps = views_of(truth("fire"), (0, 90)), []
options = ReconstructOptions.paper(angles=pick(30, 180, 180), iterations=pick(2, 8, 8))
result = wf.reconstruct(views, options, observe=steps.append, device="cpu")
inputs = views.pictures()


def distance(images: np.ndarray, angles_deg: tuple[float, ...]) -> float:
    """Return how far the sub-bands of unseen views are from the inputs'."""
    at = [int(np.abs(np.subtract(angles_deg, angle)).argmin()) for angle in (30, 60, 120, 150)]
    return float(np.mean([appearance_distance(images[k].T[::-1], inputs)["band_w1"] for k in at]))


# %%
# The M-step brings the sub-bands of views to those of the inputs; the E-step gives some of that up again.

rows = {
    f"iteration {step.iteration}": {
        "band_w1, rendered": distance(step.rendered, step.angles_deg),
        "band_w1, modified": distance(step.made, step.angles_deg),
        "energy after M-step": result.energies[step.iteration - 1, 0],
        "energy after E-step": result.energies[step.iteration - 1, 1],
        "grid_index": grid_index(step.volume),
    }
    for step in steps
}
tell("fig03", {"least squares": {"grid_index": grid_index(result.initial)}} | rows)

# %%
# The panels: (a) inputs; then rendered (c) above modified (d) above the new volume (e), for the first and last time.

pictures = [panel({"a, front": shown(views.images[0]), "a, side": shown(views.images[1])})]
for step in (steps[0], steps[-1]):
    large = panels(step).repeat(2, axis=0).repeat(2, axis=1)
    pictures.append(captioned(large, f"iteration {step.iteration}: c, rendered; d, modified; e, fitted"))
save("fig03", stack(pictures))
