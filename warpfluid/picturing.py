"""What ``warpfluid render`` does, once its flags are read."""

import json
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from warpfluid.errors import Problems, describe
from warpfluid.options import CameraOptions, LightOptions, RenderOptions
from warpfluid.outcome import name_failures
from warpfluid.progress import Progress
from warpfluid.rendering.framing import cameras, decided, picture_size
from warpfluid.rendering.lamps import Lamps
from warpfluid.rendering.output import Target
from warpfluid.rendering.picture import Picture
from warpfluid.rendering.shots import Shot, check_target, make_shots
from warpfluid.rendering.studio import Studio, make_studio, stand_ins
from warpfluid.run import Run
from warpfluid.simulation.outlines import Outlines
from warpfluid.volumes import VolumeSequence, open_volumes

RATE, WHITE = 24.0, 255.0
TRY_AGAIN = "the other pictures are whole; with numbered pictures, the same command with --resume makes what is missing"


@dataclass(frozen=True, kw_only=True)
class Work:
    """Everything that takes part.

    Attributes:
        volumes: What is shown.
        camera: Where from.
        studio: Takes the pictures.
        target: Where they go.
        log: Progress.
        outlines: What stands in the run, if that is drawn.
        failed: What went wrong, by picture.
        made: What was written, a record each.
    """

    volumes: VolumeSequence
    camera: CameraOptions
    studio: Studio
    target: Target
    log: Progress
    outlines: Outlines | None = None
    failed: dict[str, str] = field(default_factory=dict)
    made: list[dict] = field(default_factory=list)

    @property
    def voxel_size(self) -> float:
        """Edge of a voxel in units of the scene."""
        lattice = self.volumes.lattice
        return lattice.voxel_size if lattice else self.volumes.output.voxel_size

    def eyes(self, shot: Shot, fields: dict) -> list[Picture]:
        """Return the picture of a shot, or those of both eyes."""
        lit = self.studio.light(fields, shot.number)
        shape = fields["density"].shape
        size = picture_size(shape, self.studio.options.size())
        solids = self.outlines.at(shot.frame, shape) if self.outlines else ()
        eyes = cameras(self.camera, shape, size, shot.number, shot.turned)
        return [self.studio.shoot(lit, camera, shot.number, solids) for camera in eyes]


def render(
    source: str,
    camera: CameraOptions,
    light: LightOptions,
    options: RenderOptions,
    out: Path,
    *,
    resume: bool = False,
    overwrite: bool = False,
    common,
) -> int:
    """Make pictures or a film of volumes; return the exit code."""
    from warpfluid.device import pick_device

    log, problems = Progress(quiet=common.quiet), Problems()
    facts = {"separate": camera.stereo == "separate", "half": options.half, "deep": options.deep}
    target = problems.attempt(lambda: Target(path=out, **facts))
    volumes = problems.attempt(_open, source, options)
    device = problems.attempt(pick_device, common.device)
    lamps = Lamps(light)
    problems.attempt(lambda: lamps.probe)
    problems.raise_if_any()
    rate = (volumes.document or {}).get("simulate", {}).get("fps", RATE)
    studio = make_studio(options, lamps, volumes.output.look, device, rate=rate)
    shots = make_shots(volumes, options.frames, camera.turntable)
    check_target(target, shots, resume=resume, overwrite=overwrite)
    stands = Outlines(Run(Path(source).expanduser())) if light.bodies and volumes.document else None
    facts = {"volumes": volumes, "camera": decided(camera, options), "outlines": stands}
    work = Work(studio=studio, target=target, log=log, **facts)
    _say(work, shots)
    left = [shot for shot in shots if not (resume and all(file.exists() for file in target.files(shot.number)))]
    if len(left) < len(shots):
        log.line(f"kept    {len(shots) - len(left)} pictures that are there")
    (_film if target.is_film else _stills)(work, left)
    return _conclude(work, len(shots), common)


def _open(source: str, options: RenderOptions) -> VolumeSequence:
    """Find the volumes; in those of another program the brightest ray of first, middle and last is white."""
    volumes = open_volumes(source, grid=options.grid, up=options.source_up)
    if volumes.document:
        return volumes
    frames = volumes.frames
    some = {frames[0], frames[len(frames) // 2], frames[-1]}
    brightest = max(_brightest(volumes, frame) for frame in some)
    return replace(volumes, scale=volumes.scale * WHITE / brightest) if brightest > 0 else volumes


def _brightest(volumes: VolumeSequence, frame: int) -> float:
    """Return the brightest ray of a frame seen from the front; 0 of one that cannot be read, which is told later."""
    try:
        return float(volumes.density(frame).sum(axis=1).max())
    except (ValueError, OSError):
        return 0.0


def _pictures(work: Work, shots: list[Shot]) -> Iterator[tuple[Shot, list[Picture], float]]:
    """Yield the pictures of shots, with the seconds that each took; what fails is noted and left out."""
    frame, fields = None, {}
    for count, shot in enumerate(shots):
        begin = time.perf_counter()
        try:
            if shot.frame != frame:
                frame, fields = None, {}
                fields = work.volumes.fields(shot.frame, work.studio.names)
                frame = shot.frame
            eyes = work.eyes(shot, fields)
        except KeyboardInterrupt as stop:
            raise KeyboardInterrupt(f"stopped after {count} of {len(shots)} pictures") from stop
        except (ValueError, OSError, MemoryError) as error:
            work.failed[f"picture {shot.number}"] = describe(error)
            continue
        yield shot, eyes, begin


def _stills(work: Work, shots: list[Shot]) -> None:
    """Write a file a picture."""
    for shot, eyes, begin in _pictures(work, shots):
        try:
            files = work.target.write(shot.number, eyes, work.studio.screen, work.voxel_size)
        except (ValueError, OSError) as error:
            work.failed[f"picture {shot.number}"] = describe(error)
            continue
        _note(work, shot, begin, ", ".join(file.name for file in files))


def _film(work: Work, shots: list[Shot]) -> None:
    """Write all pictures into one file."""

    def frames() -> Iterator[tuple[float, list[Picture]]]:
        for shot, eyes, begin in _pictures(work, shots):
            _note(work, shot, begin, work.target.path.name)
            yield shot.number, eyes
        if not work.made:
            raise ValueError("none of its pictures could be made")

    rate = work.studio.options.fps or work.studio.rate
    try:
        work.target.film(frames(), work.studio.screen, rate)
    except (ValueError, OSError) as error:
        work.failed[str(work.target.path)] = describe(error)
        work.made.clear()


def _note(work: Work, shot: Shot, begin: float, name: str) -> None:
    """Record a picture and say that it is made."""
    seconds = time.perf_counter() - begin
    work.made.append({"picture": shot.number, "frame": shot.frame, "file": name, "seconds": round(seconds, 3)})
    work.log.line(f"picture {shot.number}  frame {shot.frame}, {seconds:.1f} s, {name}")


def _say(work: Work, shots: list[Shot]) -> None:
    """Say what is made of what, judged by the first frame that can be read."""
    for frame in dict.fromkeys(shot.frame for shot in shots):
        try:
            fields = work.volumes.fields(frame, work.studio.names)
            break
        except (ValueError, OSError):
            if frame == shots[-1].frame:
                raise
    if work.studio.options.motion_blur and "velocity" not in fields:
        raise ValueError(f"motion-blur needs velocity, which {work.volumes.name} does not hold: leave it out")
    x, z, y = fields["density"].shape
    width, height = picture_size((x, z, y), work.studio.options.size())
    name = work.studio.look.name if work.studio.look else work.studio.ramp
    work.log.line(f"source  {work.volumes.name}: {x}x{y}x{z} voxels, {len(work.volumes.frames)} frames")
    work.log.notes(work.volumes.messages)
    work.log.line(f"render  {len(shots)} pictures of {width}x{height}, look {name}, mode {work.studio.options.mode}")
    work.log.notes(stand_ins(work.studio.look, fields) if work.studio.look else ())


def _conclude(work: Work, count: int, common) -> int:
    if common.json:
        print(json.dumps({"out": str(work.target.path), "pictures": work.made, "failed": work.failed}))
    else:
        print(f"{work.target.path}: {len(work.made)} of {count} pictures")
    return name_failures(work.failed, TRY_AGAIN)
