"""
Fig. 9: synthetic fire from a pair of views
===========================================

Least squares, stochastic tomography, multiplication and appearance transfer from front and side; the truth is known.
The paper shows 45 degrees. The second table changes one of the paper's choices at a time.
"""

from common import BETWEEN, compare, model, score, tell, views_of
from scenes import truth

INPUTS = (0, 90)
CHANGES = {
    "ours, paper": {},
    "16 iterations": {"iterations": 16},
    "ramp preconditioner": {"preconditioner": "ramp"},
    "corners of the hull fade": {"fade": 0.5},
    "starts with mild noise": {"start_noise": 0.3},
}

compare("fig09", INPUTS, (0, 30, 45, 60, 90), BETWEEN)

# %%
# Why some of the grid is left: appearance transfer sharpens what it starts from, and least squares starts with a grid.

true = truth("fire")
made = {name: model(views_of(true, INPUTS), "ours, paper", **changes) for name, changes in CHANGES.items()}
tell("fig09_why", {name: score(found["volume"], true, INPUTS) for name, found in made.items()})
