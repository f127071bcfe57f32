"""What ``warpfluid render`` does, once its flags are read."""

import json
import os
from dataclasses import replace
from pathlib import Path

from warpfluid.cluster.pools import Asked, reach
from warpfluid.commands.shooting import Work, shoot
from warpfluid.errors import Problems
from warpfluid.options import CameraOptions, LightOptions, RenderOptions
from warpfluid.outcome import name_failures
from warpfluid.progress import Progress
from warpfluid.rendering.framing import decided, picture_size
from warpfluid.rendering.job import PictureJob
from warpfluid.rendering.lamps import Lamps
from warpfluid.rendering.output import Target
from warpfluid.rendering.records import PictureRecords, made_with
from warpfluid.rendering.shots import Shot, check_target, make_shots
from warpfluid.rendering.studio import make_studio, stand_ins
from warpfluid.run import Run
from warpfluid.simulation.outlines import Outlines
from warpfluid.volumes import VolumeSequence, check_room, open_volumes

RATE, WHITE = 24.0, 255.0
TRY_AGAIN = "the other pictures are whole; with numbered pictures, the same command with --resume makes what is missing"


def render(
    source: str,
    camera: CameraOptions,
    light: LightOptions,
    options: RenderOptions,
    out: Path,
    *,
    resume: bool = False,
    overwrite: bool = False,
    jobs: str = "1",
    cluster: str | None = None,
    common,
) -> int:
    """Make pictures or a film of volumes; return the exit code."""
    from warpfluid.device import pick_device

    log, problems = Progress(quiet=common.quiet, verbose=common.verbose), Problems()
    if cluster:  # whose workers are in other folders
        source, out = os.path.abspath(os.path.expanduser(source)), out.absolute()
        camera = replace(camera, camera=os.path.abspath(camera.camera)) if camera.camera else camera
    facts = {"separate": camera.stereo == "separate", "half": options.half, "deep": options.deep}
    target = problems.attempt(lambda: Target(path=out, **facts))
    asked = problems.attempt(lambda: Asked(jobs=jobs, device=common.device, cluster=cluster))
    volumes = problems.attempt(_open, source, options)
    device = problems.attempt(pick_device, common.device)
    lamps = Lamps(light)
    problems.attempt(lambda: lamps.probe)
    problems.raise_if_any()
    rate = (volumes.document or {}).get("simulate", {}).get("fps", RATE)
    lamps = lamps.usual_for(options.look or volumes.output.look)
    studio = make_studio(options, lamps, volumes.output.look, device, rate=rate)
    shots = make_shots(volumes, options.frames, camera.turntable)
    check_target(target, shots, resume=resume, overwrite=overwrite)
    stands = Outlines(Run(Path(source).expanduser())) if light.bodies and volumes.document else None
    job = PictureJob(volumes, decided(camera, options), studio, target, stands)
    work = Work(job=job, shots=shots, log=log, **_records(target, volumes))
    fields = _say(work, verbose=common.verbose)
    need = job.need(fields["density"].shape, len(fields))
    check_room(volumes.shape, bytes_of=lambda box: job.need((box[0], box[2], box[1]), len(fields)), device=device)
    about = made_with(camera, light, options, options.look or volumes.output.look, volumes.scale)
    with reach(asked, need=need, folder=target.path.parent, say=log.line) as crew:
        left = _begin(work, about, resume=resume)
        shoot(work, left, crew, device, need)
    return _conclude(work, len(shots) - len(left), common)


def _begin(work: Work, about: dict, *, resume: bool) -> list[Shot]:
    """Make the folder and note what pictures are made with; return those that lack."""
    work.job.target.make_folder()
    numbers = [shot.number for shot in work.shots]
    kept = work.records.begin(about, work.hashes, numbers, resume=resume) if work.records else set()
    left = [shot for shot in work.shots if shot.number not in kept]
    if len(left) < len(work.shots):
        work.log.line(f"kept    {len(work.shots) - len(left)} pictures that are there")
    return left


def _records(target: Target, volumes: VolumeSequence) -> dict:
    """Return where numbered pictures are noted, and the hashes of their volumes."""
    return {"records": PictureRecords(target), "hashes": volumes.hashes()} if target.is_numbered else {}


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


def _say(work: Work, *, verbose: bool) -> dict:
    """Say what is made of what, judged by the fields of the first frame that can be read; return them."""
    volumes, studio, fields = work.job.volumes, work.job.studio, {}
    for frame in dict.fromkeys(shot.frame for shot in work.shots):
        try:
            fields = volumes.fields(frame, studio.names)
            break
        except (ValueError, OSError):
            if frame == work.shots[-1].frame:
                raise
    if studio.options.motion_blur and "velocity" not in fields:
        raise ValueError(f"motion-blur needs velocity, which {volumes.name} does not hold: leave it out")
    x, z, y = fields["density"].shape
    width, height = picture_size((x, z, y), studio.options.size())
    name = studio.look.name if studio.look else studio.ramp
    work.log.line(f"source  {volumes.name}: {x}x{y}x{z} voxels, {len(volumes.frames)} frames")
    work.log.notes(volumes.messages)
    work.log.line(f"render  {len(work.shots)} pictures of {width}x{height}, look {name}, mode {studio.options.mode}")
    if studio.look and (studio.options.look or verbose):  # of the run's own look they are the usual case
        work.log.notes(stand_ins(studio.look, fields))
    return fields


def _conclude(work: Work, kept: int, common) -> int:
    path = work.job.target.path
    if common.json:
        print(json.dumps({"out": str(path), "pictures": work.made, "failed": work.failed}))
    else:
        print(f"{path}: {kept + len(work.made)} of {len(work.shots)} pictures")
    return name_failures(work.failed, TRY_AGAIN)
