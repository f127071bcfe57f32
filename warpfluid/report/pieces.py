"""Pictures and numbers that the pages of all runs have in common."""

import dataclasses
import time
from collections.abc import Mapping, Sequence

import numpy as np

from warpfluid.comparison.measure import Numbers, against_footage, as_given, halfway, mean_numbers, upright
from warpfluid.files.sequences import format_frames
from warpfluid.kernels.launch import thread_count
from warpfluid.rendering.ramps import apply_ramp
from warpfluid.rendering.turntable import render_turntable, slices_picture
from warpfluid.report.data import InputReport
from warpfluid.report.film import RATE, TURN_PICTURES, film_pictures
from warpfluid.run import Run, versions

AGAINST = (
    "Unseen views, half-way between those of the footage, against the footage, as distributions. "
    "Views of one fluid differ, too: the floors are views of the footage against each other."
)
STILLS_DEG = tuple(range(0, 91, 15))
SLICES = 6
NUMBERED_FRAMES = 3  # of those shown have numbers, which take longer than all pictures
MOTION_PAIRS = 3  # of frames whose motion is measured
FILM_IN_PAGE = 60  # pictures of the film that the page carries
FILM_ROWS = 400  # more are thinned, so that the page stays light
FILM_RATE = RATE * FILM_IN_PAGE / TURN_PICTURES


def stills(volumes: Mapping[str, np.ndarray], look: str) -> dict[str, np.ndarray]:
    """Return pictures of each volume from the front to the left, by name."""
    return {name: render_turntable(volume, STILLS_DEG, look) for name, volume in volumes.items()}


def slices(volumes: Mapping[str, np.ndarray], white: float) -> dict[str, np.ndarray]:
    """Return horizontal slices of each volume, in one picture by name."""
    found = {}
    for name, volume in volumes.items():
        heights = np.linspace(0.1, 0.9, SLICES) * (volume.shape[2] - 1)
        found[name] = slices_picture(volume, heights.astype(int), white=white)
    return found


def peak(volume: np.ndarray) -> float:
    """Return nearly the greatest density, for colours that a few voxels do not decide."""
    return float(np.quantile(volume[volume > 0], 0.999)) if (volume > 0).any() else 1.0


def turning(run: Run, look: str, scale: float = 1.0) -> np.ndarray:
    """Return the film of the page, shape (picture, rows, columns, 3)."""
    film = np.stack(list(film_pictures(run, look, FILM_IN_PAGE, scale)))
    step = max(1, film.shape[1] // FILM_ROWS)
    return film[:, ::step, ::step]


def common(run: Run, records: Mapping[int, dict], look: str, begin: float, scale: float = 1.0) -> dict[str, object]:
    """Return what the pages of all runs have: title, film, versions and timings, by the names of ``ReportData``.

    Args:
        run: The run.
        records: Its frames.
        look: Name of a colour ramp.
        begin: When the page was begun, by ``time.perf_counter``.
        scale: What brings densities to grey levels.
    """
    film = turning(run, look, scale)
    seconds = sum(record["seconds"] for record in records.values())
    return {
        "title": run.folder.resolve().name,
        "turntable": film,
        "rate": FILM_RATE,
        "versions": made_with(run),
        "timings": {"frames": seconds, "this page": time.perf_counter() - begin},
    }


def view_reports(names: Sequence[str], angles_deg: Sequence[float], images: np.ndarray) -> list[InputReport]:
    """Return views, shape (view, u, v), as grey pictures with their names."""
    pictures = apply_ramp(images.transpose(0, 2, 1)[:, ::-1], "gray")
    rows = zip(names, angles_deg, pictures, strict=True)
    return [InputReport(name=name, angle_deg=angle, picture=picture) for name, angle, picture in rows]


def sorted_floors(numbers: Mapping[str, Numbers], methods: Sequence[str]) -> tuple[dict[str, Numbers], list[str]]:
    """Return numbers with the methods before the floors, and the floors' names."""
    floors = [name for name in numbers if name not in methods]
    return {name: numbers[name] for name in [*methods, *floors] if name in numbers}, floors


def footage_numbers(
    volumes: Mapping[str, np.ndarray],
    images: np.ndarray,
    angles_deg: Sequence[float],
    *,
    far: np.ndarray | None,
    shoulder: float,
    device,
) -> dict[str, Numbers]:
    """Return the numbers of volumes against their footage, there being no truth, and those of its floors after them.

    Args:
        volumes: By name, shape (x, z, y).
        images: The footage, shape (view, u, v).
        angles_deg: Its angles.
        far: The footage at another moment; None for none.
        shoulder: Its tone curve.
        device: Where to compute.
    """
    facts = {"shoulder": shoulder, "device": device}
    found = against_footage(volumes, images, angles_deg, halfway(angles_deg), other_frame=far, **facts)
    for name in volumes if found else ():
        found[name] |= as_given(volumes[name], upright(images), angles_deg, **facts)
    return sorted_floors(mean_numbers([found]), list(volumes))[0]


def options_of(*parts) -> dict[str, object]:
    """Return all options in one table, named as the flags are; None is a choice left to the footage."""
    merged = {key: value for part in parts for key, value in dataclasses.asdict(part).items()}
    return {key.replace("_", "-"): "auto" if value is None else value for key, value in merged.items()}


def made_with(run: Run) -> dict[str, object]:
    """Return the versions of what takes part, and the machine."""
    device = run.settings().get("made-with", {}).get("device", "")
    return {**versions(), "CPU threads": thread_count(), "device": device}


def headline(frames: Sequence[int], wanted: str, shown: Sequence[int], shape: tuple[int, int, int]) -> str:
    """Return what a page is of.

    Args:
        frames: Finished frames.
        wanted: All frames, in words if some are lacking.
        shown: Those on the page.
        shape: Voxels of a volume (x, z, y).
    """
    below = f"\nShown: {', '.join(map(str, shown))}" if len(shown) < len(frames) else ""
    words = wanted or format_frames(frames)
    return f"Frames {words}; {shape[0]} x {shape[2]} x {shape[1]} voxels (width, height, depth){below}"
