"""What the scripts of the paper's figures share: scenes whose truth is known, the systems, scores, pictures, tables."""

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import cache
from hashlib import sha256
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[1]))

import warpfluid as wf
from warpfluid.files.images import write_png
from warpfluid.metrics import compare_pictures, grid_index, psnr
from warpfluid.options import ReconstructOptions

BETWEEN = (10, 20, 30, 40, 50, 60, 70, 80, 100, 115, 130, 145, 160)  # unseen by pairs at 0 and 90 [degree]
FLOOR_DEG = 10  # the truth's own view as far aside is the floor of a distance
SCORES = ("patch_swd", "band_w1", "log_spectrum", "perimeter", "gradient_ratio")
MUTATIONS = 4_000_000_000  # of the paper
METHODS = {
    "LSM": {"method": "lsm"},
    "multiplication": {"method": "multiplication"},
    "ST-SAD": {"method": "stochastic"},
    "ours, paper": {},
    "ours, default": None,
}


@cache
def arguments() -> argparse.Namespace:
    """Return what the command line asks for."""
    parser = argparse.ArgumentParser(description=sys.modules["__main__"].__doc__ or __doc__)
    size = parser.add_mutually_exclusive_group()
    size.add_argument("--full", action="store_const", const=2, dest="scale", help="the paper's sizes: hours")
    size.add_argument("--tiny", action="store_const", const=0, dest="scale", help="as small as it goes, for a test")
    parser.add_argument("--out", type=Path, help="folder of pictures and tables; volumes there are used again")
    parser.add_argument("--data", type=Path, help="folder of true volumes, such as fire.npz; the solver's by default")
    parser.set_defaults(scale=1)
    found = parser.parse_args()
    found.out = found.out or Path(tempfile.mkdtemp(prefix="warpfluid-paper-"))
    found.out.mkdir(parents=True, exist_ok=True)
    return found


def pick(tiny, quick, full):
    """Return the one of three values that suits the size that was asked for."""
    return (tiny, quick, full)[arguments().scale]


def cached(name: str, make: Callable[[], dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Return arrays by name, made once and kept in the folder of the pictures."""
    path = arguments().out / "volumes" / f"{name}.npz"
    if not path.exists():
        path.parent.mkdir(exist_ok=True)
        np.savez_compressed(path, **make())
    with np.load(path) as found:
        return dict(found)


def project(volume: np.ndarray, angles_deg: Sequence[float]) -> np.ndarray:
    """Return ray sums of a volume (x, z, y), shape (angle, u, v)."""
    return wf.Projector(tuple(map(float, angles_deg)), volume.shape, device="cpu").project(volume)


def views_of(volume: np.ndarray, angles_deg: Sequence[float]) -> wf.Views:
    """Return what cameras at some angles see of a volume."""
    return wf.Views(project(volume, angles_deg), tuple(map(float, angles_deg)))


def model(views: wf.Views, name: str, statistics: wf.Views | None = None, **changes) -> dict[str, np.ndarray]:
    """Model views with one of ``METHODS`` and some options of it changed.

    Args:
        views: The inputs.
        name: The system.
        statistics: Views that say how unseen ones look, in place of the inputs.
        **changes: Options of the system.

    Returns:
        The volume and its start, ``energies`` and ``seconds``; kept, so that figures share what is made.
    """
    chosen = METHODS[name]
    if name == "ST-SAD" and arguments().scale == 2:
        changes = {"mutations": MUTATIONS} | changes
    few = {"angles": 60} if arguments().scale == 0 else {}
    if chosen is None:
        options = ReconstructOptions(**few | changes)
    else:
        options = ReconstructOptions.paper(**few | chosen | changes)

    def make() -> dict[str, np.ndarray]:
        begin = time.perf_counter()
        result = wf.reconstruct(views, options, statistics=statistics, device="cpu")
        seconds = np.array(time.perf_counter() - begin)
        return {"volume": result.volume, "initial": result.initial, "energies": result.energies, "seconds": seconds}

    asked = json.dumps([asdict(options), views.angles_deg], sort_keys=True).encode()
    given = b"".join(found.images.tobytes() for found in (views, statistics) if found)
    return cached(sha256(asked + given).hexdigest()[:16], make)


def pictures(volume: np.ndarray, angles_deg: Sequence[float]) -> list[np.ndarray]:
    """Return how a volume looks, (rows, columns), top row first."""
    return [image.T[::-1] for image in project(volume, angles_deg)]


def score(
    volume: np.ndarray, truth: np.ndarray, inputs_deg: Sequence[float], unseen_deg=BETWEEN, *, given_deg=None
) -> dict[str, float]:
    """Measure a volume against the truth.

    Args:
        volume: Shape (x, z, y).
        truth: The true one.
        inputs_deg: Angles along which it may be woven.
        unseen_deg: Angles of views that are compared with the true ones.
        given_deg: Angles of the inputs, where they are fewer.

    Returns:
        Mean distances of unseen views, the grid index, PSNR of the inputs [dB], relative error of the volume.
    """
    given_deg = inputs_deg if given_deg is None else given_deg
    pairs = zip(pictures(volume, unseen_deg), pictures(truth, unseen_deg), strict=True)
    row = _means([compare_pictures(made, true) for made, true in pairs])
    row["grid_index"] = grid_index(volume, inputs_deg)
    given = zip(project(volume, given_deg), project(truth, given_deg), strict=True)
    row["input_psnr"] = float(np.mean([psnr(made, true) for made, true in given]))
    row["volume_error"] = float(np.sqrt(((volume - truth) ** 2).mean() / (truth**2).mean()))
    return row


def floor(truth: np.ndarray, inputs_deg: Sequence[float], unseen_deg=BETWEEN) -> dict[str, float]:
    """Return what the truth scores, seen from some degrees aside."""
    aside = pictures(truth, [angle + FLOOR_DEG for angle in unseen_deg])
    pairs = zip(aside, pictures(truth, unseen_deg), strict=True)
    return _means([compare_pictures(made, true) for made, true in pairs]) | {
        "grid_index": grid_index(truth, inputs_deg)
    }


def _means(rows: list[dict[str, float]]) -> dict[str, float]:
    return {name: float(np.mean([row[name] for row in rows])) for name in SCORES}


def tell(name: str, rows: dict[str, dict[str, float]]) -> None:
    """Print a table, a row a system, and write it as Markdown beside the pictures."""
    columns = list(dict.fromkeys(column for row in rows.values() for column in row))
    cells = [["", *columns], ["---"] * (len(columns) + 1)]
    cells += [[label, *(_number(row.get(column)) for column in columns)] for label, row in rows.items()]
    text = "\n".join(f"| {' | '.join(line)} |" for line in cells)
    (arguments().out / f"{name}.md").write_text(f"{text}\n", "utf-8")
    print(f"{name}\n{text}")


def _number(value) -> str:
    if value is None or isinstance(value, str):
        return value or ""
    return f"{value:.3g}" if abs(value) < 1e4 else f"{value:.2e}"


def save(name: str, picture: np.ndarray) -> None:
    """Write a picture, uint8 (rows, columns[, 3]), and say where."""
    path = arguments().out / f"{name}.png"
    write_png(path, picture)
    print(f"wrote {path}")


def show(volumes: dict[str, np.ndarray], angles_deg: Sequence[float], *, slices: int = 0) -> np.ndarray:
    """Return a row a volume: how it looks at some angles, and a few horizontal slices from above."""
    from gallery import captioned, stack

    from warpfluid.rendering.turntable import in_a_row, slices_picture, strip

    rows = []
    for name, volume in volumes.items():
        row = strip(volume, angles_deg)
        if slices:
            lit = np.flatnonzero(volume.max(axis=(0, 1)) > 0.01 * volume.max())
            heights = np.linspace(lit[0], lit[-1], slices + 2).astype(int)[1:-1]
            seen = slices_picture(volume, heights).repeat(2, axis=0).repeat(2, axis=1)
            above = row.shape[0] - seen.shape[0]
            row = in_a_row([row, np.pad(seen, ((max(above, 0), 0), (0, 0), (0, 0)))[-row.shape[0] :]])
        rows.append(captioned(row, name))
    return stack(rows)


def compare(name: str, inputs_deg: Sequence[float], shown_deg: Sequence[float], unseen_deg: Sequence[float]) -> dict:
    """Model the synthetic fire from some views with every system: the table and the picture of Figs. 9 and 10.

    Returns:
        The volumes by system, with the truth.
    """
    from scenes import truth

    true = truth("fire")
    views = views_of(true, inputs_deg)
    rows, volumes = {}, {}
    for method in METHODS:
        made = model(views, method)
        volumes[method] = made["volume"]
        rows[method] = score(made["volume"], true, inputs_deg, unseen_deg) | {"seconds": float(made["seconds"])}
    volumes["truth"] = true
    rows[f"truth, {FLOOR_DEG} degrees aside"] = floor(true, inputs_deg, unseen_deg)
    tell(name, rows)
    save(name, show(volumes, shown_deg, slices=3))
    return volumes
