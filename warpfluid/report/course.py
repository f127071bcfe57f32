"""How a simulation went, frame by frame, and what is good to know of it."""

from collections.abc import Mapping, Sequence

from warpfluid.options import SimulateOptions
from warpfluid.report.data import SeriesReport
from warpfluid.report.fields import speed_of
from warpfluid.settings import SimulateSettings
from warpfluid.simulation.animation import fidelity_at, is_edited
from warpfluid.simulation.source import Source
from warpfluid.volumes import VolumeSequence

OURS, SOURCE = "simulated", "source"
FIDELITIES = (1.0, 0.3, 0.05, 0.0)  # from the footage alone to the edit alone, in steps that are seen
MANY = 0.2  # share of the frames that is worth a warning


def course(records: Mapping[int, dict], source: Source) -> list[SeriesReport]:
    """Return the numbers over the frames."""
    total = {OURS: {frame: record["total"] / 1e3 for frame, record in records.items()}}
    followed = {f: r["total"] / r["total_over_source"] / 1e3 for f, r in records.items() if r.get("total_over_source")}
    total |= {SOURCE: followed} if followed else {}
    views = [f"{angle:g}°" for angle in source.volumes.angles_deg[:3]] if source.frames else []
    exact = {
        view: {frame: r["input_psnr"][i] for frame, r in records.items() if r["steps"] and r.get("input_psnr")}
        for i, view in enumerate(views)
    }
    return [
        SeriesReport(title="Total density", values=total, unit=" thousand"),
        SeriesReport(title="How exactly the views of the source come back", values=exact, unit=" dB"),
        SeriesReport(title="Solver steps a frame", values={"": {f: r["steps"] for f, r in records.items()}}),
        SeriesReport(title="Time a frame took", values={"": {f: r["seconds"] for f, r in records.items()}}, unit=" s"),
    ]


def speeds(volumes: VolumeSequence, shown: Sequence[int], fps: float) -> list[SeriesReport]:
    """Return how fast the fluid is in the frames shown."""
    found = {frame: speed_of(volumes, frame, fps) for frame in shown}
    found = {frame: speed for frame, speed in found.items() if speed}
    curves = {name: {f: speed[i] for f, speed in found.items()} for i, name in enumerate(("mean", "fastest 1 %"))}
    return [SeriesReport(title="Speed of the fluid", values=curves, unit=" voxel/frame")] if found else []


def check(records: Mapping[int, dict], source: Source) -> list[str]:
    """Return what is good to know, in sentences."""
    if not source.frames:
        return ["It starts from an empty box and follows nothing."]
    name = source.volumes.name
    lines = [f"It follows {name}." if len(source.frames) > 1 else f"It starts from {name}."]
    ratios = [record["total_over_source"] for record in records.values() if record.get("total_over_source")]
    exact = [min(r["input_psnr"]) for r in records.values() if r["steps"] and r.get("input_psnr")]
    if ratios:
        lines.append(f"Its density totals {min(ratios):.1%} to {max(ratios):.1%} of the source's.")
    if exact:
        lines.append(f"The views of the source come back with at least {min(exact):.1f} dB.")
    return lines


def departure(records: Mapping[int, dict], settings: SimulateSettings) -> list[str]:
    """Return how far an edit has gone from the volumes that are followed; nothing where nothing is edited."""
    followed = {frame: record["elsewhere"] for frame, record in records.items() if "elsewhere" in record}
    if len(followed) < 2 or not is_edited(settings.simulate, settings.scene):
        return []
    last = max(followed)
    fidelity = fidelity_at(settings.simulate, settings.scene, last)
    return [
        f"At frame {last}, {followed[last]:.0%} of the light is elsewhere than in the source; "
        f"fidelity is {fidelity:g}{_ways(fidelity)}."
    ]


def _ways(fidelity: float) -> str:
    """Return what to type for more or less of an edit."""
    less = next((lower for lower in FIDELITIES if lower < fidelity), None)
    more = next((higher for higher in reversed(FIDELITIES) if higher > fidelity), None)
    ways = [f"for more of the edit: --fidelity {less:g}"] if less is not None else []
    ways += [f"for more of the footage: --fidelity {more:g}"] if more is not None else []
    return "; " + "; ".join(ways)


def warnings(records: Mapping[int, dict], options: SimulateOptions) -> list[str]:
    """Return what the reader should not miss."""
    most = options.substeps or options.max_substeps
    full = [record for record in records.values() if record["steps"] >= most]
    if options.substeps is None and len(full) > MANY * len(records):
        return [
            f"{len(full)} of {len(records)} frames needed all {most} solver steps that were allowed: "
            "the fluid is faster than they resolve; raise --max-substeps"
        ]
    return []
