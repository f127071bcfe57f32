"""No kernel reads or writes beyond its arrays: Warp's debug mode ends the process at once."""

import subprocess
import sys

import pytest

PROGRAM = """
import sys
import numpy as np
import warp as wp

wp.config.mode = "debug"
from warpfluid import Projector, ReconstructOptions, Views, reconstruct

device = sys.argv[1]
rng = np.random.default_rng(0)
angles = [0, 20, 45, 70, 90, 110, 135, 160, 300]
for shape, corner in [((3, 11, 50), (1, 0)), ((11, 2, 7), (0, 9)), ((11, 11, 1), (0, 0)), ((1, 1, 49), (10, 10))]:
    for footprint in ("box", "joseph"):
        for hull in (None, (rng.random(shape) < 0.3).astype(np.float32)):
            projector = Projector(angles, shape, hull=hull, footprint=footprint, device=device, corner=corner, width=11)
            images = projector.project(projector.hull.numpy())
            projector.backproject(images)

image = np.zeros((2, 16, 12), np.float32)
image[0, 1:6, 2:9], image[1, 5:16, 2:9] = 100, 200
for views in (Views(image, (0, 90)), Views(image[:1], (30,)), Views(image[1:], (300,))):
    for options in (ReconstructOptions, ReconstructOptions.paper):
        reconstruct(views, options(iterations=2, angles=8), device=device)

from warpfluid.motion.optical_flow import optical_flow
for size in [(8, 8), (9, 70), (40, 33), (1, 50)]:
    now, later = rng.random((2, *size), np.float32)
    optical_flow(now, later, method="nltv-ncc", white=1.0, device=device)
print("done")
"""


def test_debug_mode_finds_nothing(device):
    """Small and odd shapes, parts of the box at its edges, one view and two."""
    done = subprocess.run([sys.executable, "-c", PROGRAM, device], capture_output=True, text=True, timeout=300)
    if done.stdout.split() != ["done"]:
        pytest.fail(f"ended with {done.returncode}: {done.stdout}{done.stderr[-2000:]}")
