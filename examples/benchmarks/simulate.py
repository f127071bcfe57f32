"""
The solver against PhiFlow
==========================

Seconds of one solver step of smoke that moves, in one process, the candidates taking turns, and the share of each
part. Four steps of ours: plain, with buoyancy, swirl and turbulence, guided by a motion, and around a ball. PhiFlow
makes the plain step (density and velocity carried, then the pressure) on the same grid, by its own choice of solver to
a relative error of 1e-3; ours goes to 1e-4 of the largest divergence and carries the temperature as well. PhiFlow is
no dependency: ``pip install phiflow``. The parts are timed in steps of their own.

    python examples/benchmarks/simulate.py [--quick] [--size X Z Y] [--repeats N] [--ours] [--device cpu|cuda:0]
"""

import argparse
import importlib.util
import os
import resource
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import warp as wp
from machine import describe, timed_parts
from scipy.ndimage import zoom

from warpfluid.device import pick_device
from warpfluid.kernels.blur import blur
from warpfluid.options import SimulateOptions
from warpfluid.simulation import solver
from warpfluid.simulation.guidance import Motion
from warpfluid.simulation.physics import Physics
from warpfluid.simulation.placed import Placed
from warpfluid.simulation.placing import Placing
from warpfluid.simulation.pressure import make_incompressible
from warpfluid.simulation.shapes import Sphere
from warpfluid.simulation.solids import build_solids
from warpfluid.simulation.solver import Solver, Surroundings
from warpfluid.simulation.state import Faces, FluidState, face_shape, six_sides

SIZES, QUICK_SIZES = ((64, 64, 64), (96, 96, 144)), ((32, 32, 48),)
SECONDS = 1 / 24
FORCES = {"temperature_buoyancy": 0.3, "swirl": 1.0, "turbulence_strength": 0.1}
FARTHEST = 3.0  # that the fluid moves in the step [voxel]
REFERENCE = 4.0  # full density
SIDES = ("open", "open", "closed-low")  # x, z, y
PARTS = (
    (solver, "advect_scalars", "carry scalars"),
    (solver, "advect_velocity", "carry velocity"),
    (solver, "add_forces", "forces"),
    (solver, "make_incompressible", "pressure"),
    (Motion, "guided", "guiding"),
    (solver, "clear", "solids"),
    (solver, "enforce", "solids"),
)


def smooth_noise(rng: np.random.Generator, shape: tuple[int, ...], waves: int = 6) -> np.ndarray:
    """Return noise with so many bumps along each axis, about -1 to 1."""
    coarse = rng.uniform(-1, 1, (waves,) * 3).astype(np.float32)
    return zoom(coarse, [n / waves for n in shape], order=1, mode="nearest", grid_mode=True)


def plume(shape: tuple[int, int, int]) -> np.ndarray:
    """Return smoke that fills about a fifth of the box, shape (x, z, y)."""
    x, z, y = (np.linspace(-1, 1, n, dtype=np.float32) for n in shape)
    away = np.hypot(x[:, None, None], z[:, None]) + 0.2 * smooth_noise(np.random.default_rng(1), shape)
    return (REFERENCE * np.clip(4 * (0.5 - away), 0, 1) * np.clip(4 * (0.8 - np.abs(y)), 0, 1)).astype(np.float32)


def moving(shape: tuple[int, int, int], device: wp.Device) -> FluidState:
    """Return smoke with eddies and a draught, as fast as a step allows."""
    rng = np.random.default_rng(0)
    parts = [smooth_noise(rng, face_shape(shape, axis)) for axis in range(3)]
    parts[2] += 0.5
    velocity = Faces(*(wp.array(part, dtype=float, device=device) for part in parts))
    make_incompressible(velocity, six_sides(*SIDES))
    gain = FARTHEST / SECONDS / solver.fastest(velocity)
    velocity = Faces(*(wp.array(gain * part.numpy(), dtype=float, device=device) for part in velocity))
    smoke = plume(shape)
    cells = [wp.array(field, dtype=float, device=device) for field in (smoke, smoke / REFERENCE, 0 * smoke, 0 * smoke)]
    return FluidState(velocity, *cells)


def our_steps(shape: tuple[int, int, int], device: wp.Device) -> dict[str, Callable[[], object]]:
    """Return the steps of ours; each goes on from where it was."""
    motion = Motion(slow_motion(moving(shape, device).velocity), 2.0, 1.0, six_sides(*SIDES), project=False)
    middle = np.array([(shape[0] - 1) / 2, 0.6 * shape[2], (shape[1] - 1) / 2])
    ball = Placed(Sphere(0.12 * shape[2]), middle, np.eye(3), np.zeros(3))
    solids = build_solids([ball], shape, device, sides=six_sides(*SIDES))
    return {
        "plain": step_of(shape, device, Surroundings()),
        "forces": step_of(shape, device, Surroundings(), **FORCES),
        "guided": step_of(shape, device, Surroundings(motion=motion)),
        "ball": step_of(shape, device, Surroundings(solids=solids)),
    }


def slow_motion(velocity: Faces) -> Faces:
    """Return the low frequencies of a velocity."""
    return Faces(*(blur(part, 2.0) for part in velocity))


def step_of(shape: tuple[int, int, int], device: wp.Device, around: Surroundings, **options) -> Callable[[], object]:
    """Return one solver step of smoke of its own; velocity is put back before, so that each step is as hard."""
    chosen = replace(SimulateOptions(substeps=1), **options)
    made = Solver(Physics(chosen, Placing(shape, REFERENCE), six_sides(*SIDES)))
    state = moving(shape, device)
    velocity = state.velocity

    def step():
        state.velocity = Faces(*(wp.clone(part) for part in velocity))
        made.step(state, 1, SECONDS, around)
        wp.synchronize_device(device)

    return step


def phiflow_steps(shape: tuple[int, int, int]) -> dict[str, Callable[[], object]]:
    """Return PhiFlow's plain step by each way it has to carry."""
    from phi import flow

    widen_indices()
    names, state = ("x", "y", "z"), moving(shape, pick_device("cpu"))
    resolution = dict(zip(names, shape, strict=True))
    box = flow.Box(**resolution)
    border = {"x": flow.ZERO_GRADIENT, "y": flow.ZERO_GRADIENT, "z": (0, flow.ZERO_GRADIENT)}
    inner = [part.numpy() for part in state.velocity]
    inner[2] = inner[2][:, :, 1:]  # the faces on a floor are not PhiFlow's to store
    values = flow.stack(
        [flow.tensor(part, flow.spatial(*names)) for part in inner], flow.dual(vector=names), expand_values=True
    )
    velocity = flow.StaggeredGrid(values, flow.extrapolation.combine_sides(**border), box, **resolution)
    smoke = flow.CenteredGrid(flow.tensor(state.density.numpy(), flow.spatial(*names)), 0, box, **resolution)

    def step(carry):
        carry(smoke, velocity, SECONDS)
        carried = carry(velocity, velocity, SECONDS)
        flow.fluid.make_incompressible(carried, (), flow.Solve(rel_tol=1e-3, abs_tol=1e-5))

    def semi_lagrangian():
        step(flow.advect.semi_lagrangian)

    def maccormack():
        step(flow.advect.mac_cormack)

    return {"PhiFlow, semi-Lagrangian": semi_lagrangian, "PhiFlow, MacCormack": maccormack}


def widen_indices() -> None:
    """Let PhiML (1.16) count the entries of a matrix in 64 bits: in its 32 a grid of 46,341 voxels overflows."""
    from phiml.backend._numpy_backend import NumPyBackend

    narrow = NumPyBackend.ravel_multi_index

    def wide(self, multi_index, shape, mode="undefined"):
        return narrow(self, multi_index.astype(np.int64), shape, mode)

    NumPyBackend.ravel_multi_index = wide


def interleaved(jobs: dict[str, Callable[[], object]], repeats: int) -> dict[str, tuple[float, float]]:
    """Return the median seconds of every job, and those of all cores together, which other work disturbs less.

    The jobs take turns. Each runs once before.
    """
    for job in jobs.values():
        job()
    taken = {name: [] for name in jobs}
    for _ in range(repeats):
        for name, job in jobs.items():
            begin = time.perf_counter(), time.process_time()
            job()
            taken[name].append((time.perf_counter() - begin[0], time.process_time() - begin[1]))
    return {name: tuple(np.median(pairs, axis=0).tolist()) for name, pairs in taken.items()}


def peak_gigabytes() -> float:
    """Return the most memory this process has held so far [GB]; Linux counts in kB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9


def load() -> str:
    """Return how many processes wanted a core during the last minute."""
    return f"machine load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores"


def report(shape: tuple[int, int, int], repeats: int, device: wp.Device, peer: bool) -> None:
    """Measure one size and print it."""
    print(f"\n{' x '.join(map(str, shape))} (x, z, y), {load()}", flush=True)
    ours = our_steps(shape, device)
    for step in ours.values():
        step()
    memory = peak_gigabytes()
    times = interleaved(ours | (phiflow_steps(shape) if peer else {}), repeats)
    wall, work = times["plain"]
    for name, (taken, busy) in times.items():
        print(
            f"{name:26} {taken:8.3f} s {taken / wall:6.2f} x plain   {busy:8.3f} s of cores {busy / work:6.2f} x plain"
        )
    if not peer:
        print(f"{'PhiFlow':26} not measured: --ours, or not installed")
    print(f"peak memory of ours {memory:.2f} GB, all four states and solids together; {load()}")
    for name, step in ours.items():
        print_parts(name, step, repeats, device)


def print_parts(name: str, step: Callable[[], object], repeats: int, device: wp.Device) -> None:
    """Print the share of each part of a step, over some steps."""
    with timed_parts(device, PARTS) as parts:
        begin = time.perf_counter()
        for _ in range(repeats):
            step()
        whole = time.perf_counter() - begin
    parts["rest"] = whole - sum(parts.values())
    shares = sorted(parts.items(), key=lambda item: -item[1])
    print(f"  {name:7}" + ", ".join(f"{part} {taken / whole:.0%}" for part, taken in shares))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--quick", action="store_true", help="a small size only")
    parser.add_argument("--size", type=int, nargs=3, metavar=("X", "Z", "Y"), help="voxels along each axis")
    parser.add_argument("--repeats", type=int, default=5, help="medians of so many")
    parser.add_argument("--ours", action="store_true", help="leave PhiFlow out")
    parser.add_argument("--device", default="cpu", help="where warpfluid computes; PhiFlow uses the CPU")
    arguments = parser.parse_args()
    device = pick_device(arguments.device)
    peer = not arguments.ours and importlib.util.find_spec("phi") is not None
    print(describe(device))
    sizes = [tuple(arguments.size)] if arguments.size else QUICK_SIZES if arguments.quick else SIZES
    for shape in sizes:
        report(shape, arguments.repeats, device, peer)


if __name__ == "__main__":
    main()
