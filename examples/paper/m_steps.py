"""
Three M-steps
=============

What the paper uses, what it tried, and what it proposes: histograms, patches of the inputs, and Portilla and
Simoncelli's statistics, on fire and smoke from two views.
"""

import numpy as np
from common import model, pick, save, score, show, tell, views_of
from gallery import plot, stack
from scenes import size, truth

INPUTS = (0, 90)
WAYS = {
    "histograms": {},
    "texture optimisation": {"transfer": "texture-optimization", "patch": min(16, size()[0] // 2)},
    "Portilla-Simoncelli": {"transfer": "portilla-simoncelli"},
}

# %%
# Everything else is as by default.

rows, pictures, plots = {}, [], []
for kind in pick(("smoke",), ("fire", "smoke"), ("fire", "smoke")):
    true = truth(kind)
    made = {name: model(views_of(true, INPUTS), "ours, default", **changes) for name, changes in WAYS.items()}
    for name, found in made.items():
        energies = found["energies"]
        facts = {"energy, last/first": energies[-1, 1] / energies[0, 0], "seconds": float(found["seconds"])}
        rows[f"{kind}, {name}"] = score(found["volume"], true, INPUTS) | facts
    volumes = {f"{kind}, {name}": found["volume"] for name, found in made.items()}
    pictures.append(show(volumes | {f"{kind}, truth": true}, (15, 30, 45, 60, 75, 135), slices=3))
    falls = {name: found["energies"][:, 1] / found["energies"][0, 0] for name, found in made.items()}
    curves = {name: (np.arange(1, len(fall) + 1), fall) for name, fall in falls.items()}
    plots.append(plot(curves, f"{kind}: energy after the E-step over the first, by iteration"))
tell("m_steps", rows)

save("m_steps", stack(pictures))
save("m_steps_energy", stack(plots))
