"""No force reads or writes beyond its arrays: Warp's debug mode ends the process at once."""

import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = """
import sys
import warp as wp

wp.config.mode = "debug"
from mac import SIDES, on, random_faces, six

from warpfluid.device import start_warp
from warpfluid.kernels.fluid.combustion import burn_fuel
from warpfluid.kernels.fluid.decay import decay, make_mask, radiate
from warpfluid.kernels.forces.air import add_buoyancy, add_wind
from warpfluid.kernels.forces.pushes import KINDS, add_push
from warpfluid.kernels.forces.swirl import add_swirl
from warpfluid.kernels.forces.turbulence import add_turbulence

start_warp()
device = sys.argv[1]
for shape in ((1, 5, 2), (9, 7, 97)):
    gas = [wp.full(shape, 0.5, dtype=float, device=device) for _ in range(4)]
    for sides in SIDES:
        faces = on(device, random_faces(shape, sides))
        box = {"sides": six(sides), "time_step": 0.1}
        lift = {"up": (1, 2, 3), "temperature_buoyancy": 1, "density_buoyancy": 1, "reference": 1}
        add_buoyancy(**faces, temperature=gas[0], density=gas[1], **lift, **box)
        for kind in KINDS:
            add_push(**faces, kind=kind, strength=1, radius=2, **box)
        for mask in (None, gas[2]):
            add_wind(**faces, rate=1, mask=mask, **box)
            add_swirl(**faces, strength=1, mask=mask, **box)
            for frequency in (0.01, 0.25):
                eddies = {"strength": 1, "frequency": frequency, "phase": 0, "octaves": 3, "seed": 0}
                add_turbulence(**faces, **eddies, mask=mask, **box)
    decay(gas[0], rate=1, time_step=1)
    radiate(gas[0], rate=1, hottest=1, time_step=1)
    make_mask(gas[1], reference=1)
    numbers = {"burn_rate": 1, "ignition": 0, "hottest": 1, "heat": 1, "smoke": 1, "expansion": 1, "flame_decay": 1}
    burn_fuel(*gas, **numbers, time_step=1)
print("done")
"""


def test_debug_mode_finds_nothing(device):
    """Thin and odd boxes with every kind of side, with masks and without."""
    command = [sys.executable, "-c", PROGRAM, device]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, cwd=Path(__file__).parent)
    if done.stdout.split() != ["done"]:
        pytest.fail(f"ended with {done.returncode}: {done.stdout}{done.stderr[-2000:]}")
