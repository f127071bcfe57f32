"""What a simulated frame leaves on disk besides its density."""

from typing import NamedTuple

import numpy as np
import warp as wp

from warpfluid.files.bodies import read_bodies, write_bodies
from warpfluid.options import OutputOptions
from warpfluid.run import BODIES, Run
from warpfluid.simulation.placing import Placing
from warpfluid.simulation.rigid_body import RigidBody
from warpfluid.simulation.source import Source
from warpfluid.simulation.state import CELLS, Faces, FluidState

RIM = 2  # voxels around fluid, along each axis, in which motion and heat are stored


class Fields(NamedTuple):
    """What a frame is written of.

    Attributes:
        cells: Fields of ``FluidState`` by name, shape (x, z, y).
        velocity: Components along x, z and y in the voxels [voxel/s], the same shape.
    """

    cells: dict[str, np.ndarray]
    velocity: list[np.ndarray]


def fields_of(state: FluidState) -> Fields:
    """Return a fluid as it is written on its own grid."""
    return Fields({name: getattr(state, name).numpy() for name in CELLS}, centred(state.velocity))


def grids_of(
    fields: Fields, placing: Placing, source: Source, output: OutputOptions, *, burns: bool, rim: int = RIM
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return the density (x, z, y), in the source's unit, and further grids by name.

    Velocity is in scene units a second, shape (x, z, y, 3) with components (x, y, z); it, temperature and the rest are
    stored where there is fluid, and ``rim`` voxels around it.
    """
    density = fields.cells["density"] / np.float32(source.volumes.scale)
    near = widen(density > output.drop_below * density.max(), rim)
    names = ["temperature", *(("fuel", "flame") if burns else ())]
    full = {"temperature": 1.0, "fuel": source.volumes.scale, "flame": placing.reference}
    grids = {name: np.where(near, fields.cells[name] / np.float32(full[name]), 0) for name in names}
    grids["velocity"] = np.zeros((*near.shape, 3), np.float32)
    x, z, y = (part * np.float32(output.voxel_size) for part in fields.velocity)
    for component, part in enumerate((x, y, z)):
        np.copyto(grids["velocity"][..., component], part, where=near)
    return density, {name: grid.astype(np.float32, copy=False) for name, grid in grids.items()}


def widen(mask: np.ndarray, voxels: int) -> np.ndarray:
    """Return a mask grown by some voxels along each axis."""
    for axis in range(mask.ndim):
        grown = mask.copy()
        to, source = np.moveaxis(grown, axis, 0), np.moveaxis(mask, axis, 0)
        for far in range(1, voxels + 1):
            to[far:] |= source[:-far]
            to[:-far] |= source[far:]
        mask = grown
    return mask


def centred(velocity: Faces) -> list[np.ndarray]:
    """Return the components of a velocity in the voxels, the mean of both faces, along x, z and y."""
    parts = []
    for axis, part in enumerate(velocity):
        faces = np.moveaxis(part.numpy() if isinstance(part, wp.array) else part, axis, 0)
        parts.append(np.moveaxis((faces[1:] + faces[:-1]) / 2, 0, axis))
    return parts


def write_transforms(run: Run, frame: int, bodies: list[RigidBody], placing: Placing, voxel: float) -> None:
    """Add the bodies of a frame to ``bodies.json`` of a run."""
    path = run.folder / BODIES
    origin = placing.origin
    frames = read_bodies(path)[1] if path.exists() else {}
    earlier = {number: [_in_voxels(body, voxel, origin) for body in found] for number, found in frames.items()}
    names = [f"body{number}" for number in range(1, len(bodies) + 1)]
    kept = {number: found for number, found in earlier.items() if number < frame and len(found) == len(bodies)}
    write_bodies(path, names, kept | {frame: [body.state() for body in bodies]}, voxel=voxel, origin=origin)


def _in_voxels(body: dict[str, np.ndarray], voxel: float, origin: np.ndarray) -> dict[str, np.ndarray]:
    return body | {"position": body["position"] / voxel + origin, "velocity": body["velocity"] / voxel}
