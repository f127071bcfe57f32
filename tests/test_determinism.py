"""The same input and options give the same bits, whoever works: any number of threads and processes, any cut of work.

Volumes, pictures, films and exports are compared byte by byte. Left out is what tells of a run and not of its result:
seconds, and the names of folders.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st
from threadpoolctl import threadpool_info
from tiny import flame

import warpfluid as wf
from warpfluid.device import one_blas_thread
from warpfluid.files.lines import read_lines
from warpfluid.kernels import launch
from warpfluid.options import SimulateOptions
from warpfluid.simulation.physics import Physics
from warpfluid.simulation.placing import Placing
from warpfluid.simulation.solver import Solver, Surroundings
from warpfluid.simulation.state import Faces, FluidState, face_shape, six_sides

PROGRAM = Path(__file__).with_name("everything.py")
# Threads, those of a BLAS, seed of Python's hashes, what fresh memory holds; then the arguments of the program.
WAYS = {
    "one thread": ((1, 1, 0, 1), (16, 4, 1 << 18, 1)),
    "two threads and processes": ((2, 2, 1, 85), (16, 4, 1 << 18, 2)),
    "three threads, small pieces": ((3, 2, 2, 170), (5, 3, 20000, 1)),
    "seven threads, few rows": ((7, 2, 3, 254), (2, 1, 90000, 1)),
}
NAMES = ("WARPFLUID_THREADS", "OPENBLAS_NUM_THREADS", "PYTHONHASHSEED", "MALLOC_PERTURB_")
ABOUT_THE_RUN = {"run.toml", "export.json", "open_in_blender.py"}
OPTIONS = wf.ReconstructOptions(angles=12, iterations=1, cg_steps=2, lsm_steps=2)
SHAPE = (20, 18, 50)
# What a card may differ by from the CPU, RMS as a part of the largest value. Pictures changed by one part in ten
# million do so by 3e-7 after one iteration and 2.4e-4 after eight, a step by 3e-7; its pressure is found another way.
NEAR = {"one iteration": 1e-4, "eight iterations": 2e-3, "a step": 1e-3}


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> dict[str, dict[str, bytes]]:
    """What each way of working writes, by file name; two at a time."""
    folders = {way: tmp_path_factory.mktemp("made") for way in WAYS}
    ways = list(WAYS)
    for pair in (ways[:2], ways[2:]):
        running = {way: start(way, folders[way]) for way in pair}
        for way, process in running.items():
            said = process.communicate(timeout=300)[0]
            assert process.returncode == 0, f"{way}: {said}"
    return {way: contents(folder) for way, folder in folders.items()}


def start(way: str, folder: Path) -> subprocess.Popen:
    surroundings, arguments = WAYS[way]
    environment = os.environ | {name: str(value) for name, value in zip(NAMES, surroundings, strict=True)}
    command = [sys.executable, str(PROGRAM), str(folder), *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment)


def contents(folder: Path) -> dict[str, bytes]:
    """Return files by name; of records all but the seconds."""
    found = {}
    for path in sorted(path for path in folder.rglob("*") if path.is_file() and path.name not in ABOUT_THE_RUN):
        data = path.read_bytes()
        if path.suffix == ".jsonl":
            lines = [json.dumps(record | {"seconds": 0}) for record in read_lines(path)]  # without their checksums
            data = "\n".join(sorted(lines)).encode()
        found[str(path.relative_to(folder))] = data
    return found


@pytest.mark.parametrize("way", list(WAYS)[1:])
def test_everything_has_the_same_bits(made, way):
    """Reconstructions of all kinds, simulations, flows, pictures, films, exports."""
    reference, other = made["one thread"], made[way]
    assert set(other) == set(reference)
    assert [name for name, data in other.items() if data != reference[name]] == []
    endings = {Path(name).suffix for name in reference}
    assert {".vdb", ".nvdb", ".vti", ".npz", ".usda", ".exr", ".png", ".mp4", ".webp", ".jsonl"} <= endings
    assert len(reference) > 80


def one_frame(device: str = "cpu", options: wf.ReconstructOptions = OPTIONS) -> list[np.ndarray]:
    """Return a volume of two views."""
    images = np.stack([flame(1, k, 20, 50)[::-1].T for k in range(2)]).astype(np.float32)
    return [wf.reconstruct(wf.Views(images, (0, 90)), options, device=device).volume]


def one_step(device: str = "cpu") -> list[np.ndarray]:
    """Return the state after a solver step with all forces."""
    rng = np.random.default_rng(0)
    faces = (rng.standard_normal(face_shape(SHAPE, axis)).astype(np.float32) for axis in range(3))
    velocity = Faces(*(wp.array(part, dtype=float, device=device) for part in faces))
    cells = [wp.array(rng.random(SHAPE, np.float32), dtype=float, device=device) for _ in range(4)]
    forces = {"swirl": 2.0, "turbulence_strength": 1.0, "temperature_buoyancy": 2.0, "viscosity": 1.0}
    options = SimulateOptions(substeps=1, combustion=True, **forces)
    solver = Solver(Physics(options, Placing(SHAPE, 1.0), six_sides("open", "wrap", "closed-low")))
    state = FluidState(velocity, *cells)
    solver.step(state, 1, 1 / 24, Surroundings())
    return [part.numpy() for part in (*state.velocity, state.density, state.temperature, state.fuel, state.flame)]


@pytest.fixture(scope="module")
def bits() -> bytes:
    """A frame and a step, as they are cut by default."""
    return b"".join(part.tobytes() for part in (*one_frame(), *one_step()))


@settings(max_examples=12)
@given(threads=st.integers(1, 9), rows=st.integers(1, 60), columns=st.integers(1, 60), elements=st.integers(900, 90000))
def test_any_cut_has_the_same_bits(bits, threads, rows, columns, elements):
    """However launches are parted, and among however many threads."""
    cut = {"_ROWS_A_JOB": rows, "_ROWS_OF_WHOLE_COLUMNS_A_JOB": columns, "_ELEMENTS_A_JOB": elements}
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("WARPFLUID_THREADS", str(threads))
        for name, value in cut.items():
            patch.setattr(launch, name, value)
        assert b"".join(part.tobytes() for part in (*one_frame(), *one_step())) == bits


def test_linear_algebra_has_one_thread():
    """Within, and as many as before after; or its bits would depend on them."""

    def threads():
        return [library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"]

    before = threads()
    with one_blas_thread():
        assert set(threads()) <= {1}
    assert threads() == before


@pytest.mark.parametrize("device", [str(device) for device in wp.get_devices() if device.is_cuda])
@pytest.mark.parametrize("what", list(NEAR))
def test_a_card_repeats_itself_and_is_near_the_cpu(what, device):
    """Its sums are rounded otherwise, so it has bits of its own: always the same ones, and near the CPU's."""
    options = OPTIONS if what == "one iteration" else wf.ReconstructOptions(angles=24)
    make = one_step if what == "a step" else lambda where: one_frame(where, options)
    cpu, card, again = (make(where) for where in ("cpu", device, device))
    for expected, found, repeated in zip(cpu, card, again, strict=True):
        assert found.tobytes() == repeated.tobytes()
        assert np.sqrt(np.mean((found - expected) ** 2)) <= NEAR[what] * np.abs(expected).max()
