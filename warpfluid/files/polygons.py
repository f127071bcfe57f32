"""Faces of many corners: cut into triangles that stay within them."""

import numpy as np

FLAT = 1e-9  # of a face's area: a corner that turns back by less is straight
MOST_CORNERS = 10_000  # of a face; the time grows with the square


def is_concave(faces: np.ndarray) -> np.ndarray:
    """Return which faces turn back at a corner, so that a fan of triangles would leave them.

    Args:
        faces: Corners in order, shape (face, corner, 3).

    Returns:
        Shape (face,).
    """
    sides = np.roll(faces, -1, axis=1) - faces
    turns = np.cross(np.roll(sides, 1, axis=1), sides)
    normals = _normals(faces)
    along = np.einsum("fci,fi->fc", turns, normals)
    return (along < -FLAT * (normals**2).sum(axis=1)[:, None]).any(axis=1)


def clip_ears(corners: np.ndarray) -> list[tuple[int, int, int]]:
    """Return triangles of corner numbers that fill one face, by clipping ears (Meisters 1975).

    Args:
        corners: In order, shape (corner, 3), about in a plane.

    Raises:
        ValueError: If there are too many.
    """
    if len(corners) > MOST_CORNERS:
        raise ValueError(f"a face has {len(corners)} corners, at most {MOST_CORNERS} are allowed")
    (normal,) = _normals(corners[None])
    drop = int(np.abs(normal).argmax())
    axes = ((1, 2), (2, 0), (0, 1))[drop]
    flat = corners[:, axes if normal[drop] > 0 else axes[::-1]]
    left, at, tried, triangles = list(range(len(flat))), 0, 0, []
    while len(left) > 3:
        if tried >= len(left) or _is_ear(flat[left], at):  # a face that crosses itself may have none
            triangles.append((left[at - 1], left[at], left[(at + 1) % len(left)]))
            del left[at]
            at, tried = at % len(left), 0
        else:
            at, tried = (at + 1) % len(left), tried + 1
    return [*triangles, tuple(left)]


def cut_obj(data: bytes) -> bytes:
    """Return an .obj file in which triangles stand for the faces that turn back at a corner."""
    lines = data.replace(b"\r\n", b"\n").replace(b"\\\n", b" ").split(b"\n")
    corners, faces = [], {}
    for row, line in enumerate(lines):
        if line[:2] in (b"v ", b"v\t"):
            corners.append(line)
        elif line[:2] in (b"f ", b"f\t"):
            words = line.partition(b"#")[0].split()[1:]
            if len(words) > 3:
                numbers = [int(word.partition(b"/")[0]) for word in words]
                numbers = [number - 1 if number > 0 else len(corners) + number for number in numbers]
                faces.setdefault(len(words), []).append((row, words, numbers))
    if not faces:
        return data
    places = np.array([line.split()[1:4] for line in corners], np.float64)
    for rows in faces.values():
        for at in np.flatnonzero(is_concave(places[[numbers for *_, numbers in rows]])):
            row, words, numbers = rows[at]
            cut = clip_ears(places[numbers])
            lines[row] = b"\n".join(b"f " + b" ".join(words[corner] for corner in triangle) for triangle in cut)
    return b"\n".join(lines)


def cut_ply(raw: dict) -> tuple[np.ndarray, np.ndarray] | None:
    """Return vertices and triangles of the elements of a .ply file; None if no face turns back at a corner.

    Args:
        raw: The elements ``vertex`` and ``face``, their properties under ``data``, as trimesh keeps them.
    """
    data = raw.get("face", {}).get("data")
    names = getattr(data, "keys", lambda: getattr(getattr(data, "dtype", None), "names", None) or ())()
    name = next((name for name in ("vertex_indices", "vertex_index") if name in names), None)
    if name is None:
        return None
    column = data[name]
    lists = column["f1"] if getattr(column, "dtype", np.dtype(int)).names else column
    if np.ndim(lists) == 2 and np.shape(lists)[1] == 3:
        return None
    faces = [np.asarray(face, np.int64).reshape(-1) for face in lists]
    places = np.column_stack([raw["vertex"]["data"][axis] for axis in "xyz"]).astype(np.float64)
    concave = _concave_rows(faces, places)
    if not concave:
        return None
    cut = [
        clip_ears(places[face]) if row in concave else [(0, at, at + 1) for at in range(1, len(face) - 1)]
        for row, face in enumerate(faces)
    ]
    triangles = [face[np.array(part)] for face, part in zip(faces, cut, strict=True) if part]
    return places, np.concatenate(triangles)


def _concave_rows(faces: list[np.ndarray], places: np.ndarray) -> set[int]:
    """Return the numbers of the faces that turn back at a corner."""
    sizes: dict[int, list[int]] = {}
    for row, face in enumerate(faces):
        if len(face) > 3:
            sizes.setdefault(len(face), []).append(row)
    found = set()
    for rows in sizes.values():
        found.update(np.array(rows)[is_concave(places[np.array([faces[row] for row in rows])])].tolist())
    return found


def _normals(faces: np.ndarray) -> np.ndarray:
    """Return twice the area of each face along its normal (Newell), shape (face, 3)."""
    from_first = faces - faces[:, :1]
    return np.cross(from_first, np.roll(from_first, -1, axis=1)).sum(axis=1)


def _is_ear(flat: np.ndarray, at: int) -> bool:
    """Return whether a corner sticks out and nothing of the face, counterclockwise, lies in its triangle."""
    ear = flat[[at - 1, at, (at + 1) % len(flat)]]
    if not _left_of(ear[0], ear[1], ear[2]) > 0:
        return False
    others = flat[~(flat[:, None] == ear).all(axis=2).any(axis=1)]
    sides = [_left_of(ear[side], ear[(side + 1) % 3], others) >= 0 for side in range(3)]
    return not np.logical_and.reduce(sides).any()


def _left_of(a: np.ndarray, b: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Return how far points lie left of a line, times its length."""
    return (b[0] - a[0]) * (point[..., 1] - a[1]) - (b[1] - a[1]) * (point[..., 0] - a[0])
