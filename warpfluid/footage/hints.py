"""What the user could do about what the check of footage found, in sentences."""

from warpfluid.footage.alignment import count_of
from warpfluid.footage.estimate import affordable_width, format_duration
from warpfluid.footage.matting import LIT
from warpfluid.options import BRIGHT_FLAME, ReconstructOptions

HARDLY = 0.35  # disagreement that only different scenes have, or backgrounds
STREAKS = 0.2  # angles a voxel of width; below this the volumes have streaks
WORTH = 0.1  # share of the disagreement that a remedy must take away to be advised
MOSTLY_LIT = 0.6  # share of the box inside the hull


def find_hints(views, pairs, share: float, options: ReconstructOptions, *, equalize_rows: bool) -> list[str]:
    """Return a sentence for everything that an option or better footage would mend.

    Args:
        views: What ``inspect_shot`` found of each view.
        pairs: How their row sums agree with those of the first.
        share: Share of the box inside the visual hull.
        options: The reconstruction, its choices made.
        equalize_rows: Whether the reconstruction makes the row sums equal, so that unlike exposure does no harm.
    """
    hints = [hint for view in views for hint in _view_hints(view, options)]
    lit = any(_stands_out(view) for view in views)
    hints += [hint for pair in pairs for hint in _pair_hints(pair, equalize_rows, lit=lit)]
    if share > MOSTLY_LIT:
        hints.append(
            f"the visual hull fills {share:.0%} of the box: mostly background is lit; try --black-level or --background"
        )
    width = views[0].size[0]
    if options.angles < STREAKS * width:
        few = f"{options.angles} angles are few for {width} pixels"
        hints.append(f"{few}: streaks appear below {STREAKS * width:.0f}")
    return hints


def cost_hints(size: tuple[int, int], frames: int, share: float, options: ReconstructOptions, views: int) -> list[str]:
    """Return the width that would make a long or large run short, of the arguments of ``affordable_width``."""
    found = affordable_width(size, frames, share, options, views)
    if found is None:
        return []
    width, seconds = found
    return [f"this is a long or large run: --resolution {width} needs about {format_duration(seconds)}"]


def _sides(view) -> list[str]:
    return [edge for edge in view.cut if edge in ("left", "right")]


def _stands_out(view) -> bool:
    """Return whether the background is lit; fluid alone may well stand on the lower edge."""
    return view.floor > LIT and (view.background > LIT or bool(_sides(view)))


def _view_hints(view, options: ReconstructOptions) -> list[str]:
    """Return what would help a view by itself."""
    hints, name, sides = [], f"view {view.angle_deg:g}", _sides(view)
    ends = [edge for edge in view.cut if edge not in sides]
    if _stands_out(view):
        hints.append(
            f"{name}: the empty part goes up to grey {view.floor:.0f}, not black: "
            f"try --black-level {view.clearing_level}, or --background with a picture of the empty set"
        )
    if view.bright > BRIGHT_FLAME:
        advice = f"undone with --shoulder {options.shoulder:g}" if options.shoulder else "try --shoulder 2, up to 3.5"
        hints.append(
            f"{name}: {view.bright:.0%} of the lit pixels lie above 200, as a film's tone curve does: {advice}"
        )
    if sides:
        hints.append(
            f"{name}: light crosses the {' and '.join(sides)} edge: what lies outside is lost; "
            "take a wider picture, or the background off"
        )
    elif ends and view.background <= LIT:
        hints.append(
            f"{name}: light crosses the {' and '.join(ends)} edge: the volume ends there in a flat cut; "
            "take a taller picture, or hide the cut in the scene"
        )
    return hints


def _pair_hints(pair, equalize_rows: bool, *, lit: bool) -> list[str]:
    """Return the remedy in words, where it takes away enough and the reconstruction does not do it anyway.

    How much it would leave is told only if the background is off: without it other light is compared.
    """
    remedy, name = pair.remedy, f"view {pair.angle_deg:g}"
    gained = remedy.disagreement - remedy.disagreement_after
    if remedy.disagreement_after > HARDLY:
        return [
            f"{name}: its rows disagree with view {pair.reference_deg:g} by {remedy.disagreement:.0%}, "
            "and no shift mends it: see whether both show one moment, cropped alike, the background off"
        ]
    if gained < WORTH * remedy.disagreement or remedy.disagreement < 0.02:
        return []
    steps = []
    if remedy.time_offset:
        when = "later" if remedy.time_offset > 0 else "earlier"
        steps.append(f"play it {count_of(remedy.time_offset, 'frame')} {when}")
    if remedy.vertical_shift:
        where = "up" if remedy.vertical_shift > 0 else "down"
        steps.append(f"move it {where} by {count_of(remedy.vertical_shift, 'pixel')}")
    if abs(remedy.exposure_scale - 1) > 0.02 and (steps or not equalize_rows):
        steps.append(f"multiply its light by {remedy.exposure_scale:.2f}")
    if not steps:
        return []
    left = "" if lit else f", and {remedy.disagreement_after:.0%} is left"
    way_out = "take the background off, then look again with --align auto" if lit else "--align auto does it"
    return [
        f"{name}: its rows disagree with view {pair.reference_deg:g} by {remedy.disagreement:.0%}: "
        f"{', '.join(steps)}{left}; {way_out}"
    ]
