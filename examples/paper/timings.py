"""
Timings of Section 5
====================

The paper's 271 x 144 x 271 voxels from two views took 10.6 s to begin with, 15.9 s an E-step and 14.0 s an M-step, and
250 s for eight iterations, on a GeForce GTX 770. Here is this machine; ``--full`` is the paper's size.
"""

import os
import platform
import time

import numpy as np
from common import pick, tell, views_of
from scenes import random_field

from warpfluid.device import pick_device
from warpfluid.options import ReconstructOptions
from warpfluid.reconstruction.em import Iteration, footage_facts
from warpfluid.reconstruction.inputs import make_inputs
from warpfluid.reconstruction.start import first_volume, rough_start

WIDTH, HEIGHT = pick((24, 20), (96, 72), (271, 144))
PAPER = {"begin": 10.6, "M-step": 14.0, "E-step": 15.9, "all": 250.0}

# %%
# Each step is timed where it is made.


class Timed(Iteration):
    """The iteration, with a clock at its two steps."""

    def __init__(self, *given):
        self.seconds = {"M-step": [], "E-step": []}
        super().__init__(*given)

    def _clock(self, name: str, step, given, named):
        begin = time.perf_counter()
        found = step(*given, **named)
        self.seconds[name].append(time.perf_counter() - begin)
        return found

    def _m_step(self, *given, **named):
        return self._clock("M-step", super()._m_step, given, named)

    def _e_step(self, *given, **named):
        return self._clock("E-step", super()._e_step, given, named)


views = views_of(random_field("fire", WIDTH, HEIGHT, 0), (0, 90))
device, rows = pick_device(None), {"paper, 271 x 144 x 271, GTX 770": PAPER}
for name, options in (("--paper", ReconstructOptions.paper()), ("default", ReconstructOptions())):
    options = options.settled(**footage_facts(views))
    begin = time.perf_counter()
    inputs = make_inputs(views, options, device)
    volume = rough_start(inputs, options, first_volume(inputs, options))
    started = time.perf_counter() - begin
    timed = Timed(inputs, options)
    timed.run(volume)
    steps = {step: float(np.mean(seconds)) for step, seconds in timed.seconds.items()}
    whole = time.perf_counter() - begin
    rows[f"{name}, {WIDTH} x {HEIGHT} x {WIDTH}"] = {"begin": started, **steps, "all": whole}
tell("timings", rows)
print(f"{device}, {platform.processor() or platform.machine()}, {os.cpu_count()} cores")
