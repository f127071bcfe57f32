"""
Figs. 13 and 14: the simulator on volumes of other systems
==========================================================

Volumes of least squares, of stochastic tomography and of appearance transfer, frame by frame, then Section 4 on each:
the grid stays in what had one (Fig. 13). Strong turbulence, with less of the footage in the motion, bends its lines and
does not hide them (Fig. 14).
"""

from common import arguments, pick, save, show, tell
from scenes import sequence
from sequences import footage, run, straight_lines

from warpfluid.metrics import grid_index

FRAMES = tuple(range(1, pick(2, 6, 24) + 1))
SYSTEMS = {
    "LSM": "--paper --method lsm",
    "ST-SAD": "--paper --method stochastic",
    "ours, paper": "--paper",
    "ours, default": "",
}
TURBULENCE = "--turbulence-strength 5 --turbulence-frequency 1 --guide-weight 0.2"

# %%
# Every system on all frames, then the simulator: as in the paper, and for our default as it is by default.

small = "--angles 60 --iterations 2" if arguments().scale == 0 else ""
films = footage("fire", FRAMES, (0, 90))
rows, plain, strong = {}, {}, {}
for name, words in SYSTEMS.items():
    key = name.replace(", ", "-")
    made = run(f"fire-{key}", f"reconstruct {films} {small} {words}")
    how = "--paper" if "--paper" in words else ""
    simulated = run(f"fire-{key}-simulated", f"simulate {made.folder} {how}")
    turbulent = run(f"fire-{key}-turbulent", f"simulate {made.folder} {how} {TURBULENCE}")
    before, plain[name], strong[name] = (found.volume(FRAMES[-1]) for found in (made, simulated, turbulent))
    rows[name] = {
        f"{kind}: {what}": measure(volume)
        for kind, measure in (("grid index", grid_index), ("straight lines", straight_lines))
        for what, volume in (("volume", before), ("simulated", plain[name]), ("turbulent", strong[name]))
    }

# %%
# The truth of the last frame has no grid; what it scores is the floor.

true = sequence("fire", FRAMES)[-1]
rows["truth"] = {"grid index: volume": grid_index(true), "straight lines: volume": straight_lines(true)}
tell("fig13", rows)
save("fig13", show(plain | {"truth": true}, (0, 45, 70), slices=3))
save("fig14", show(strong | {"truth": true}, (0, 45, 70), slices=3))
