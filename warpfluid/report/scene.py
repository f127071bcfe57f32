"""What stands in the box of a simulation, and where its rigid bodies went."""

from collections.abc import Sequence
from dataclasses import fields

import numpy as np

from warpfluid.files.bodies import read_bodies
from warpfluid.options import THINGS, BodyOptions, Scene
from warpfluid.run import BODIES, Run


def scene_rows(scene: Scene) -> list[dict[str, object]]:
    """Return a row for everything in the box: what it is, and what is not as usual."""
    rows = []
    for kind in THINGS:
        for thing in getattr(scene, kind):
            usual, shape = type(thing)(), "kind" if kind == "force" else "shape"
            changed = [
                field.name for field in fields(thing) if getattr(thing, field.name) != getattr(usual, field.name)
            ]
            told = "  ".join(f"{name}={getattr(thing, name)}" for name in changed if name != shape)
            rows.append({"thing": kind, "shape": getattr(thing, shape), "choices": told or "as usual"})
    return rows


def body_rows(run: Run, bodies: Sequence[BodyOptions]) -> list[dict[str, object]]:
    """Return a row for every rigid body: where it was first and last, and how fast it became [scene units].

    Raises:
        ValueError: If the file of the bodies is damaged.
    """
    path = run.folder / BODIES
    if not bodies or not path.is_file():
        return []
    names, frames = read_bodies(path)
    if not frames:
        return []
    first, last = min(frames), max(frames)
    rows = []
    for i, name in enumerate(names):
        speeds = {frame: float(np.linalg.norm(found[i]["velocity"])) for frame, found in frames.items()}
        fastest = max(speeds, key=speeds.get)
        rows.append(
            {
                "body": name,
                f"at frame {first} (x, y, z)": _place(frames[first][i]["position"]),
                f"at frame {last}": _place(frames[last][i]["position"]),
                "fastest [unit/s]": speeds[fastest],
                "in frame": fastest,
            }
        )
    return rows


def _place(position: np.ndarray) -> str:
    return ", ".join(f"{part:.2f}".replace("-", "−") for part in np.round(position, 2) + 0.0)
