"""Whether a run can be continued with the settings that are asked for now."""

from pathlib import Path

from warpfluid.errors import changed_since
from warpfluid.files.sequences import format_frames, parse_frames
from warpfluid.options import THINGS
from warpfluid.settings.configuration import OF_RUNS
from warpfluid.settings.earlier import with_defaults

FREE = ("frames", "turntable", "report", "look")  # what may change when a run is continued


def check_same(folder: Path, old: dict, new: dict) -> None:
    """Check that a run is continued with what it was begun with.

    Args:
        folder: Of the run.
        old: Its ``run.toml``.
        new: What would be written now, with the hashes of volumes or backgrounds under ``made-with``.

    Raises:
        ValueError: If anything differs that the volumes depend on.
    """
    changed = []
    if old.get("views") != new.get("views"):
        views = [" ".join(document.get("views", [])) or "none" for document in (old, new)]
        changed.append(f"views (were {views[0]}, now {views[1]})")
    if old.get("source") != new.get("source") or old.get("size") != new.get("size"):
        changed.append(f"the source (was {old.get('source') or old.get('size')})")
    changed += [f"[[{kind}]]" for kind in THINGS if old.get(kind, []) != new.get(kind, [])]
    for name, kind in OF_RUNS.items():
        # what an earlier version lacked
        before, after = (with_defaults(document[name], kind) if name in document else {} for document in (old, new))
        changed += [
            f"{key.replace('_', '-')} (was {before.get(key)}, now {after.get(key)})"
            for key in sorted({*before, *after} - {*FREE})
            if before.get(key) != after.get(key)
        ]
    before, after = (document.get("made-with", {}).get("inputs", {}) for document in (old, new))
    kind = "the volume of frame {}" if "source" in new else "the background of the view at {} degrees"
    changed += [kind.format(name) for name in after if before.get(name, after[name]) != after[name]]
    if changed:
        raise ValueError(changed_since(folder, changed))


def join_frames(old: dict, new: dict) -> None:
    """Let the frames of ``new`` be those of both documents, as a run may be made in parts, and its pieces the old."""
    section = "input" if "input" in new else "simulate"
    parts = [document[section].get("frames") for document in (old, new)]
    if None in parts:
        new[section].pop("frames", None)
    else:
        new[section]["frames"] = format_frames(frame for part in parts for frame in parse_frames(part))
    first = old.get("made-with", {}).get("first")
    if first is not None:  # from where pieces are counted; pictures may have come or gone since
        new["made-with"]["first"] = first
    noted = [document.get("made-with", {}).get("frames") for document in (old, new)]
    if all(noted):
        new["made-with"]["frames"] = format_frames(frame for part in noted for frame in parse_frames(part))
