"""Where rigid bodies are in every frame, as JSON for animation tools: x right, y up, z to the viewer."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from warpfluid.files.atomic import replacing

VECTORS = {"position": 3, "quaternion": 4, "velocity": 3, "spin": 3}


def write_bodies(
    path: str | Path,
    names: Sequence[str],
    frames: Mapping[int, Sequence[Mapping[str, np.ndarray]]],
    *,
    voxel: float,
    origin: Sequence[float],
) -> None:
    """Write the bodies of all frames.

    Args:
        path: The file, usually ``bodies.json``; its folder must exist.
        names: One a body.
        frames: The bodies by frame number, in the order of ``names``: ``position`` (x, y, z) [voxel], ``quaternion``
            (x, y, z, w), ``velocity`` [voxel/s] and ``spin`` [radian/s]; other keys are left out.
        voxel: Edge of a voxel [scene unit].
        origin: The scene's origin (x, y, z) [voxel].

    Raises:
        ValueError: If a frame has more or fewer bodies than names, or a number is not finite.
        OSError: If the file cannot be written.
    """
    listed = []
    for frame, bodies in sorted(frames.items()):
        if len(bodies) != len(names):
            raise ValueError(f"frame {frame} has {len(bodies)} bodies, and there are {len(names)} names")
        listed.append({"frame": int(frame), "bodies": [_in_scene(body, voxel, origin, frame) for body in bodies]})
    content = {"quaternion": "x, y, z, w", "velocity": "scene unit/s", "spin": "radian/s", "names": list(names)}
    with replacing(path) as file:
        file.write((json.dumps(content | {"frames": listed}, indent=1, allow_nan=False) + "\n").encode())


def read_bodies(path: str | Path) -> tuple[list[str], dict[int, list[dict[str, np.ndarray]]]]:
    """Read what ``write_bodies`` wrote.

    Returns:
        The bodies' names, and the bodies by frame number, in scene units.

    Raises:
        ValueError: If this is no such file.
        OSError: If the file cannot be read.
    """
    text = Path(path).read_bytes()
    try:
        content = json.loads(text)
        frames = {
            int(entry["frame"]): [{name: np.array(body[name], float) for name in VECTORS} for body in entry["bodies"]]
            for entry in content["frames"]
        }
        names = [str(name) for name in content["names"]]
    except (ValueError, KeyError, TypeError, IndexError, OverflowError, RecursionError) as error:
        raise ValueError(f"{path} is no file of bodies, or it is damaged") from error
    bodies_fit = all(len(bodies) == len(names) for bodies in frames.values())
    numbers_fit = all(
        body[name].shape == (n,) and np.isfinite(body[name]).all()
        for bodies in frames.values()
        for body in bodies
        for name, n in VECTORS.items()
    )
    if not (bodies_fit and numbers_fit):
        raise ValueError(f"{path} is no file of bodies, or it is damaged")
    return names, frames


def _in_scene(body: Mapping[str, np.ndarray], voxel: float, origin: Sequence[float], frame: int) -> dict:
    """Return a body in scene units, as lists."""
    values = {name: np.asarray(body[name], np.float64) for name in VECTORS}
    for name, value in values.items():
        if value.shape != (VECTORS[name],) or not np.isfinite(value).all():
            raise ValueError(f"{name} of a body in frame {frame} is {value}, expected {VECTORS[name]} finite numbers")
    values["position"] = voxel * (values["position"] - np.asarray(origin))
    values["velocity"] = voxel * values["velocity"]
    return {name: value.tolist() for name, value in values.items()}
