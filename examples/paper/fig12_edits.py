"""
Fig. 12: edits in the simulator
===============================

An explosion from a single view, simulated as it is (a), with turbulence (b), and with a car beside it (c): a rigid
body that the blast carries off. Turbulence adds curls and leaves the large shapes where they are.
"""

import numpy as np
from common import arguments, pick, save, tell
from gallery import captioned, in_a_row, stack
from scipy.ndimage import gaussian_filter
from sequences import footage, picture, run

from warpfluid.files.bodies import read_bodies
from warpfluid.volumes import open_volumes

FIRST, LAST = 3, pick(5, 18, 30)
FRAMES = tuple(range(FIRST, LAST + 1))
CAR = "box center=0.7,0.5,0.7 size=1.3,0.6,0.6 rotation=0,25,0 weight=0.15 carry=40 obstacle=false"
EDITS = {
    "a, as it is": "--fidelity 0.3",
    "b, turbulence": "--fidelity 0.3 --turbulence-strength 4 --turbulence-frequency 1",
    "c, a car": f"--fidelity 0.3 --body '{CAR}'",
}

# %%
# The volumes, coherent from frame to frame, and three simulations of them.

small = "--angles 60 --iterations 2" if arguments().scale == 0 else ""
made = run("explosion", f"reconstruct {footage('explosion', FRAMES, (0,))} {small} --look explosion")
runs = {name: run(f"explosion-{name[0]}", f"simulate {made.folder} {words}") for name, words in EDITS.items()}


def rotation(folder: str) -> float:
    """Return the rms vorticity of the last frame, where there is fluid [1/s]."""
    found = open_volumes(folder).fields(LAST, ["density", "velocity"])
    u, w, v = (found["velocity"][..., k] for k in range(3))  # along x, z, y
    turn = [
        np.gradient(v, axis=1) - np.gradient(w, axis=2),
        np.gradient(u, axis=2) - np.gradient(v, axis=0),
        np.gradient(w, axis=0) - np.gradient(u, axis=1),
    ]
    lit = found["density"] > 0.01 * found["density"].max()
    return float(np.sqrt(sum(part[lit] ** 2 for part in turn).mean()))


# %%
# Against (a): how much more it turns, and how far its density is from (a)'s, as it is and without detail.

plain = runs["a, as it is"]
rows = {}
for name, edited in runs.items():
    pair = [found.volume(LAST) for found in (plain, edited)]
    smooth = [gaussian_filter(volume, pair[0].shape[0] / 16) for volume in pair]
    change = [float(np.abs(b - a).sum() / a.sum()) for a, b in (pair, smooth)]
    rows[name] = {"vorticity [1/s]": rotation(str(edited.folder))}
    rows[name] |= {"density changes by": change[0], "smoothed": change[1]}
_, cars = read_bodies(runs["c, a car"].folder / "bodies.json")
first, last = (cars[frame][0]["position"] for frame in (FIRST, LAST))
rows["c, a car"]["car moved by [box height]"] = float(np.linalg.norm(last - first)) / (pair[0].shape[2] * 0.01)
tell("fig12", rows)

# %%
# Frames of each, lit.

WORDS = "--resolution 220x300 --ground --elevation 8 --angle 15 --zoom 1.3 --target 0.3,3,0 --look explosion"
chosen = np.unique(np.linspace(FIRST + 1, LAST, 4).astype(int))
pictures = {name: [picture(found, int(frame), WORDS) for frame in chosen] for name, found in runs.items()}
save("fig12", stack([captioned(in_a_row(row), name) for name, row in pictures.items()]))
