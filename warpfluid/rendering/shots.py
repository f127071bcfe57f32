"""Which pictures are made of a sequence, and whether they may be written."""

from dataclasses import dataclass

from warpfluid.files.sequences import format_frames, parse_frames
from warpfluid.rendering.output import Target
from warpfluid.volumes import VolumeSequence


@dataclass(frozen=True, kw_only=True)
class Shot:
    """A picture to make.

    Attributes:
        number: In its name, by which options are keyed.
        frame: Volume that it shows.
        turned: Part of a full turn that the camera has gone.
    """

    number: int
    frame: int
    turned: float = 0.0


def make_shots(volumes: VolumeSequence, frames: str | None, turntable: int | None) -> list[Shot]:
    """Return what to make: a picture a frame, or those of a turn while the sequence plays.

    Raises:
        ValueError: If a frame is asked for that is not there.
    """
    chosen = parse_frames(frames) if frames else list(volumes.frames)
    missing = [frame for frame in chosen if frame not in volumes.files]
    if missing:
        raise ValueError(
            f"frames {format_frames(missing)} are not there; {volumes.name} has {format_frames(volumes.frames)}"
        )
    if not turntable:
        return [Shot(number=frame, frame=frame) for frame in chosen]
    return [
        Shot(number=chosen[0] + i, frame=chosen[i % len(chosen)], turned=i / turntable)
        for i in range(max(turntable, len(chosen)) if len(chosen) > 1 else turntable)
    ]


def check_target(target: Target, shots: list[Shot], *, resume: bool, overwrite: bool) -> None:
    """Check that the pictures may be written where they shall be.

    Raises:
        ValueError: If they may not.
    """
    if resume and overwrite:
        raise ValueError("--resume keeps earlier pictures and --overwrite replaces them: choose one of them")
    if resume and target.is_film:
        raise ValueError("a film is written in one piece: --resume is for numbered pictures, such as picture.####.png")
    if not target.is_film and not target.is_numbered and len(shots) > 1:
        example = target.path.with_suffix(f".####{target.path.suffix}")
        raise ValueError(f"{target.path} is one picture, and there are {len(shots)}: use {example}, or choose --frames")
    there = [file for shot in shots for file in target.files(shot.number) if file.exists()]
    if there and not (resume or overwrite):
        raise ValueError(
            f"{there[0]} is there already: use --overwrite, or another -o" + ("" if target.is_film else ", or --resume")
        )
