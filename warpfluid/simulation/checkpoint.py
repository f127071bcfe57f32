"""The state of a simulation on disk, so that it goes on bit for bit."""

import io
import zipfile
import zlib
from collections.abc import Sequence

import numpy as np
import warp as wp

from warpfluid.files.atomic import replacing
from warpfluid.run import CHECKPOINT, Run
from warpfluid.simulation.detail import Detail
from warpfluid.simulation.rigid_body import RigidBody
from warpfluid.simulation.state import CELLS, Faces, FluidState

DAMAGE = (KeyError, OSError, ValueError, EOFError, TypeError, zipfile.BadZipFile, zlib.error)


def save_state(
    run: Run, frame: int, state: FluidState, bodies: Sequence[RigidBody], detail: Detail | None = None
) -> None:
    """Write the state after a frame in place of the one before."""
    arrays = {name: getattr(state, name).numpy() for name in CELLS}
    arrays |= {f"velocity_{name}": part.numpy() for name, part in zip("xzy", state.velocity, strict=True)}
    arrays |= {"frame": np.array(frame), "clock": np.array([state.seconds, state.phase], np.float64)}
    if state.away:
        arrays |= {f"away_{name}": part.numpy() for name, part in zip("xzy", state.away, strict=True)}
    if state.shadow:
        arrays["shadow"] = state.shadow.numpy()
    for number, body in enumerate(bodies):
        arrays |= {f"body{number}_{name}": value for name, value in body.state().items()}
    if detail:
        arrays |= {f"detail_{name}": value for name, value in detail.state().items()}
    with replacing(run.folder / CHECKPOINT) as file:
        np.savez(file, **arrays)


def checkpoint_frame(run: Run) -> int | None:
    """Return the frame of a run's checkpoint, None if there is none or it is damaged."""
    try:
        with (run.folder / CHECKPOINT).open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            return int(arrays["frame"])
    except DAMAGE:
        return None


def load_state(run: Run, state: FluidState, bodies: Sequence[RigidBody], detail: Detail | None = None) -> int | None:
    """Take a simulation back to a run's checkpoint.

    Returns:
        The frame of the checkpoint; None if there is none that fits, and nothing is changed.
    """
    try:
        data = io.BytesIO((run.folder / CHECKPOINT).read_bytes())
        with np.load(data, allow_pickle=False) as arrays:
            found = {name: arrays[name] for name in arrays.files}
        device = state.density.device
        cells = {name: found[name] for name in CELLS}
        faces = [found[f"velocity_{name}"] for name in "xzy"]
        there = [*(getattr(state, name) for name in CELLS), *state.velocity]
        if [a.shape for a in (*cells.values(), *faces)] != [a.shape for a in there]:
            return None
        moved = [{name: found[f"body{n}_{name}"] for name in body.state()} for n, body in enumerate(bodies)]
        patterns = {name: found[f"detail_{name}"] for name in detail.state()} if detail else {}
        away = [found[f"away_{name}"] for name in "xzy"] if "away_x" in found else []
        shadow = found.get("shadow")
        seconds, phase = map(float, found["clock"])
        frame = int(found["frame"])
    except DAMAGE:
        return None
    for name, values in cells.items():
        setattr(state, name, wp.array(values, dtype=float, device=device))
    state.velocity = Faces(*(wp.array(values, dtype=float, device=device) for values in faces))
    state.seconds, state.phase = seconds, phase
    state.away = tuple(wp.array(values, dtype=float, device=device) for values in away) or None
    state.shadow = None if shadow is None else wp.array(shadow, dtype=float, device=device)
    if detail:
        detail.restore(patterns)
    for body, values in zip(bodies, moved, strict=True):
        body.restore(values)
    return frame
