"""
Fig. 15: the energy as a function of the iteration
==================================================

Eq. 1 after the M-step and after the E-step, for the two views of Fig. 9 and the six views of Fig. 10.
"""

import numpy as np
from common import model, save, tell, views_of
from gallery import plot
from scenes import truth

INPUTS = {"2 views": (0, 90), "6 views": (0, 30, 60, 90, 120, 150)}

# %%
# The same runs as in Figs. 9 and 10.

rows, plots = {}, []
for name, inputs_deg in INPUTS.items():
    for method in ("ours, paper", "ours, default"):
        energies = model(views_of(truth("fire"), inputs_deg), method)["energies"]
        after_m, after_e = energies.T
        rows[f"{name}, {method}"] = {
            "first": energies[0, 0],
            "last": energies[-1, 1],
            "last/first": energies[-1, 1] / energies[0, 0],
            "largest rise": float(max((after_e[1:] / after_e[:-1]).max() - 1, 0)),
            "last fall": float(1 - after_e[-1] / after_e[-2]),
        }
        x = np.arange(len(energies)) + 1
        curves = {"after the M-step": (x, after_m / 1e6), "after the E-step": (x, after_e / 1e6)}
        plots.append(plot(curves, f"{name}, {method}: energy [million] over the iteration", size=(480, 260)))
tell("fig15", rows)
save("fig15", np.concatenate([np.concatenate(pair, axis=1) for pair in (plots[:2], plots[2:])]))
