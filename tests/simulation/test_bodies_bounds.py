"""Shapes, emitters and probes stay within their arrays: Warp's debug mode ends the process where they do not."""

import subprocess
import sys

import pytest

PROGRAM = """
import sys
import warp as wp

wp.config.mode = "debug"
from warpfluid.device import pick_device
from warpfluid.simulation.drag import flow_around
from warpfluid.simulation.emitters import Emitter, emit
from warpfluid.simulation.rigid_body import RigidBody
from warpfluid.simulation.rigid_motion import advance
from warpfluid.simulation.placed import Placed
from warpfluid.simulation.shapes import Box, Cylinder, Mesh, Plane, Sphere
from warpfluid.simulation.solids import build_solids, clear, enforce
from warpfluid.simulation.state import Faces, FluidState, six_sides
from warpfluid.simulation.triangles import box_surface

device = pick_device(sys.argv[1])
placed = [
    Placed(Sphere(4), (0, 0, 0), spin=(1, 1, 1)),
    Placed(Mesh(*box_surface((5, 30, 4))), (10, 4, 12), velocity=(1, 2, 3)),
    Placed(Cylinder(3, 3), (99, 99, 99)),
]
for shape in [(11, 13, 50), (3, 7, 49), (1, 1, 1)]:
    cells = [wp.zeros(shape, dtype=float, device=device) for _ in range(4)]
    state = FluidState(Faces.zeros(shape, device), *cells)
    for solid in placed:
        for soft_edge in (0, 2):
            out = {"density": 1, "velocity": (1, 1, 1), "velocity_rate": 1, "noise": 1}
            emit(state, Emitter(placed=solid, soft_edge=soft_edge, **out), 0.1)
    solids = build_solids([*placed, Placed(Plane(), (0, 3, 0))], shape, device, sides=six_sides("wrap", "open", "wrap"))
    enforce(state.velocity, solids)
    clear(state.density, solids)
    body = RigidBody(Box((4, 4, 4)), position=(shape[0], 0, 0))
    advance(body, 0.1, gravity=9.0, flow=flow_around(state, 1.0))
print("done")
"""


def test_debug_mode_finds_nothing(device):
    """At the edges of small and odd grids, and beyond them."""
    done = subprocess.run([sys.executable, "-c", PROGRAM, device], capture_output=True, text=True, timeout=300)
    if done.stdout.split() != ["done"]:
        pytest.fail(f"ended with {done.returncode}: {done.stdout}{done.stderr[-2000:]}")
