"""A shot: the footage of one or more views, checked, paired by frame and prepared."""

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from warpfluid.errors import Problems
from warpfluid.files.sequences import parse_frames
from warpfluid.footage import matting
from warpfluid.footage.alignment import Alignment, ViewAlignment, given_numbers
from warpfluid.footage.keeping import Keeping, frames_to_keep, room_for
from warpfluid.footage.pairing import common_frames, start_together
from warpfluid.footage.preparing import check_light, expose, is_integer, prepare
from warpfluid.footage.sources import Source, file_hash, image_size, parse_view
from warpfluid.footage.tone import apply_shoulder, undo_shoulder
from warpfluid.options import InputOptions
from warpfluid.views import Views, angle_problems


@dataclass(frozen=True, kw_only=True)
class Shot:
    """Views over time.

    Attributes:
        sources: The footage of each view.
        frames: Frames to reconstruct, which every view has.
        equalize_rows: Whether ``views`` gives every view the same total in each row.
        notes: Sentences on what was decided for the user.
        options: How pictures became images, with the numbers of the alignment in place of a search.
        shoulder: Tone curve behind which light is scaled, see ``ReconstructOptions``.
        alignments: Of the views that are aligned, and what a search found of them.
    """

    sources: tuple[Source, ...]
    frames: tuple[int, ...]
    equalize_rows: bool = True
    notes: tuple[str, ...] = ()
    options: InputOptions = field(default_factory=InputOptions)
    shoulder: float = 0.0
    alignments: tuple[ViewAlignment, ...] = ()

    @property
    def angles_deg(self) -> tuple[float, ...]:
        """Angle of each view."""
        return tuple(source.angle_deg for source in self.sources)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of an image (u, v) [pixel]."""
        return self.sources[0].matting.size

    @property
    def rate(self) -> float | None:
        """Frames a second, where a view's footage says so."""
        return next((source.footage.rate for source in self.sources if source.footage.rate), None)

    @property
    def white(self) -> float | None:
        """Pixel value that counts as white, if all footage is float; integers have their own."""
        return None if any(map(is_integer, self.sources)) else self.sources[0].matting.white

    @property
    def step(self) -> int:
        """Frames from one picture of the footage to the next: 2 for a sequence on twos."""
        return self.sources[0].step

    def views(self, frame: int, *, equalize_rows: bool | None = None) -> Views:
        """Return the images of a frame; they may be black all over.

        Args:
            frame: One of ``frames``, or another one that every view has.
            equalize_rows: Instead of the shot's own choice.

        Raises:
            ValueError: If the shot has no such frame.
        """
        lacking = [source.name for source in self.sources if frame not in source.frames]
        if lacking:
            raise ValueError(f"{' and '.join(lacking)} has no frame {frame}")
        images = np.stack([source.image(frame) for source in self.sources])
        equal = self.equalize_rows if equalize_rows is None else equalize_rows
        return Views(self._scaled(images, equal=equal and len(images) > 1), self.angles_deg)

    def light_of_rows(self, images: np.ndarray) -> np.ndarray:
        """Return the linear light in each row of images (view, u, v), shape (view, v)."""
        return undo_shoulder(images, self.shoulder).sum(axis=1, dtype=np.float64)

    def forget_pictures(self) -> None:
        """Give the memory of pictures back that were kept by ``open_shot``."""
        for source in self.sources:
            if isinstance(source.footage, Keeping):
                source.footage.forget()

    def _scaled(self, images: np.ndarray, *, equal: bool) -> np.ndarray:
        """Multiply the linear light of images by the gains, and make rows equal where that is asked for."""
        gains = np.array([source.alignment.gain for source in self.sources], np.float32)
        if not equal and (gains == 1).all():
            return images
        light = undo_shoulder(images, self.shoulder) * gains[:, None, None]
        if equal:
            light = matting.equalize_rows(light, float(undo_shoulder(np.float64(matting.LIT), self.shoulder)))
        return apply_shoulder(light, self.shoulder)

    def hashes(self, frame: int) -> dict[str, str]:
        """Return what tells the pictures that a frame is made of from others, by angle of the view.

        It covers name, size, first and last megabyte of their files, to stay quick on long footage.

        Raises:
            OSError: If a file cannot be read.
        """
        return {f"{source.angle_deg:.15g}": file_hash(source.paths(frame)) for source in self.sources}

    def background_hashes(self) -> dict[str, str]:
        """Return what tells the backgrounds that are taken off from others, by angle of the view."""
        plates = {source.angle_deg: source.matting.background for source in self.sources}
        return {
            f"{angle:.15g}": hashlib.sha256(np.ascontiguousarray(plate)).hexdigest()
            for angle, plate in plates.items()
            if plate is not None
        }


def open_shot(
    views: Sequence[str | tuple[float, str]],
    options: InputOptions | None = None,
    shoulder: float = 0.0,
    *,
    keep: bool = False,
) -> Shot:
    """Open the footage of every view and check all of it.

    Image sequences are paired by the numbers of their files; a video starts where the sequences start, and
    at 1 among videos. Then views are aligned as the options say.

    Args:
        views: ``ANGLE=PATH``, or pairs of angle and path.
        options: How pictures become images.
        shoulder: Tone curve behind which light is scaled, see ``ReconstructOptions``.
        keep: Keep pictures in memory, as far as it allows, until the shot is inspected.

    Raises:
        ValueError: If anything is wrong with any view or option, or views that are to be aligned do not agree; one line
            each.
    """
    options = options or InputOptions()
    problems, notes = Problems(), []
    asked = _check_options(options, problems)
    sources = _open_sources(views, problems)
    if not sources:
        problems.raise_if_any()
    sources = _align_by_hand(start_together(sources, notes), options, problems)
    sizes = [problems.attempt(image_size, source, options, notes) for source in sources]
    alone = len({source.angle_deg for source in sources}) == len(sources)  # or one clip was named by mistake
    if alone and None not in sizes and len(set(sizes)) > 1:
        found = ", ".join(f"{s.name} {w} x {h}" for s, (w, h) in zip(sources, sizes, strict=True))
        problems.append(f"the views have unlike sizes ({found}): make them equal with --resolution or --crop")
    found = ()
    if options.align == "auto" and not problems:
        from warpfluid.footage.aligning import align_views

        sources, found, options = align_views(sources, options, sizes[0], asked, shoulder, notes)
    paired = alone and all(source.frames for source in sources)
    frames = common_frames(sources, asked, problems, notes) if paired else ()
    sources = _keeping(sources, frames) if keep else sources
    for source in sources:
        # a damaged picture must not come up in the middle of a long run
        for number in source.numbers(frames):
            problems.attempt(source.footage.read, number)
    problems.raise_if_any()
    sources = [problems.attempt(prepare, source, frames, sizes[0], options) for source in sources]
    problems.raise_if_any()
    if options.white is None:
        sources = expose(sources, frames)
    for source in sources:
        problems.attempt(check_light, source, frames)
    problems.raise_if_any()
    return Shot(
        sources=tuple(sources),
        frames=frames,
        equalize_rows=options.equalize_rows,
        notes=tuple(notes),
        options=options,
        shoulder=shoulder,
        alignments=found or _by_hand(sources),
    )


def _check_options(options: InputOptions, problems: Problems) -> list[int] | None:
    """Return the frames asked for; note what is wrong with any option."""
    asked = problems.attempt(parse_frames, options.frames) if options.frames else None
    if options.crop:
        problems.attempt(matting.parse_crop, options.crop)
    if options.resolution:
        problems.attempt(matting.parse_resolution, options.resolution)
    if options.white is not None and not (math.isfinite(options.white) and options.white > 0):
        problems.append(f"--white {options.white:g} is not a pixel value above 0")
    return asked


def _open_sources(views, problems: Problems) -> list[Source]:
    """Return the sources of the views that can be opened."""
    from warpfluid.files.footage import open_footage

    pairs = [problems.attempt(parse_view, view) for view in views]
    pairs = [pair for pair in pairs if pair]
    if not views:
        problems.append("there is no view: give one or more with --view ANGLE=PATH")
    problems.extend(angle_problems([angle for angle, _ in pairs]))
    footages = [problems.attempt(open_footage, path, where=f"view {angle:g}: ") for angle, path in pairs]
    return [
        Source(angle_deg=angle, footage=footage)
        for (angle, _), footage in zip(pairs, footages, strict=True)
        if footage is not None
    ]


def _keeping(sources: list[Source], frames: Sequence[int]) -> list[Source]:
    """Return sources that keep what will be read again."""
    room, wanted = room_for(len(sources)), frames_to_keep(frames) if frames else ()
    return [replace(s, footage=Keeping(s.footage, s.numbers(wanted), room)) for s in sources]


def _align_by_hand(sources: list[Source], options: InputOptions, problems: Problems) -> list[Source]:
    """Give every view the alignment that the options name."""
    numbers = problems.attempt(given_numbers, options, [source.angle_deg for source in sources])
    if numbers is None:
        return sources
    aligned = [replace(source, alignment=Alignment(**given)) for source, given in zip(sources, numbers, strict=True)]
    for source in aligned:
        if not source.frames:
            problems.append(f"--view-time: {source.name} has no two successive pictures to play between")
    return aligned


def _by_hand(sources: list[Source]) -> tuple[ViewAlignment, ...]:
    """Return the alignments of the views that have one."""
    return tuple(
        ViewAlignment(angle_deg=s.angle_deg, reference_deg=sources[0].angle_deg, alignment=s.alignment)
        for s in sources
        if s.alignment != Alignment()
    )
