"""Free checks of footage before a long run.

What a picture shows by itself, how the views agree, and what the reconstruction will cost, with a hint where
an option would help.
"""

from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from warpfluid.estimate import estimate_carried, estimate_cost, estimate_run, format_duration, hull_share
from warpfluid.files.sequences import format_frames
from warpfluid.matting import LIT
from warpfluid.options import BRIGHT_FLAME, ReconstructOptions
from warpfluid.row_sums import Remedy, compare_row_sums
from warpfluid.shot import Shot
from warpfluid.sources import Source, spread
from warpfluid.views import Views

INSPECTED_FRAMES = 64  # row sums are compared over these, from the middle of the shot
LOOKED_AT_FRAMES = 8  # of these, for all that needs the pictures
HARDLY = 0.35  # disagreement that only different scenes have, or backgrounds
STREAKS = 0.2  # angles a voxel of width; below this the volumes have streaks
WORTH = 0.1  # share of the disagreement that a remedy must take away to be advised


@dataclass(frozen=True, kw_only=True)
class ViewInspection:
    """What is known of one view; grey levels 0-255, shares 0-1."""

    angle_deg: float
    source: str
    kind: str
    footage_size: tuple[int, int]
    size: tuple[int, int]
    depth: str
    frames: str
    darkest: float
    brightest: float
    saturated: float  # share of all pixels
    bright: float  # share of the lit pixels above 200
    background: float  # grey level of the empty part
    background_noise: float
    cut: tuple[str, ...]  # edges that the fluid crosses


@dataclass(frozen=True, kw_only=True)
class PairInspection:
    """How the row sums of a view agree with those of the first one, and what would mend it."""

    angle_deg: float
    reference_deg: float
    remedy: Remedy


@dataclass(frozen=True, kw_only=True)
class Inspection:
    """What ``inspect_shot`` found."""

    views: tuple[ViewInspection, ...]
    pairs: tuple[PairInspection, ...]
    frames: str
    frame_count: int
    volume_size: tuple[int, int, int]  # x, y, z [voxel]
    hull_share: float
    seconds_a_frame: float  # one that starts anew
    seconds_a_carried_frame: float  # one that starts from the frame before
    memory_bytes: int
    options: ReconstructOptions  # with the choices made that depend on the footage
    notes: tuple[str, ...]
    hints: tuple[str, ...]

    def to_dict(self) -> dict:
        """Return everything as plain numbers, strings, lists and dictionaries."""
        return _plain(asdict(self))

    def lines(self) -> list[str]:
        """Return a summary in plain text."""
        x, y, z = self.volume_size
        return [
            *(line for view in self.views for line in _view_lines(view)),
            *(_pair_line(pair) for pair in self.pairs),
            f"volume  {x} x {y} x {z} voxels, {self.hull_share:.0%} of them inside the visual hull",
            f"frames  {self.frame_count} ({self.frames})",
            f"needs   {self._needs()}",
            *(f"note    {note}" for note in self.notes),
            *(f"hint    {hint}" for hint in self.hints),
        ]

    def _needs(self) -> str:
        frames = f"{self.frame_count} frame{'s' * (self.frame_count > 1)}"
        whole = format_duration(estimate_run(self.frame_count, self.seconds_a_frame, self.seconds_a_carried_frame))
        a_frame = f"{format_duration(self.seconds_a_frame)} a frame"
        if self.frame_count > 1 and self.options.coherence == "flow":
            carried = format_duration(self.seconds_a_carried_frame)
            a_frame = f"{format_duration(self.seconds_a_frame)} the first frame, {carried} each of the others"
        memory = max(self.memory_bytes / 1e9, 0.01)
        return f"{frames}, about {whole} on two CPU cores ({a_frame}) and {memory:.2g} GB of memory"


def inspect_shot(shot: Shot, options: ReconstructOptions | None = None) -> Inspection:
    """Check the views of a shot, each by itself and against the first.

    Args:
        shot: Footage of one or more views.
        options: The reconstruction to estimate time and memory for.
    """
    asked = options or ReconstructOptions()
    sums, images = _read(shot)
    views = tuple(_inspect_view(source, images[:, i]) for i, source in enumerate(shot.sources))
    reference_deg = shot.angles_deg[0]
    pairs = tuple(
        PairInspection(angle_deg=b, reference_deg=reference_deg, remedy=compare_row_sums(sums[0], sums[i]))
        for i, b in enumerate(shot.angles_deg)
        if i
    )
    options = asked.settled(views=len(views), width=shot.size[0], bright=views[0].bright)
    share = float(np.mean([hull_share(image, shot.angles_deg, options) for image in images]))
    seconds, memory = estimate_cost(shot.size, share, options)
    return Inspection(
        views=views,
        pairs=pairs,
        frames=format_frames(shot.frames),
        frame_count=len(shot.frames),
        volume_size=(shot.size[0], shot.size[1], shot.size[0]),
        hull_share=share,
        seconds_a_frame=seconds,
        seconds_a_carried_frame=estimate_carried(shot.size, share, options, len(views)),
        memory_bytes=memory,
        options=options,
        notes=shot.notes,
        hints=tuple(_hints(views, pairs, share, options, shot.equalize_rows)),
    )


def write_views_picture(path: str | Path, views: Views) -> None:
    """Write a picture of the views standing around the box, to see that their angles are right.

    Args:
        path: A PNG file.
        views: One frame.
    """
    from warpfluid.files.images import write_png
    from warpfluid.views_picture import draw_views

    write_png(path, draw_views(views))


def _read(shot: Shot) -> tuple[np.ndarray, np.ndarray]:
    """Return row sums of a run of frames (view, frame, v) and images of a few of them (frame, view, u, v)."""
    start = max(0, (len(shot.frames) - INSPECTED_FRAMES) // 2)
    frames = shot.frames[start : start + INSPECTED_FRAMES]
    looked_at = spread(frames, LOOKED_AT_FRAMES)
    sums, images = [], []
    for frame in frames:
        views = shot.views(frame, equalize_rows=False)
        sums.append(views.row_sums())
        if frame in looked_at:
            images.append(views.images)
    return np.stack(sums, axis=1), np.stack(images)


def _inspect_view(source: Source, images: np.ndarray) -> ViewInspection:
    """Return what one view's images show, shape (frame, u, v)."""
    lit = images > LIT
    low, level = np.percentile(images, [2, 20])
    edges = {"left": lit[:, 0], "right": lit[:, -1], "bottom": lit[:, :, 0], "top": lit[:, :, -1]}
    return ViewInspection(
        angle_deg=source.angle_deg,
        source=str(source.footage.source),
        kind=source.footage.kind,
        footage_size=tuple(source.footage.size),
        size=source.matting.size,
        depth=source.footage.depth,
        frames=format_frames(source.frames),
        darkest=float(images.min()),
        brightest=float(images.max()),
        saturated=float((images >= 254.5).mean()),
        bright=float((images > 200).sum() / max(lit.sum(), 1)),
        background=float(level),
        background_noise=float(level - low),
        cut=tuple(edge for edge, pixels in edges.items() if pixels.mean() > 0.02),
    )


def _hints(views, pairs, share: float, options: ReconstructOptions, equalize_rows: bool) -> list[str]:
    """Return what the user could do about what was found."""
    hints = []
    for view in views:
        name = f"view {view.angle_deg:g}"
        if view.background > LIT:
            level = min(254, int(np.ceil(view.background + 3 * view.background_noise)))
            hints.append(
                f"{name}: the empty part is at grey {view.background:.0f}, not black: "
                f"try --black-level {level}, or --background with a picture of the empty set"
            )
        if view.bright > BRIGHT_FLAME:
            advice = (
                f"undone with --shoulder {options.shoulder:g}" if options.shoulder else "try --shoulder 2, up to 3.5"
            )
            hints.append(
                f"{name}: {view.bright:.0%} of the lit pixels lie above 200, as a film's tone curve does: {advice}"
            )
        sides = [edge for edge in view.cut if edge in ("left", "right")]
        if sides:
            hints.append(
                f"{name}: light crosses the {' and '.join(sides)} edge: what lies outside is lost; "
                "take a wider picture, or the background off"
            )
    for pair in pairs:
        hints += _pair_hints(pair, equalize_rows)
    if share > 0.6:
        hints.append(
            f"the visual hull fills {share:.0%} of the box: mostly background is lit; try --black-level or --background"
        )
    few = STREAKS * views[0].size[0]
    if options.angles < few:
        hints.append(f"{options.angles} angles are few for {views[0].size[0]} pixels: streaks appear below {few:.0f}")
    return hints


def _pair_hints(pair: PairInspection, equalize_rows: bool) -> list[str]:
    """Return the remedy in words, where it takes away enough and the reconstruction does not do it anyway."""
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
        when = "earlier" if remedy.time_offset > 0 else "later"
        steps.append(f"play it {abs(remedy.time_offset)} frames {when}")
    if remedy.vertical_shift:
        where = "up" if remedy.vertical_shift > 0 else "down"
        steps.append(f"move it {where} by {abs(remedy.vertical_shift)} pixels")
    if abs(remedy.exposure_scale - 1) > 0.02 and (steps or not equalize_rows):
        steps.append(f"multiply its light by {remedy.exposure_scale:.2f}")
    if not steps:
        return []
    return [
        f"{name}: its rows disagree with view {pair.reference_deg:g} by {remedy.disagreement:.0%}: "
        f"{', '.join(steps)}, and {remedy.disagreement_after:.0%} are left"
    ]


def _view_lines(view: ViewInspection) -> list[str]:
    (width, height), (u, v) = view.footage_size, view.size
    return [
        f"view {view.angle_deg:g}  {view.source}",
        f"        {view.kind}, {width} x {height}, {view.depth}, used at {u} x {v}; frames {view.frames}",
        f"        grey {view.darkest:.0f} to {view.brightest:.0f}, background {view.background:.0f}, "
        f"{view.saturated:.1%} saturated, {view.bright:.0%} of the lit pixels above 200",
    ]


def _pair_line(pair: PairInspection) -> str:
    remedy = pair.remedy
    return (
        f"rows    view {pair.angle_deg:g} against view {pair.reference_deg:g}: {remedy.disagreement:.1%} "
        f"apart; {remedy.time_offset:+d} frames, {remedy.vertical_shift:+d} pixels, "
        f"x {remedy.exposure_scale:.3f} would leave {remedy.disagreement_after:.1%}"
    )


def _plain(value):
    """Return tuples as lists, all the way down, as JSON gives them back."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value
