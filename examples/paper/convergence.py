"""
Convergence: a batch of random scenes
=====================================

The paper saw no failure among 1,600 examples. Here are random small scenes of four kinds, half of them made by our
solver, half random fields, from one, two or three views at random angles. The energy (Eq. 1) after the E-step converges
if it never rises after the first iteration, ends below half of where it began, and falls by less than a tenth at last.
What does not in the paper's eight iterations gets sixteen.
"""

import numpy as np
from common import cached, pick, tell, views_of
from scenes import KINDS, play, random_field

import warpfluid as wf
from warpfluid.options import ReconstructOptions

EACH = pick(1, 12, 400)  # scenes of a kind; half by the solver
WIDTH, HEIGHT = pick((16, 20), (24, 36), (32, 48))
SEEDS = pick(1, 2, 20)  # of the solver's turbulence; more scenes are other frames and angles
RISE, FALL, END = 1e-3, 0.5, 0.1

# %%
# The scenes: frames of presets with different turbulence, and noise in the outline of each kind.


def scenes(kind: str):
    """Yield what made it, and a volume (x, z, y) whose brightest ray from the front is 255."""
    half = max(EACH // 2, 1)
    a_seed = -(-half // SEEDS)
    frames = tuple(np.unique(np.linspace(KINDS[kind] // 2, KINDS[kind], a_seed).astype(int)).tolist())
    for seed in range(SEEDS):
        name = f"convergence-{kind}-{WIDTH}x{HEIGHT}-{len(frames)}-{seed}"
        made = cached(name, lambda seed=seed: {"volume": play(kind, frames, (WIDTH, HEIGHT), seed=seed)})["volume"]
        for index in range(min(a_seed, half - seed * a_seed)):
            volume = made[index % len(frames)]
            yield "solver", volume * np.float32(255 / max(volume.sum(axis=1).max(), 1e-6))
    for seed in range(EACH - half):
        yield "random field", random_field(kind, WIDTH, HEIGHT, seed)


def judge(volume: np.ndarray, chance: np.random.Generator) -> dict[str, float]:
    """Model a scene from random views; return what its energies did."""
    count = chance.integers(1, 4)
    views = views_of(volume, chance.uniform(0, 180) + np.arange(count) * (90 if count < 3 else 60))
    found = course(views, 8)
    return found | {"converges later": found["converges"] or course(views, 16)["converges"]}


def course(views: wf.Views, iterations: int) -> dict[str, float]:
    """Return how the energy went, and whether it converged."""
    result = wf.reconstruct(views, ReconstructOptions.paper(angles=60, iterations=iterations), device="cpu")
    after_m, after_e = result.energies.T
    rise = float((after_e[2:] / after_e[1:-1]).max() - 1)
    found = {"rise": max(rise, 0.0), "last/first": after_e[-1] / after_m[0], "last fall": 1 - after_e[-1] / after_e[-2]}
    return found | {"converges": rise < RISE and found["last/first"] < FALL and found["last fall"] < END}


# %%
# One random stream for everything, so that the batch is the same every time.

chance, found = np.random.default_rng(1600), {}
for kind in KINDS:
    for origin, volume in scenes(kind):
        found.setdefault(f"{kind}, {origin}", []).append(judge(volume, chance))
found["all"] = [row for rows in list(found.values()) for row in rows]
tell(
    "convergence",
    {
        name: {"scenes": len(rows), "converge": float(np.mean([row["converges"] for row in rows]))}
        | {"in 16": float(np.mean([row["converges later"] for row in rows]))}
        | {"never rise": float(np.mean([row["rise"] < RISE for row in rows]))}
        | {key: float(np.median([row[key] for row in rows])) for key in ("last/first", "last fall")}
        | {"worst last/first": max(row["last/first"] for row in rows), "worst rise": max(row["rise"] for row in rows)}
        for name, rows in found.items()
    },
)
