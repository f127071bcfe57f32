"""What stands around exported volumes: bodies, speed, the box, for stages and scripts."""

from pathlib import Path

import numpy as np

from warpfluid.files.usd import UsdBody as Body
from warpfluid.files.usd import write_usda
from warpfluid.options import ExportOptions
from warpfluid.volumes import VolumeSequence

FPS = 24.0
BLENDER_SCENE = Path(__file__).with_name("blender_scene.py")  # the script that an export for Blender gets a copy of


def find_bodies(sequence: VolumeSequence, options: ExportOptions) -> list[Body]:
    """Return the rigid bodies of a simulated run, y up [scene unit]; none of other volumes.

    Raises:
        ValueError: If the file of bodies is damaged or does not fit the settings.
        OSError: If it cannot be read.
    """
    if not (sequence.document or {}).get("body") or options.format not in ("usda", "blender"):
        return []
    from warpfluid.simulation.recorded import RecordedBodies

    recorded = RecordedBodies(sequence.document, Path(sequence.name).expanduser())
    if not recorded.names:
        return []
    first = sequence.frames[0]
    file = sequence.read(first, ["density"])
    x, y, z = file.grids["density"].shape
    factor = (options.voxel_size or file.voxel_size) / file.voxel_size
    bodies = []
    for i, (name, body) in enumerate(zip(recorded.names, recorded.place((x, z, y), first), strict=True)):
        poses = {f: (factor * listed[i]["position"], listed[i]["quaternion"]) for f, listed in recorded.states.items()}
        vertices = np.asarray(body.vertices, float) * file.voxel_size * factor
        bodies.append(Body(name, vertices, np.asarray(body.triangles), poses))
    return bodies


def scene_facts(sequence: VolumeSequence, options: ExportOptions) -> dict:
    """Return what scenes need to know and files do not tell."""
    simulated = (sequence.document or {}).get("simulate", {})
    footage = (sequence.document or {}).get("input", {})
    return {
        "fps": float(options.fps or simulated.get("fps") or FPS),
        "up": options.file_up,
        "tone": "Raw" if footage.get("decode", "linear") == "none" else "Standard",  # as the footage was read
        "look": sequence.output.look if sequence.document else None,
        "velocity": options.velocity_name,
        "bodies": [],
    }


def body_facts(bodies: list[Body]) -> list[dict]:
    """Return bodies as plain values."""
    return [
        {
            "name": body.name,
            "vertices": body.vertices.tolist(),
            "triangles": body.triangles.tolist(),
            "poses": {str(frame): [p.tolist(), q.tolist()] for frame, (p, q) in sorted(body.poses.items())},
        }
        for body in bodies
    ]


def write_stage(path: Path, record: dict, bodies: list[Body], options: ExportOptions) -> None:
    """Write the USD stage of an export.

    Args:
        path: The stage, beside the volumes.
        record: What is noted of the export.
        bodies: What moves in it, y up.
        options: How it is written.

    Raises:
        OSError: If it cannot be written.
    """
    frames = record["frames"]
    corners = np.array([_corners(facts) for facts in frames.values()])
    extent = np.array([corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)])
    grids = {name: kind for facts in frames.values() for name, kind in facts["grids"].items()}
    if options.file_up == "z":
        extent = np.array([_stand_up(extent).min(axis=0), _stand_up(extent).max(axis=0)])
        bodies = [_turned(body) for body in bodies]
    write_usda(
        path,
        {int(frame): facts["file"] for frame, facts in frames.items()},
        grids,
        extent=extent,
        up=options.file_up,
        fps=record["fps"],
        half=options.half,
        bodies=bodies,
    )


def _corners(facts: dict) -> np.ndarray:
    """Return the first and the last corner of a frame's box, y up."""
    size, origin = facts["voxel_size"], np.array(facts["origin"])
    return np.array([origin - size / 2, origin + size * (np.array(facts["shape"]) - 0.5)])


def _stand_up(points: np.ndarray) -> np.ndarray:
    """Return points in the axes of a file whose z is up: (x, y, z) becomes (x, -z, y)."""
    return np.stack([points[..., 0], 0 - points[..., 2], points[..., 1]], axis=-1)


def _turned(body: Body) -> Body:
    """Return a body in a world whose z is up; its axis of rotation turns with the world."""
    poses = {f: (_stand_up(p), np.concatenate([_stand_up(q[:3]), q[3:]])) for f, (p, q) in body.poses.items()}
    return Body(body.name, _stand_up(body.vertices), body.triangles, poses)
