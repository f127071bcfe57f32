"""
Fire, smoke, an explosion and a splash
======================================

The four kinds of fluid of the paper come as presets: numbers of the solver, and emitters for an empty box. With a
reconstructed run as the source only the numbers count, and edit what the footage shows.
"""

# %%
# A preset is a small configuration file; ``warpfluid presets`` lists them.

import numpy as np
import warp as wp
from gallery import captioned, save, stack
from scipy.ndimage import zoom

from warpfluid.presets import preset_names
from warpfluid.rendering.ramps import apply_ramp
from warpfluid.rendering.turntable import in_a_row
from warpfluid.settings import make_simulate_settings
from warpfluid.simulation.animate import Animator
from warpfluid.simulation.animation import Animation
from warpfluid.simulation.source import empty_box

SIZE = (24, 36)  # a small box; 48 x 72 and more shows the curls
FRAMES = (6, 12, 18, 24, 30)

# %%
# On the command line this is ``warpfluid simulate --preset fire --size 24x36 --frames 1-30 -o fire``. Here the frames
# stay in memory. A fire burns already at its first frame: it is simulated for a while before (``preroll``).


def play(name: str) -> tuple[list[np.ndarray], str]:
    """Return how a preset looks from the front at the chosen frames, shape (u, v), and its colour ramp."""
    settings = make_simulate_settings(None, None, None, {}, size=SIZE, preset=name)
    box = empty_box(SIZE)
    choices = {"options": settings.simulate, "scene": settings.scene, "output": settings.output}
    animator = Animator(Animation(source=box, device=wp.get_device("cpu"), **choices), (1,))
    images = []
    for frame in range(2 - settings.simulate.preroll, FRAMES[-1] + 1):
        animator.advance(frame - 1, frame)
        if frame in FRAMES:
            images.append(animator.state.density.numpy().sum(axis=1))
    return images, settings.output.look


# %%
# A row each, from the first to the last frame, exposed as footage is: a ray sum of 255 is white.

rows = []
for name in preset_names():
    images, look = play(name)
    pictures = [apply_ramp(zoom(image.T[::-1], 5, order=1).clip(0), look, 255.0) for image in images]
    rows.append(captioned(in_a_row(pictures), f"{name}, frames {', '.join(map(str, FRAMES))}"))
    print(f"{name}: brightest ray {max(image.max() for image in images):.0f}")
save("06_simulate_presets.png", stack(rows))
