"""USD stages as text (``.usda``): volumes in ``.vdb`` files beside them, frame by frame, and bodies that move.

Written without the USD library, which is large; the format is plain text.
"""

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from warpfluid.files.atomic import replacing


@dataclass(frozen=True)
class UsdBody:
    """A surface that moves as one.

    Attributes:
        name: What it is called.
        vertices: Shape (n, 3), about its own middle [scene unit].
        triangles: Indices, shape (m, 3).
        poses: By frame where its middle is, shape (3,), and how it is turned, as a quaternion (x, y, z, w).
    """

    name: str
    vertices: np.ndarray
    triangles: np.ndarray
    poses: Mapping[int, tuple[np.ndarray, np.ndarray]]


def write_usda(
    path: str | Path,
    files: Mapping[int, str],
    grids: Mapping[str, str],
    *,
    extent: np.ndarray,
    up: Literal["y", "z"] = "y",
    fps: float = 24.0,
    half: bool = False,
    bodies: Sequence[UsdBody] = (),
) -> None:
    """Write a stage that shows volumes.

    Args:
        path: The file; its folder must exist.
        files: The ``.vdb`` file of every frame, relative to the stage.
        grids: Type by name of the files' grids, ``float`` or ``vec3s``.
        extent: First and last corner of the box [scene unit], shape (2, 3), in the stage's axes.
        up: The stage's up axis.
        fps: Frames a second.
        half: Whether the grids are stored in 16 bits.
        bodies: What moves among them, in the stage's axes.

    Raises:
        ValueError: If there are no files, or the name of one has no place in a stage.
        OSError: If the stage cannot be written.
    """
    if not files:
        raise ValueError("there are no files to show: export at least one frame")
    odd = [file for file in files.values() if "@@" in file or file.endswith("@") or not file.isprintable()]
    if odd:
        raise ValueError(f"a stage cannot name the file {odd[0]!r}: rename it")
    lines = [
        "#usda 1.0",
        "(",
        '    defaultPrim = "warpfluid"',
        f"    endTimeCode = {max(files)}",
        f"    framesPerSecond = {fps:g}",
        "    metersPerUnit = 1",
        f"    startTimeCode = {min(files)}",
        f"    timeCodesPerSecond = {fps:g}",
        f'    upAxis = "{up.upper()}"',
        ")",
        "",
        'def Xform "warpfluid"',
        "{",
        *_indent([*_volume(files, grids, extent, half), *_bodies(bodies)]),
        "}",
        "",
    ]
    with replacing(path) as file:
        file.write("\n".join(lines).encode())


def _volume(files: Mapping[int, str], grids: Mapping[str, str], extent: np.ndarray, half: bool) -> list[str]:
    names = _identifiers(grids)
    lines = ['def Volume "volume"', "{", f"    float3[] extent = [{', '.join(_tuple(corner) for corner in extent)}]"]
    lines += [f"    rel field:{plain} = </warpfluid/volume/{plain}>" for plain in names.values()]
    for name, kind in grids.items():
        number = "half" if half else "float"
        data = number if kind == "float" else f"{number}3"
        lines += ["", f'    def OpenVDBAsset "{names[name]}"', "    {"]
        lines += [f'        token fieldClass = "{"fogVolume" if kind == "float" else "unknown"}"']
        lines += [f'        token fieldDataType = "{data}"', f"        token fieldName = {_quoted(name)}"]
        lines += ['        token vectorDataRoleHint = "Vector"'] if kind != "float" else []
        lines += ["        asset filePath.timeSamples = {"]
        lines += [f"            {frame}: {_asset(file)}," for frame, file in sorted(files.items())]
        lines += ["        }", "    }"]
    return [*lines, "}"]


def _bodies(bodies: Sequence[UsdBody]) -> list[str]:
    names = _identifiers(["volume", *(f"{body.name}\0{number}" for number, body in enumerate(bodies))])
    return [line for body, name in zip(bodies, list(names.values())[1:], strict=True) for line in _body(body, name)]


def _body(body: UsdBody, name: str) -> list[str]:
    frames = sorted(body.poses)
    moves = [f"        {frame}: {_tuple(body.poses[frame][0])}," for frame in frames]
    turns = [f"        {frame}: {_tuple(np.roll(body.poses[frame][1], 1))}," for frame in frames]  # USD has w first
    points = ", ".join(_tuple(point) for point in body.vertices)
    corners = np.array([body.vertices.min(axis=0), body.vertices.max(axis=0)])
    return [
        "",
        f'def Xform "{name}"',
        "{",
        "    double3 xformOp:translate.timeSamples = {",
        *moves,
        "    }",
        "    quatf xformOp:orient.timeSamples = {",
        *turns,
        "    }",
        '    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:orient"]',
        "",
        '    def Mesh "surface"',
        "    {",
        f"        float3[] extent = [{', '.join(_tuple(corner) for corner in corners)}]",
        f"        int[] faceVertexCounts = [{', '.join(['3'] * len(body.triangles))}]",
        f"        int[] faceVertexIndices = [{', '.join(map(str, body.triangles.ravel().tolist()))}]",
        f"        point3f[] points = [{points}]",
        '        uniform token subdivisionScheme = "none"',
        "    }",
        "}",
    ]


def _indent(lines: list[str]) -> list[str]:
    return [f"    {line}" if line else "" for line in lines]


def _tuple(numbers: np.ndarray) -> str:
    return f"({', '.join(f'{float(number):.9g}' for number in numbers)})"


def _asset(file: str) -> str:
    """Return a path beside the stage, between signs that it does not hold."""
    sign = "@@@" if "@" in file else "@"
    return f"{sign}./{file}{sign}"


def _quoted(name: str) -> str:
    """Return a name as a string of USD; what would end the line stands for itself nowhere."""
    return json.dumps(name, ensure_ascii=False).replace("\\u00", "\\x")


def _identifiers(names: Iterable[str]) -> dict[str, str]:
    """Return by name one that USD takes: letters, digits and underscores; each another, whatever they were."""
    found: dict[str, str] = {}
    for name in names:
        plain = re.sub(r"\W", "_", name.partition("\0")[0], flags=re.ASCII)
        plain = plain if re.match(r"[A-Za-z_]", plain) else f"_{plain}"
        free = (plain, *(f"{plain}_{number}" for number in range(2, len(found) + 3)))
        found[name] = next(name for name in free if name not in found.values())
    return found
