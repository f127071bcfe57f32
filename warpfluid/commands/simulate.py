"""What ``warpfluid simulate`` and ``warpfluid presets`` do, once their flags are read."""

import json
import re
import shlex
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import partial
from importlib.resources import files
from pathlib import Path

from warpfluid.errors import Problems, describe
from warpfluid.files.sequences import format_frames, parse_frames
from warpfluid.outcome import conclude, do_all, exactness
from warpfluid.presets import preset_names, preset_settings
from warpfluid.progress import Progress, say_left
from warpfluid.run import FILM, PAGE, SETTINGS, Run
from warpfluid.settings import SimulateSettings, make_simulate_settings
from warpfluid.simulation.need import check_need
from warpfluid.simulation.source import Source, empty_box, fill_box
from warpfluid.volumes import VolumeSequence, open_volumes

USUAL_LENGTH = 48  # frames of a simulation that follows nothing


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What the command line asks for.

    Attributes:
        source: A run or volumes; None for those of the configuration, or an empty box.
        size: WIDTHxHEIGHT of an empty box.
        preset: Name of a preset.
        things: Lines by kind: emitters, obstacles, forces, bodies.
        method: Flags of the simulation.
        output: Flags of the output.
    """

    source: str | None
    size: str | None
    preset: str | None
    things: dict[str, list[str] | None]
    method: object
    output: object


def simulate(asked: Asked, out: Path, *, paper: bool, document: dict, resume: bool, overwrite: bool, common) -> int:
    """Simulate into a folder; return the exit code."""
    from warpfluid.device import pick_device

    log, run, problems = Progress(quiet=common.quiet, verbose=common.verbose), Run(out), Problems()
    _check_other(asked.source, out)
    problems.attempt(lambda: run.check_free(resume=resume, overwrite=overwrite))
    device = problems.attempt(pick_device, common.device)
    made = problems.attempt(_settle, asked, paper, document, device, _earlier(run) if resume else None)
    problems.raise_if_any()
    settings, source = made
    _check_other(settings.source, out)
    frames = _frames(_joined(run, settings.simulate.frames) if resume else settings.simulate.frames, source)
    volumes = source.volumes
    facts = {"device": str(device), "angles": list(volumes.angles_deg), "scale": volumes.scale}
    facts |= {"frames": format_frames(frames), "inputs": volumes.hashes()}
    kept = run.begin(settings, facts, resume=resume, overwrite=overwrite)
    size = "x".join(map(str, _sizes(source)))
    log.line(f"source  {settings.source or 'an empty box'}: {size} voxels, {len(frames)} frames")
    log.notes(volumes.messages)
    failed = _animate(run, settings, source, frames, device, resume and _continues(run, frames, kept), log)
    failed |= _summarize(run, settings, source, device, log)
    return conclude(run, frames, failed, as_json=common.json)


def _check_other(source: str | None, out: Path) -> None:
    if source and Path(source).expanduser().resolve() == out.resolve():
        raise ValueError(f"{out} is the source itself: choose another folder with -o")


def show_presets(common) -> int:
    """List the presets; return the exit code."""
    if common.json:
        print(json.dumps({name: preset_settings(name) for name in preset_names()}, indent=2))
        return 0
    for name in preset_names():
        text = (files("warpfluid") / "presets" / f"{name}.toml").read_text("utf-8")
        flags = (_flag(option, value) for option, value in preset_settings(name)["simulate"].items())
        print(f"{name}\n    {text.splitlines()[0].removeprefix('# ')}\n    {' '.join(flags)}")
    return 0


def _flag(option: str, value) -> str:
    """Return an option as it is written on a command line."""
    name = option.replace("_", "-")
    if isinstance(value, bool):
        return f"--{name}" if value else f"--no-{name}"
    return f"--{name} {shlex.quote(str(value))}"


def _settle(
    asked: Asked, paper: bool, document: dict, device, earlier: str | None = None
) -> tuple[SimulateSettings, Source]:
    """Return settings and source, each with the other's say; ``earlier`` are the frames of a run that goes on."""
    problems = Problems()
    size = problems.attempt(_size, asked.size) if asked.size else tuple(document.get("size", ())) or None
    name = asked.source or document.get("source")
    if name and asked.size:
        problems.append("size is for an empty box, and there is a source: use --resolution-scale")
    volumes = problems.attempt(open_volumes, name) if name else None
    chosen = {"size": size, "preset": asked.preset, "paper": paper, "document": document}
    first = problems.attempt(_first_frame, (earlier, _asked_frames(asked, document)), volumes)
    chosen["first"] = 1 if first is None else first
    if volumes and "output" not in document:
        chosen["source_output"] = asdict(volumes.output)
    make = partial(make_simulate_settings, **chosen)
    settings = problems.attempt(make, asked.source, asked.method, asked.output, asked.things)
    problems.raise_if_any()
    check_need(settings, volumes, device)
    scale = settings.simulate.resolution_scale
    source = fill_box(volumes, scale) if volumes else empty_box(settings.size, scale)
    if not name and not any(settings.scene.emitter):
        raise ValueError("there is nothing to simulate: name a run or volumes, a --preset, or an --emitter")
    if len(source.frames) > 1 and settings.simulate.time_scale != 1:
        raise ValueError("time-scale is not 1, but a sequence is followed frame by frame: leave it at 1")
    _check_scene(settings, source)
    return settings, source


def _check_scene(settings: SimulateSettings, source: Source) -> None:
    """Refuse things that cannot be built, such as a mesh whose file is damaged, before any work is done."""
    from warpfluid.simulation.placing import Placing

    placing, problems, scene = Placing(source.shape, source.reference), Problems(), settings.scene
    stands = scene.obstacle or any(body.obstacle for body in scene.body)
    if settings.simulate.pressure == "direct" and (stands or settings.simulate.liquid_weight):
        problems.append("pressure is direct, which takes neither obstacles nor liquid: use auto or multigrid")
    for emitter in scene.emitter:
        problems.attempt(placing.emitter, emitter, 0.0, where="--emitter: ")
    for obstacle in scene.obstacle:
        problems.attempt(placing.solid, obstacle, 0.0, 0.0, where="--obstacle: ")
    for body in scene.body:
        problems.attempt(placing.body, body, 0.0, where="--body: ")
    problems.raise_if_any()


def _earlier(run: Run) -> str | None:
    """Return the frames that a run was asked for before, if they were named."""
    return run.settings().get("simulate", {}).get("frames") if (run.folder / SETTINGS).is_file() else None


def _joined(run: Run, text: str | None) -> str | None:
    """Return frames together with those of the parts of a run that were asked for before."""
    if not (run.folder / SETTINGS).is_file():
        return text
    earlier = _earlier(run)
    return f"{earlier},{text}" if earlier and text else None


def _frames(text: str | None, source: Source) -> tuple[int, ...]:
    """Return the frames to write."""
    if text is None:
        return source.frames if len(source.frames) > 1 else tuple(range(*_usual(source)))
    frames = tuple(parse_frames(text))
    if source.frames and frames[0] not in source.frames:
        have = f"{source.frames[0]} to {source.frames[-1]}"
        raise ValueError(f"frames begin with {frames[0]}, which the source has not (it has {have})")
    return frames


def _asked_frames(asked: Asked, document: dict) -> str | None:
    """Return the frames that are asked for, by a flag before a file."""
    return getattr(asked.method, "frames", None) or document.get("simulate", {}).get("frames")


def _first_frame(texts: Sequence[str | None], volumes: VolumeSequence | None) -> int:
    """Return with which frame a simulation begins: the first of those that are named, of a run that is made longer."""
    text = next(filter(None, texts), None)
    return parse_frames(text)[0] if text else volumes.frames[0] if volumes else 1


def _usual(source: Source) -> tuple[int, int]:
    first = source.frames[0] if source.frames else 1
    return first, first + USUAL_LENGTH


def _continues(run: Run, frames: tuple[int, ...], kept: dict) -> bool:
    """Return whether a run can go on from its checkpoint: all frames up to it are there and whole."""
    from warpfluid.simulation.checkpoint import checkpoint_frame

    last = checkpoint_frame(run)
    return last is not None and frames[0] <= last and {frame for frame in frames if frame <= last} <= set(kept)


def _animate(run: Run, settings: SimulateSettings, source: Source, frames, device, resume: bool, log: Progress) -> dict:
    """Simulate the frames; return what failed."""
    from warpfluid.simulation.animate import Animator
    from warpfluid.simulation.animation import Animation

    animation = Animation(
        source=source, options=settings.simulate, scene=settings.scene, output=settings.output, device=device
    )
    took = []
    try:
        for record in Animator(animation, frames).run(run, resume=resume):
            took += [record["seconds"]] if record["steps"] else []  # the first frame may be the source as it is
            left = sum(took) / max(len(took), 1) * sum(frame > record["frame"] for frame in frames)
            exact = f", views {exactness(record['input_psnr'])}" if "input_psnr" in record else ""
            made = f"{record['seconds']:.1f} s, {record['steps']} steps{exact}, {record['file']}"
            log.line(f"frame   {record['frame']}  {made}{say_left(left)}")
    except KeyboardInterrupt as stop:
        there = f"stopped after {len(run.records())} of {len(frames)} frames"
        raise KeyboardInterrupt(f"{there}; to continue: warpfluid simulate -o {run.folder} --resume") from stop
    except (ValueError, OSError) as error:
        log.stack()
        return {"simulation": describe(error)}
    return {}


def _summarize(run: Run, settings: SimulateSettings, source: Source, device, log: Progress) -> dict[str, str]:
    """Write the turntable and the report of what is finished; return what failed."""
    from warpfluid.report.course import departure
    from warpfluid.report.film import write_film
    from warpfluid.report.of_simulation import report_simulation

    log.notes(departure(run.records(), settings))
    jobs, look, scale = {}, settings.output.look, source.volumes.scale
    if settings.output.turntable:
        jobs[FILM] = lambda: write_film(run, look, run.folder / FILM, scale=scale)
    if settings.output.report:
        jobs[PAGE] = lambda: report_simulation(run, settings, source, device=device)
    go_on = f"warpfluid simulate -o {run.folder} --resume"
    return do_all(jobs if run.records() else {}, log, go_on)


def _size(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d{1,4})x(\d{1,4})", text)
    if not match or min(int(n) for n in match.groups()) < 8:
        raise ValueError(f"size is {text!r}, expected WIDTHxHEIGHT of at least 8, such as 96x144")
    return int(match[1]), int(match[2])


def _sizes(source: Source) -> tuple[int, int, int]:
    """Return the voxels of a source as people say them: width, height, depth."""
    return source.shape[0], source.shape[2], source.shape[1]
