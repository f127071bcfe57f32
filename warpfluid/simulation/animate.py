"""Frame after frame: volumes become an animation that flows, keeps the look of the footage and obeys the artist.

The paper blends the volume in (Eq. 10) and then steps. Our default steps first and corrects after, both ways, and
balances the result against the views: nothing is averaged that disagrees, so nothing blurs.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import warp as wp

from warpfluid.kernels import vectors
from warpfluid.kernels.totals import scale, total
from warpfluid.metrics import psnr
from warpfluid.options import OutputOptions, Scene, SimulateOptions
from warpfluid.options.keys import Keyed
from warpfluid.run import Run
from warpfluid.simulation.checkpoint import load_state, save_state
from warpfluid.simulation.displacement import advance_displacement, displaced
from warpfluid.simulation.drag import flow_around
from warpfluid.simulation.forces import STANDARD_GRAVITY, place_force
from warpfluid.simulation.guidance import Footage, Motion, follow, on_faces
from warpfluid.simulation.physics import Physics
from warpfluid.simulation.placing import Placing
from warpfluid.simulation.rigid_motion import advance
from warpfluid.simulation.solids import build_solids, clear
from warpfluid.simulation.solver import Solver, Surroundings
from warpfluid.simulation.source import Source
from warpfluid.simulation.state import Faces, FluidState, Solids, six_sides
from warpfluid.simulation.written import grids_of, write_transforms

EDITED_FIDELITY = 0.3
EDITS = (
    "density_buoyancy",
    "temperature_buoyancy",
    "liquid_weight",
    "swirl",
    "turbulence_strength",
    "wind",
    "velocity_damp",
    "viscosity",
    "density_diffusion",
    "combustion",
)

Progress = Callable[[dict], None]


@dataclass(frozen=True, kw_only=True)
class Animation:
    """A simulation over frames.

    Attributes:
        source: What it starts from and follows.
        options: Its choices.
        scene: What the artist put into the box.
        output: How files are stored.
        device: Where to compute.
    """

    source: Source
    options: SimulateOptions
    scene: Scene
    output: OutputOptions
    device: wp.Device

    @property
    def fidelity(self) -> float:
        """How strongly the footage pulls: all the way, unless the artist adds something."""
        if self.options.fidelity is not None:
            return self.options.fidelity
        return EDITED_FIDELITY if is_edited(self.options, self.scene) else 1.0


def is_edited(options: SimulateOptions, scene: Scene) -> bool:
    """Return whether an artist adds anything to what the footage asks for."""
    usual = SimulateOptions()
    changed = any(getattr(options, name) != getattr(usual, name) for name in EDITS)
    return changed or bool(scene.emitter or scene.obstacle or scene.force)


class Animator:
    """Makes the frames of an animation, one after the other.

    Args:
        animation: What to make.
        frames: Which frames, rising.
    """

    def __init__(self, animation: Animation, frames: tuple[int, ...]):
        self.animation, self.frames = animation, frames
        source, options = animation.source, animation.options
        self.placing = Placing(source.shape, source.reference)
        sides = six_sides(options.boundary_x, options.boundary_z, options.boundary_y)
        self.solver = Solver(Physics(options, self.placing, sides))
        self.footage = Footage(source.angles_deg, source.shape, animation.device)
        self.bodies = [self.placing.body(body, frames[0]) for body in animation.scene.body]
        self._solids: tuple[tuple, Solids | None] = ((), None)
        self._loaded: dict[int, wp.array] = {}
        self.state = self._first_state(frames[0])

    def run(self, run: Run, *, resume: bool) -> Iterator[dict]:
        """Simulate and write the frames.

        Args:
            run: Where to write; begun already.
            resume: Go on from the run's checkpoint.

        Yields:
            The record of every frame that is made.

        Raises:
            ValueError: If the simulation grows out of bounds, or a volume of the source cannot be read.
            OSError: If a file cannot be read or written.
        """
        last = load_state(run, self.state, self.bodies) if resume else None
        for frame in self.frames:
            if last is not None and frame <= last:
                continue
            begin, steps = time.perf_counter(), 0
            try:
                if last is not None:
                    steps = self.advance(last, frame)
                else:
                    for early in range(self.animation.options.preroll, 0, -1):
                        steps += self.advance(frame - early, frame - early + 1, follows=False)
                self._check_finite()
            except FloatingPointError as error:
                raise ValueError(f"frame {frame}: {error}; {self._cause(frame)}") from error
            yield self._write(run, frame, steps, begin)
            last = frame

    def advance(self, frame: int, later: int, *, follows: bool = True) -> int:
        """Simulate from one frame to another; return how many solver steps were made."""
        options = self.animation.options
        seconds = (later - frame) / options.fps * Keyed(options.time_scale).at(frame)
        now, then = (self._volume(number) if follows else None for number in (frame, later))
        weight = Keyed(options.blend).at(frame)
        subtract = Keyed(options.subtract).at(frame)
        if options.order == "blend-first" and now:
            self._correct(now, weight, subtract)
        around = self._surroundings(frame, later, seconds, now, then)
        steps = self.solver.step(self.state, frame, seconds, around)
        self._move_bodies(frame, seconds)
        if then and options.order == "step-first":
            self._correct(self._wanted(then, around.motion, seconds), weight, subtract)
        if then:
            self.footage.balance(self.state.density, then, power=self.animation.fidelity)
            if around.solids:
                clear(self.state.density, around.solids)
            self._keep_total(then)
        return steps

    def _first_state(self, frame: int) -> FluidState:
        """Return d = v and psi = omega of the first frame."""
        shape, device = self.placing.shape, self.animation.device
        cells = [wp.zeros(shape, dtype=float, device=device) for _ in range(4)]
        state = FluidState(Faces.zeros(shape, device), *cells)
        volume = self._volume(frame)
        if volume:
            wp.copy(state.density, volume)
            self._heat(state.temperature, volume, 1.0, 1.0)
            if self.animation.options.combustion:
                wp.copy(state.fuel, volume)
        later = self.frames[1] if len(self.frames) > 1 else frame
        motion = self._motion(frame, later, volume, self._volume(later) if later > frame else None, 1.0)
        if motion:
            fps = self.animation.options.fps / (later - frame)
            for part, target in zip(state.velocity, motion.target, strict=True):
                vectors.add_scaled(part, fps, target, out=part)
        return state

    def _volume(self, frame: int) -> wp.array | None:
        """Return the source's volume of a frame, None where it has none."""
        if frame not in self.animation.source.files:
            return None
        if frame not in self._loaded:
            volume = wp.array(self.animation.source.volume(frame), dtype=float, device=self.animation.device)
            self._loaded = {**dict(list(self._loaded.items())[-1:]), frame: volume}
        return self._loaded[frame]

    def _motion(self, frame: int, later: int, now, then, seconds: float) -> Motion | None:
        options = self.animation.options
        weight = Keyed(options.guide_weight).at(frame)
        weight *= self.animation.fidelity if options.order == "step-first" else 1.0
        if not (now and then and weight and seconds):
            return None
        omega = self.footage.omega(now, then, method=options.flow, sigma=options.guide_radius)
        project = options.guide_mode == "project"
        return Motion(
            on_faces(omega, seconds, options.guide_radius), options.guide_radius, weight, self.solver.sides, project
        )

    def _surroundings(self, frame: int, later: int, seconds: float, now, then) -> Surroundings:
        scene = self.animation.scene
        return Surroundings(
            emitters=tuple(self.placing.emitter(emitter, frame) for emitter in scene.emitter),
            forces=tuple(place_force(force, self.placing, frame) for force in scene.force),
            solids=self._find_solids(frame, later, seconds),
            motion=self._motion(frame, later, now, then, seconds),
        )

    def _find_solids(self, frame: int, later: int, seconds: float) -> Solids | None:
        """Return what stands in the fluid; the same object as long as nothing moves, for it keeps its grids."""
        scene = self.animation.scene
        placed = [self.placing.solid(o, frame, later, max(seconds, 1e-9)) for o in scene.obstacle]
        bodies = zip(self.bodies, scene.body, strict=True)
        placed += [body.placed() for body, options in bodies if options.obstacle]
        if not placed:
            return None
        key = tuple(np.concatenate([p.centre, p.rotation.ravel(), p.velocity, p.spin]).tobytes() for p in placed)
        if key != self._solids[0]:
            solids = build_solids(placed, self.placing.shape, self.animation.device, sides=self.solver.sides)
            self._solids = (key, solids)
        return self._solids[1]

    def _move_bodies(self, frame: int, seconds: float) -> None:
        if not self.bodies or seconds <= 0:
            return
        gravity = -float(self.placing.vector(self.animation.options.gravity, frame)[1])
        flow = flow_around(self.state, self.placing.reference)
        for body in self.bodies:
            advance(body, seconds, gravity=gravity, flow=flow)

    def _wanted(self, volume: wp.array, motion: Motion | None, seconds: float) -> wp.array:
        """Return the volume that the fluid is drawn to: the source's, moved to where edits have carried it."""
        keep = 1.0 - self.animation.fidelity
        if not (motion and keep > 0):
            return volume
        state, sides = self.state, self.solver.sides
        state.away = advance_displacement(state.away, state.velocity, motion.target, sides, seconds, keep=keep)
        return displaced(volume, state.away)

    def _correct(self, volume: wp.array, weight: float, subtract: float) -> None:
        """Move density, heat and fuel towards a volume."""
        state = self.state
        if self.animation.options.combustion:
            missing = wp.clone(state.density)
            follow(missing, volume, weight=weight, subtract=0.0)
            vectors.add_scaled(missing, -1.0, state.density, out=missing)
            vectors.add_scaled(state.fuel, 1.0, missing, out=state.fuel)
        follow(state.density, volume, weight=weight, subtract=subtract)
        self._heat(state.temperature, volume, weight, subtract)

    def _heat(self, temperature: wp.array, volume: wp.array, weight: float, subtract: float) -> None:
        """Move heat towards what a volume shows: where there is light, it is hot."""
        if weight:
            hot = wp.zeros_like(volume)
            vectors.add_scaled(hot, 1 / self.placing.reference, volume, out=hot)
            follow(temperature, hot, weight=weight, subtract=subtract)

    def _keep_total(self, volume: wp.array) -> None:
        """Let density vanish where more is there than in the source (automatic dissipation)."""
        adds = self.animation.scene.emitter or self.animation.options.combustion
        if self.animation.options.density_dissipation == "auto" and not adds:
            there = total(self.state.density)
            scale(self.state.density, min(1.0, total(volume) / max(there, 1e-30)))

    def _check_finite(self) -> None:
        for name in ("density", "temperature", "fuel"):
            if not np.isfinite(vectors.largest(getattr(self.state, name))):
                raise FloatingPointError(f"the {name} is not finite")

    def _cause(self, frame: int) -> str:
        """Return which setting drives the fluid most, and what to do."""
        number, scene = self.solver.number, self.animation.scene
        gravity = np.linalg.norm(Keyed(self.animation.options.gravity, 3).at(frame)) / STANDARD_GRAVITY
        drives = {
            "temperature-buoyancy": abs(number("temperature_buoyancy", frame)) * gravity * self._hottest(),
            "density-buoyancy": abs(number("density_buoyancy", frame)) * gravity,
            "turbulence-strength": number("turbulence_strength", frame) * 10,
            "swirl": number("swirl", frame),
            "expansion": number("expansion", frame) * self.animation.options.combustion * 10,
            "the velocity of the emitters": max(
                (np.abs(Keyed(e.velocity, 3).at(frame)).max() for e in scene.emitter if e.drive), default=0
            ),
            "the strength of the forces": max((abs(Keyed(f.strength).at(frame)) for f in scene.force), default=0),
        }
        name = max(drives, key=drives.get)
        more = "--substeps" if self.animation.options.substeps else "--max-substeps"
        if drives[name] == 0:
            return f"raise {more}, or lower --guide-weight"
        return f"lower {name if ' ' in name else f'--{name}'}, or raise {more}"

    def _hottest(self) -> float:
        value = vectors.largest(self.state.temperature)
        return value if np.isfinite(value) else 1.0

    def _write(self, run: Run, frame: int, steps: int, begin: float) -> dict:
        """Write a frame, the bodies and the checkpoint; return the record."""
        source, volume = self.animation.source, self._volume(frame)
        record = {"steps": steps, "total": total(self.state.density) / source.scale}
        if volume:
            pairs = zip(self.footage.images(self.state.density), self.footage.images(volume), strict=True)
            record["input_psnr"] = [round(psnr(a, b, 255.0), 2) for a, b in pairs]
            record["total_over_source"] = round(total(self.state.density) / max(total(volume), 1e-30), 4)
        density, more = grids_of(
            self.state, self.placing, source, self.animation.output, burns=self.animation.options.combustion
        )
        record["seconds"] = round(time.perf_counter() - begin, 3)
        record = run.write_frame(frame, density, self.animation.output, record, more=more)
        if self.bodies:
            write_transforms(run, frame, self.bodies, self.placing, self.animation.output.voxel_size)
        save_state(run, frame, self.state, self.bodies)
        return record
