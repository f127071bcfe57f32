"""Free checks of footage before a long run.

What a picture shows by itself, how the views agree, and what the reconstruction will cost, with a hint where
an option would help.
"""

from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from warpfluid.files.sequences import format_frames
from warpfluid.footage.alignment import ViewAlignment, flags
from warpfluid.footage.estimate import estimate_carried, estimate_cost, estimate_run, format_duration, hull_share
from warpfluid.footage.hints import cost_hints, find_hints
from warpfluid.footage.keeping import LOOKED_AT_FRAMES, inspected
from warpfluid.footage.matting import LIT
from warpfluid.footage.row_sums import Remedy, compare_row_sums
from warpfluid.footage.shot import Shot
from warpfluid.footage.sources import Source, spread
from warpfluid.options import ReconstructOptions
from warpfluid.views import Views

BORDER = 0.03  # of the width and height; there is rarely fluid
NEARLY_ALL = 99.5  # per cent of its pixels
TAIL = 4  # standard deviations that noise reaches at most
UNEVEN = 12  # grey levels between the darkest and the brightest empty edge
LOUD = 60  # grey levels that no noise reaches above the background


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
    floor: float  # grey level that nearly all of the empty border keeps below
    clearing_level: int  # black level that leaves nothing of it
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
    alignments: tuple[ViewAlignment, ...]
    hints: tuple[str, ...]

    def to_dict(self) -> dict:
        """Return everything as plain numbers, strings, lists and dictionaries."""
        return _plain(asdict(self))

    def lines(self) -> list[str]:
        """Return a summary in plain text."""
        x, y, z = self.volume_size
        return [
            *(line for view in self.views for line in _view_lines(view)),
            *(f"align   {view.line()}" for view in self.alignments),
            *([f"        by hand: {flags(found)}"] if (found := self._found()) else []),
            *(_pair_line(pair, aligned=bool(self.alignments)) for pair in self.pairs),
            f"volume  {x} x {y} x {z} voxels, {self.hull_share:.0%} of them inside the visual hull",
            f"frames  {self.frame_count} ({self.frames})",
            f"needs   {self._needs()}",
            *(f"note    {note}" for note in self.notes),
            *(f"hint    {hint}" for hint in self.hints),
        ]

    def _found(self) -> list[ViewAlignment]:
        """Return the alignments that were searched for."""
        return [view for view in self.alignments if view.disagreement is not None]

    def _needs(self) -> str:
        frames = f"{self.frame_count} frame{'s' * (self.frame_count > 1)}"
        costs = self.seconds_a_frame, self.seconds_a_carried_frame
        whole = format_duration(estimate_run(self.frame_count, *costs, self.options))
        a_frame = f"{format_duration(self.seconds_a_frame)} a frame"
        if self.frame_count > 1 and self.options.coherence == "flow":
            carried = format_duration(self.seconds_a_carried_frame)
            of_each = " of each piece" * (self.options.piece is not None)
            a_frame = f"{format_duration(self.seconds_a_frame)} the first frame{of_each}, {carried} each of the others"
        memory = max(self.memory_bytes / 1e9, 0.01)
        return f"{frames}, about {whole} on two CPU cores ({a_frame}) and {memory:.2g} GB of memory"


def inspect_shot(shot: Shot, options: ReconstructOptions | None = None) -> Inspection:
    """Check the views of a shot, each by itself and against the first.

    Args:
        shot: Footage of one or more views.
        options: The reconstruction to estimate time and memory for.
    """
    asked = options or ReconstructOptions()
    sums, images, frames = _read(shot)
    views = tuple(_inspect_view(source, frames, images[:, i]) for i, source in enumerate(shot.sources))
    reference_deg = shot.angles_deg[0]
    pairs = tuple(
        PairInspection(angle_deg=b, reference_deg=reference_deg, remedy=compare_row_sums(sums[0], sums[i]))
        for i, b in enumerate(shot.angles_deg)
        if i
    )
    shot.forget_pictures()
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
        alignments=shot.alignments,
        hints=(
            *find_hints(views, pairs, share, options, equalize_rows=shot.equalize_rows),
            *cost_hints(shot.size, len(shot.frames), share, asked, len(views)),
        ),
    )


def write_views_picture(path: str | Path, views: Views) -> None:
    """Write a picture of the views standing around the box, to see that their angles are right.

    Args:
        path: A PNG file.
        views: One frame.
    """
    from warpfluid.files.images import OF_VIEWS, write_png
    from warpfluid.footage.views_picture import draw_views

    write_png(path, draw_views(views), title=OF_VIEWS)


def _read(shot: Shot) -> tuple[np.ndarray, np.ndarray, list[int]]:
    """Return row sums of a run of frames (view, frame, v), images of a few (frame, view, u, v), and which."""
    frames = inspected(shot.frames)
    looked_at = spread(frames, LOOKED_AT_FRAMES)
    sums, images = [], []
    for frame in frames:
        views = shot.views(frame, equalize_rows=False).images
        sums.append(shot.light_of_rows(views))
        if frame in looked_at:
            images.append(views)
    return np.stack(sums, axis=1), np.stack(images), looked_at


def _floor(source: Source, frames: list[int], background: float) -> float:
    """Return the grey level that the noise of the empty border keeps below.

    Pictures are looked at before they are reduced: the black level comes off there, and reducing hides noise.
    """
    size = tuple(source.matting.crop[:2] if source.matting.crop else source.footage.size)
    full = source.with_matting(size=size, shift=0.0, scale=1.0)
    borders = zip(*(_border(full.image(frame)) for frame in frames), strict=True)
    floors = [_noise_floor(np.stack(edge)) for edge in borders]
    if min(floors) > background + LOUD:  # the fluid crosses every edge
        return background
    return max(floor for floor in floors if floor <= min(floors) + UNEVEN)  # it crosses the others


def _noise_floor(pixels: np.ndarray) -> float:
    """Return what nearly all pixels keep below, and no more than noise does: a few may hold fluid."""
    middle, upper, top = np.percentile(pixels, [50, 84, NEARLY_ALL])
    return float(min(top, middle + TAIL * (upper - middle)))


def _border(image: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the strips along the four edges of an image, shape (u, v)."""
    wide, tall = (max(2, round(BORDER * length)) for length in image.shape)
    return image[:wide], image[-wide:], image[:, :tall], image[:, -tall:]


def _inspect_view(source: Source, frames: list[int], images: np.ndarray) -> ViewInspection:
    """Return what one view's images show, shape (frame, u, v)."""
    lit = images > LIT
    background = float(np.percentile(images, 20))
    floor, taken_off = _floor(source, frames, background / source.alignment.gain), source.matting.black_level
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
        background=background,
        floor=floor,
        clearing_level=min(254, int(np.ceil(taken_off + floor * (255 - taken_off) / 255))),
        cut=tuple(edge for edge, pixels in edges.items() if pixels.mean() > 0.02),
    )


def _view_lines(view: ViewInspection) -> list[str]:
    (width, height), (u, v) = view.footage_size, view.size
    return [
        f"view {view.angle_deg:g}  {view.source}",
        f"        {view.kind}, {width} x {height}, {view.depth}, used at {u} x {v}; frames {view.frames}",
        f"        grey {view.darkest:.0f} to {view.brightest:.0f}, background {view.background:.0f}, "
        f"{view.saturated:.1%} saturated, {view.bright:.0%} of the lit pixels above 200",
    ]


def _pair_line(pair: PairInspection, *, aligned: bool) -> str:
    """Return how row sums agree, and the remedy with the sign of ``--view-time`` and ``--view-shift``."""
    remedy, now = pair.remedy, " now" * aligned
    return (
        f"rows    view {pair.angle_deg:g} against view {pair.reference_deg:g}: {remedy.disagreement:.1%} "
        f"apart{now}; {remedy.time_offset:+d} frames, {remedy.vertical_shift:+d} pixels, "
        f"x {remedy.exposure_scale:.3f} would leave {remedy.disagreement_after:.1%}"
    )


def _plain(value):
    """Return tuples as lists, all the way down, as JSON gives them back."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value
