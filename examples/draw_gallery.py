"""
The gallery
===========

Draws the pictures and films of ``docs/gallery.md``. Takes some minutes; a second argument names a folder where the
simulated runs are kept.
"""

# %%
# Presets, and one scene with a body and an obstacle in the way.

import renders
from gallery import folder, in_a_row, save
from renders import evening, render, run

from warpfluid.cli import main

CLOUD = "box center=-3.4,1,0 size=1,2,3.5 density=5 velocity=1:16,2,0;16:5,1,0 drive=20 noise=1 noise_frequency=1.6"
CRATE = "box center=-0.9,0.7,0.3 size=1.4,1.4,1.4 weight=0.4"
renders.RUNS["wave"] = (
    "simulate --size 112x64 --frames 1-24 --no-turntable --no-report --swirl 4 --turbulence-strength 1.5 "
    f"--emitter '{CLOUD}' --body '{CRATE}' --obstacle 'cylinder center=2.8,2.5,-0.8 radius=0.6 size=1,5,1'"
)
renders.RUNS["blast"] = "simulate --preset explosion --size 128x160 --frames 1-24 --no-turntable --no-report"


def film(name: str, words: str) -> None:
    """Write a small film of a run."""
    path = folder() / f"gallery-{name}.webp"
    if main(["render", str(run(name)), *words.split(), "--overwrite", "--quiet", "-o", str(path)]):
        raise SystemExit(f"the film of {name} failed")
    print(f"wrote {path}")


# %%
# Stills.

BLAST = "--look explosion --ground --elevation 6 --zoom 1.5 --target 0,3.2,0"
save("gallery-explosion.png", in_a_row(render("explosion", frame, BLAST, size=(256, 256)) for frame in (5, 10, 15, 22)))
save("gallery-blast.png", in_a_row(render("blast", frame, BLAST, size=(420, 420)) for frame in (14, 22)))
save("gallery-smoke.png", render("smoke", 60, "--ground --elevation 6 --angle 25", size=(420, 480)))
EVENING = f"--probe {evening()} --probe-rotation 200 --ground --elevation 4 --angle 25 --exposure 0.5"
save("gallery-evening.png", render("smoke", 60, EVENING, size=(420, 480)))
NIGHT = "--ground --elevation 8 --key-strength 0 --ambient 0.02"
save("gallery-fire.png", render("fire", 12, NIGHT, size=(420, 480)))
TURN = "--look fire --field-of-view 20 --zoom 1.1"
save("gallery-demo.png", in_a_row(render("demo", 8, f"{TURN} --angle {a}", size=(256, 384)) for a in (0, 30, 60, 90)))
SPLASH = "--look water --ground --elevation 12 --angle 20 --zoom 1.15 --target 0,3.2,0"
save("gallery-splash.png", render("splash", 16, SPLASH, size=(420, 420)))
WAVE = "--look smoke --ground --elevation 12 --angle 20 --zoom 1.9 --target 0,2.4,0 --body-color 0.75,0.25,0.08"
save("gallery-wave.png", in_a_row(render("wave", frame, WAVE, size=(340, 240)) for frame in (5, 11, 18)))

# %%
# Films.

film("explosion", f"{BLAST} --resolution 300x300 --turntable 60 --frames 1-30")
