"""Frame after frame: volumes become an animation that flows, keeps the look of the footage and obeys the artist.

The paper blends the volume in (Eq. 10) and then steps. Our default steps first and corrects after, both ways, and
balances the result against the views: nothing is averaged that disagrees, so nothing blurs.
"""

import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import warp as wp

from warpfluid.device import one_blas_thread
from warpfluid.kernels import vectors
from warpfluid.kernels.fluid.totals import scale, total
from warpfluid.metrics import psnr
from warpfluid.options.keys import Keyed
from warpfluid.run import Run
from warpfluid.simulation.animation import Animation
from warpfluid.simulation.cause import name_cause
from warpfluid.simulation.checkpoint import load_state, save_state
from warpfluid.simulation.detail import Detail
from warpfluid.simulation.displacement import advance_displacement, displaced
from warpfluid.simulation.fields import number_or_field
from warpfluid.simulation.forces import place_force
from warpfluid.simulation.guidance import Footage, Motion, follow, on_faces, share_of
from warpfluid.simulation.physics import Physics
from warpfluid.simulation.placing import Placing
from warpfluid.simulation.scenery import Scenery
from warpfluid.simulation.shadow import advance_shadow, shaded
from warpfluid.simulation.solids import clear
from warpfluid.simulation.solver import Solver, Surroundings
from warpfluid.simulation.state import Faces, FluidState, six_sides
from warpfluid.simulation.written import RIM, fields_of, grids_of, write_transforms


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
        self.footage = Footage(source.volumes.angles_deg, source.shape, animation.device)
        self.scenery = Scenery(animation.scene, self.placing, sides, animation.device, frames[0])
        self.detail = None
        if options.detail > 1:
            self.detail = Detail(options.detail, source.shape, sides, options.turbulence_seed, animation.device)
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
        last = load_state(run, self.state, self.scenery.bodies, self.detail) if resume else None
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
                raise ValueError(
                    f"frame {frame}: {error}; {self._cause(frame - 1 if last is None else last, frame)}"
                ) from error
            yield self._write(run, frame, steps, begin)
            last = frame

    @one_blas_thread()
    def advance(self, frame: int, later: int, *, follows: bool = True) -> int:
        """Simulate from one frame to another; return how many solver steps were made."""
        options = self.animation.options
        seconds = (later - frame) / options.fps * Keyed(options.time_scale).at(frame)
        now, then = (self._volume(number) if follows else None for number in (frame, later))
        if options.order == "blend-first" and now:
            self._correct(now, frame)
        around = self._surroundings(frame, later, seconds, now, then)
        steps = self.solver.step(self.state, frame, seconds, around)
        gravity = -float(self.placing.vector(options.gravity, frame)[1])
        self.scenery.move(self.state, seconds, gravity=gravity)
        if then and options.order == "step-first":
            self._cast_shadow(around, seconds, frame)
            self._correct(self._wanted(then, around.motion, seconds, frame), frame)
        if then:
            shown = shaded(then, self.state.shadow) if self.state.shadow else then
            self.footage.balance(self.state.density, shown, power=self.animation.fidelity(frame))
            if around.solids:
                clear(self.state.density, around.solids)
            self._keep_total(then)
        if self.detail:
            self.detail.advance(self.state, seconds, self.placing.reference)
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
        seconds = (later - frame) / self.animation.options.fps
        solids = self.scenery.solids(frame, later, seconds)
        for field in (state.density, state.temperature, state.fuel) if solids else ():
            clear(field, solids)
        omega = self._omega(frame, seconds, volume, self._volume(later) if seconds else None)
        for part, target in zip(state.velocity, omega or (), strict=bool(omega)):
            wp.copy(part, target)
        return state

    def _volume(self, frame: int) -> wp.array | None:
        """Return the source's volume of a frame, None where it has none."""
        if frame not in self.animation.source.volumes.files:
            return None
        if frame not in self._loaded:
            volume = wp.array(self.animation.source.volume(frame), dtype=float, device=self.animation.device)
            self._loaded = {**dict(list(self._loaded.items())[-1:]), frame: volume}
        return self._loaded[frame]

    def _omega(self, frame: int, seconds: float, now: wp.array | None, then: wp.array | None) -> Faces | None:
        """Return G(omega), the slow motion from one volume to the next [voxel/s]; None without two volumes."""
        if not (now and then and seconds):
            return None
        sigma = self.solver.number("guide_radius", frame)
        omega = self.footage.omega(now, then, method=self.animation.options.flow, sigma=sigma)
        return on_faces(omega, seconds, sigma)

    def _motion(self, frame: int, seconds: float, now: wp.array | None, then: wp.array | None) -> Motion | None:
        options, fidelity = self.animation.options, self.animation.fidelity(frame)
        weight = Keyed(options.guide_weight).at(frame) * (fidelity if options.order == "step-first" else 1.0)
        needed = weight > 0 or (fidelity < 1 and options.order == "step-first")
        omega = self._omega(frame, seconds, now, then) if needed else None
        if omega is None:
            return None
        sigma, project = self.solver.number("guide_radius", frame), options.guide_mode == "project"
        return Motion(omega, sigma, weight, self.solver.sides, project)

    def _surroundings(self, frame: int, later: int, seconds: float, now, then) -> Surroundings:
        scene = self.animation.scene
        return Surroundings(
            emitters=tuple(self.placing.emitter(emitter, frame) for emitter in scene.emitter),
            forces=tuple(place_force(force, self.placing, frame) for force in scene.force),
            solids=self.scenery.solids(frame, later, seconds),
            motion=self._motion(frame, seconds, now, then),
            follows=then is not None,
        )

    def _wanted(self, volume: wp.array, motion: Motion | None, seconds: float, frame: float) -> wp.array:
        """Return the volume that the fluid is drawn to: the source's, moved to where edits have carried it."""
        keep = 1.0 - self.animation.fidelity(frame)
        state, sides = self.state, self.solver.sides
        if motion and keep > 0:
            state.away = advance_displacement(state.away, state.velocity, motion.target, sides, seconds, keep=keep)
            volume = displaced(volume, state.away)
        return shaded(volume, state.shadow) if state.shadow else volume

    def _cast_shadow(self, around: Surroundings, seconds: float, frame: float) -> None:
        """Let what stands in the way keep the footage from what lies behind it."""
        keep, state = 1.0 - self.animation.fidelity(frame), self.state
        if around.motion and keep > 0:
            target, sides = around.motion.target, self.solver.sides
            state.shadow = advance_shadow(state.shadow, target, around.solids, sides, seconds, keep=keep)

    def _correct(self, volume: wp.array, frame: float) -> None:
        """Move density, heat and fuel towards a volume."""
        state, subtract = self.state, self.solver.number("subtract", frame)
        weight = number_or_field(self.animation.options.blend, frame, state, self.placing)
        factor, scene = self.solver.number("blend_apart", frame), self.animation.scene
        makes = scene.emitter or scene.obstacle or scene.body or self.animation.options.combustion
        weight = share_of(volume, state.density, weight=weight, factor=factor, amounts=not makes)
        if self.animation.options.combustion:
            missing = wp.clone(state.density)
            follow(missing, volume, weight=weight, subtract=0.0)
            vectors.add_scaled(missing, -1.0, state.density, out=missing)
            vectors.add_scaled(state.fuel, 1.0, missing, out=state.fuel)
        follow(state.density, volume, weight=weight, subtract=subtract)
        self._heat(state.temperature, volume, weight, subtract)

    def _heat(self, temperature: wp.array, volume: wp.array, weight: float | wp.array, subtract: float) -> None:
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

    def _elsewhere(self, volume: wp.array) -> float:
        """Return the share of the light that is not where the source has it."""
        found, wanted = self.state.density.numpy(), volume.numpy()
        apart = np.abs(found - wanted).sum(dtype=np.float64)
        return float(apart / max(found.sum(dtype=np.float64) + wanted.sum(dtype=np.float64), 1e-30))

    def _check_finite(self) -> None:
        for name in ("density", "temperature", "fuel"):
            if not np.isfinite(vectors.largest(getattr(self.state, name))):
                raise FloatingPointError(f"the {name} is not finite")

    def _cause(self, frame: int, later: int) -> str:
        solids = self.scenery.solids(frame, later, (later - frame) / self.animation.options.fps)
        return name_cause(self.solver.physics, self.animation.scene, self.state, solids, frame)

    def _write(self, run: Run, frame: int, steps: int, begin: float) -> dict:
        """Write a frame, the bodies and the checkpoint; return the record."""
        source, volume = self.animation.source, self._volume(frame)
        record = {"steps": steps, "total": total(self.state.density) / source.volumes.scale}
        if volume:
            pairs = zip(self.footage.images(self.state.density), self.footage.images(volume), strict=True)
            record["input_psnr"] = [round(psnr(a, b, 255.0), 2) for a, b in pairs]
            record["elsewhere"] = round(self._elsewhere(volume), 4)
            record["total_over_source"] = round(total(self.state.density) / max(total(volume), 1e-30), 4)
        fields, output, factor = fields_of(self.state), self.animation.output, self.animation.options.detail
        if self.detail:
            strength = self.solver.number("detail_strength", frame)
            fields = self.detail.refine(self.state, self.placing.reference, strength=strength)
            output = replace(output, voxel_size=output.voxel_size / factor)
        burns = self.animation.options.combustion
        density, more = grids_of(fields, self.placing, source, output, burns=burns, rim=RIM * factor)
        record["seconds"] = round(time.perf_counter() - begin, 3)
        record = run.write_frame(frame, density, output, record, more=more)
        if self.scenery.bodies:
            write_transforms(run, frame, self.scenery.bodies, self.placing, self.animation.output.voxel_size)
        save_state(run, frame, self.state, self.scenery.bodies, self.detail)
        return record
