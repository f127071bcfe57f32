"""What stands in a run, made small for a page: every surface once, and where it is in each frame."""

import base64
import zlib
from collections.abc import Sequence

import numpy as np

from warpfluid.preview.scene import SOLID_COLOURS, Scene
from warpfluid.rendering.normals import corner_normals
from warpfluid.simulation.outlines import Outline

SAME = 1e-3  # voxel; a surface that has moved by a turn and a shift fits so well
DIGITS = 6  # of a pose


def pack_solids(scene: Scene, box: Sequence[int]) -> list[dict]:
    """Return the surfaces of bodies and obstacles as a page reads them.

    Args:
        scene: What is shown.
        box: Voxels of its volumes (x, z, y).

    Returns:
        For each: ``color``; ``mesh``, base64 of zlib of places (float32), triangles (uint32) and normals (int8);
        ``vertices``, how many; and ``poses``, of each frame the four columns of its place from the middle of the box
        (x, y, z) [voxel], or None. A surface that changes its form is several.

    Raises:
        ValueError: If what the run says of its bodies is damaged.
        OSError: If it cannot be read.
    """
    found: list[tuple[Outline, dict]] = []
    middle = (np.array(box)[[0, 2, 1]] - 1) / 2
    for index, frame in enumerate(scene.frames):
        for outline in scene.solids(frame, box):
            for first, part in found:
                pose = None if part["poses"][index] else find_pose(first, outline, middle)
                if pose is not None:
                    break
            else:
                part = _part(outline, len(scene.frames))
                found.append((outline, part))
                pose = np.concatenate([np.eye(3), -middle[None]])
            part["poses"][index] = [float(f"{number:.{DIGITS}g}") for number in pose.reshape(-1)]
    return [part for _, part in found]


def find_pose(first: Outline, later: Outline, middle: np.ndarray) -> np.ndarray | None:
    """Return what brings one surface to another, columns of a linear map and a shift less ``middle``, shape (4, 3).

    It is None if they are not the same surface elsewhere.
    """
    if first.kind != later.kind or not np.array_equal(first.triangles, later.triangles):
        return None
    known = np.concatenate([first.vertices, np.ones((len(first.vertices), 1))], axis=1)
    pose = np.linalg.lstsq(known, later.vertices, rcond=None)[0]
    if np.abs(known @ pose - later.vertices).max() > SAME:
        return None
    pose[3] -= middle
    return pose


def _part(outline: Outline, frames: int) -> dict:
    """Return a surface without poses; its corners share vertices where their normals are alike."""
    triangles = np.asarray(outline.triangles)
    normals = np.rint(127 * corner_normals(np.asarray(outline.vertices, float), triangles)).reshape(-1, 3)
    corners = np.concatenate([triangles.reshape(-1, 1), normals], axis=1).astype(np.int64)
    kept, places = np.unique(corners, axis=0, return_inverse=True)
    parts = (outline.vertices[kept[:, 0]].astype("<f4"), places.astype("<u4"), kept[:, 1:].astype(np.int8))
    colour = SOLID_COLOURS[outline.kind]
    return {
        "color": [round(int(colour[i : i + 2], 16) / 255, 4) for i in (1, 3, 5)],
        "vertices": len(kept),
        "mesh": base64.b64encode(zlib.compress(b"".join(part.tobytes() for part in parts), 9)).decode(),
        "poses": [None] * frames,
    }
