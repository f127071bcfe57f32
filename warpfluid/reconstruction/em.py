"""The EM-like iteration: volumes that look like the inputs from every side (Section 3, Fig. 3).

Starting from least squares on the inputs alone (Eq. 3), the M-step renders the volume at a fan of angles and
transfers the appearance of the inputs to the pictures, and the E-step fits the volume to the pictures. The energy
(Eq. 1), the squared difference between rendered and modified pictures, is recorded after each half-step.
"""

import math
from collections.abc import Callable

import numpy as np
import warp as wp

from warpfluid.device import one_blas_thread, pick_device
from warpfluid.kernels import vectors
from warpfluid.kernels.blur import blur
from warpfluid.options import ReconstructOptions
from warpfluid.reconstruction.convex import SadEnergy
from warpfluid.reconstruction.inputs import Inputs, given_statistics, make_inputs
from warpfluid.reconstruction.lsm import LeastSquares
from warpfluid.reconstruction.result import Observer, Reconstruction, Step
from warpfluid.reconstruction.start import first_volume, given_start, least_squares, rough_start
from warpfluid.reconstruction.stochastic import random_walk
from warpfluid.reconstruction.systems import Modelled, model, walk_options
from warpfluid.reconstruction.transfers import make_transfer
from warpfluid.views import Views

BRIGHT = 200.0  # grey level
NEVER_SEEN = 1e-6  # keeps the share of a voxel that no ray visits at 0

Progress = Callable[[int, float], None]


@one_blas_thread()
def reconstruct(
    views: Views,
    options: ReconstructOptions | None = None,
    *,
    start: np.ndarray | None = None,
    statistics: Views | None = None,
    progress: Progress | None = None,
    observe: Observer | None = None,
    device: str | wp.Device | None = None,
) -> Reconstruction:
    """Model the volume of one frame from its views, by appearance transfer or another system (``systems``).

    Args:
        views: One or more views of the frame.
        options: Choices of the method.
        start: Volume that appearance transfer starts from, shape (x, z, y), ray sums in pixel values; by default the
            one that the options name.
        statistics: Views that say how unseen ones look, in place of the inputs: the truth's, where it is known, give
            the true histograms of Fig. 7. They may have any angles, and have the pictures' size.
        progress: Called after each iteration with its number and the energy.
        observe: Called after each iteration of appearance transfer with its pictures and the volume.
        device: Where to compute; Warp's default when omitted.

    Returns:
        The volume, the initial volume, the energies.

    Raises:
        ValueError: If the shape of the start or of the statistics differs. A frame in which nothing is lit has an empty
            volume.
    """
    options = (options or ReconstructOptions()).settled(**footage_facts(views))
    device = pick_device(device)
    inputs = make_inputs(views, options, device)
    if not (inputs.images > inputs.threshold).any():
        return _empty(views)
    if options.method != "appearance-transfer":
        return finish(views, options, inputs, model(inputs, options, progress), least_squares(inputs, options))
    initial = first_volume(inputs, options)
    if start is None:
        volume = rough_start(inputs, options, initial)
    else:
        volume = given_start(inputs, options, start * np.float32(255 / views.white))
    looks = None if statistics is None else given_statistics(statistics, views, options)
    modelled = Iteration(inputs, options, looks).run(volume, progress, observe=observe)
    return finish(views, options, inputs, modelled, initial)


def finish(
    views: Views, options: ReconstructOptions, inputs: Inputs, modelled: Modelled, initial: wp.array
) -> Reconstruction:
    """Return the result in the whole box and in the views' pixel values."""
    pixel = np.float32(views.white / 255)
    whole = inputs.whole(modelled.volume)
    if len(views.angles_deg) == 1 and options.stand_in == "measured":
        whole = _symmetric(whole, views.angles_deg[0])
    return Reconstruction(
        volume=whole * pixel,
        initial=inputs.whole(initial) * pixel,
        energies=modelled.energies,
        walk=modelled.walk,
        angles_deg=views.angles_deg,
        hull_share=float(inputs.hull.numpy().sum(dtype=np.float64) / whole.size),
        white=views.white,
    )


def footage_facts(views: Views) -> dict:
    """Return what ``ReconstructOptions.settled`` needs to know of a frame."""
    grey = views.images * (255 / views.white)
    lit = grey > 1
    bright = float((grey > BRIGHT).sum() / max(lit.sum(), 1))
    return {"views": len(grey), "width": grey.shape[1], "bright": bright}


class Iteration:
    """The alternation of both steps for one frame, with its memory.

    Args:
        inputs: What is measured, how the rest should look, and the hull.
        options: Choices of the method, all settled.
        statistics: Images and their angles that say how views look, in place of the inputs.
    """

    def __init__(
        self,
        inputs: Inputs,
        options: ReconstructOptions,
        statistics: tuple[np.ndarray, tuple[float, ...]] | None = None,
    ):
        self.inputs, self.options, self.device = inputs, options, inputs.hull.device
        measured = slice(0, inputs.measured)
        self._measured = inputs.images[measured]
        self._fan_deg, self._at = fan_angles(options.angles, inputs.angles_deg[measured])
        self._fan = inputs.projector(self._fan_deg, options.footprint)
        self._mask = self._fan.project(inputs.hull).numpy() > 0
        looks, looks_deg = (inputs.images, inputs.angles_deg) if statistics is None else statistics
        self._transfer = make_transfer(looks, looks_deg, self._fan_deg, options)
        self._weights = np.ones(len(self._fan_deg))
        self._weights[self._at] = options.input_weight
        self._walks: list[np.ndarray] = []
        self._solver = LeastSquares(self._fan, weights=self._weights, ramp=options.preconditioner == "ramp")
        self._balance = inputs.balancing(options.footprint)
        self._scratch = self._volume()
        if options.fade > 0:
            ones = wp.full(self._fan.image_shape, 1.0, dtype=float, device=self.device)
            self._share, self._seen, self._cover = self._volume(), self._volume(), self._volume()
            self._fan.backproject(ones, out=self._seen)
            blur(inputs.support, options.fade_blur, scratch=self._scratch, out=self._cover)

    def run(
        self,
        volume: wp.array,
        progress: Progress | None = None,
        *,
        fade_first: bool = False,
        observe: Observer | None = None,
    ) -> Modelled:
        """Alternate M-step and E-step.

        Args:
            volume: Where to start, over the inputs' part of the box; changed in place.
            progress: Called after each iteration with its number and the energy.
            fade_first: Fade in the first iteration too; the M-step of a rough start still sees the start's silhouette.
            observe: Called after each iteration with its pictures and the volume.

        Returns:
            The volume, and its energy after each M-step and each E-step.
        """
        energies = np.zeros((self.options.iterations, 2))
        rendered = self._fan.project(volume)
        for iteration in range(self.options.iterations):
            before = rendered.numpy().copy() if observe else None
            made = self._m_step(rendered)
            residual = wp.array(made, dtype=float, device=self.device)
            vectors.add_scaled(residual, -1.0, rendered, out=residual)
            energies[iteration, 0] = vectors.dot(residual, residual)
            self._e_step(volume, residual, made, iteration, fade=fade_first or iteration > 0)
            self._fan.project(volume, out=rendered)
            targets = wp.array(made, dtype=float, device=self.device)
            vectors.add_scaled(targets, -1.0, rendered, out=residual)
            energies[iteration, 1] = vectors.dot(residual, residual)
            if progress:
                progress(iteration + 1, energies[iteration, 1])
            if observe:
                observe(Step(iteration + 1, self._fan_deg, before, made, self.inputs.whole(volume)))
        return Modelled(volume, energies, np.concatenate(self._walks) if self._walks else np.zeros((0, 2)))

    def _m_step(self, rendered: wp.array) -> np.ndarray:
        """Modify the rendered views so that they look like the inputs, and put the inputs in."""
        made = self._transfer.transfer(rendered.numpy(), self._mask)
        if self.options.row_sums:
            total = made.sum(axis=1, keepdims=True)
            made *= np.where(total > 1e-3, self.inputs.row_sums / np.maximum(total, 1e-3), 1).astype(np.float32)
        made[self._at] = self._measured
        return made

    def _e_step(self, volume: wp.array, residual: wp.array, made: np.ndarray, iteration: int, *, fade: bool) -> None:
        """Fit the volume to the modified views, in place."""
        if self.options.e_step == "stochastic":
            self._walk(volume, made, iteration)
        else:
            self._solver.improve(volume, residual, self.options.cg_steps)
        self._mend(volume, made, fade=fade)

    def _walk(self, volume: wp.array, made: np.ndarray, iteration: int) -> None:
        """Fit the volume by random walks, in place."""
        targets = wp.array(made, dtype=float, device=self.device)
        energy = SadEnergy(self._fan, targets, self.options.sad_weight, weights=self._weights)
        voxels = float(self.inputs.support.numpy().sum(dtype=np.float64))
        told = walk_options(self.options, voxels, e_step=iteration)
        self._walks.append(random_walk(energy, volume, told).rates)

    def _mend(self, volume: wp.array, made: np.ndarray, *, fade: bool) -> None:
        """Make a fitted volume plausible, in place: nowhere negative, smooth, faded, and right where it is measured."""
        options = self.options
        if options.non_negative:
            vectors.clip(volume)
        if options.blur > 0:
            blur(volume, options.blur, scratch=self._scratch, out=volume)
            vectors.multiply(volume, self.inputs.support, out=volume)
        if options.fade > 0 and fade:
            self._fade(volume, made)
        if options.slice_rescale:
            self._rescale_slices(volume)
        if options.non_negative:  # a factor cannot mend what is of either sign
            self._balance.apply(volume, options.balance, power=options.balance_power)

    def _fade(self, volume: wp.array, made: np.ndarray) -> None:
        """Fade voxels that most views show as black: the corners of the hull and the outlines they leave."""
        black = made <= self.inputs.black
        black[self._at] = self._measured <= self.inputs.threshold
        share = self._share
        self._fan.backproject(wp.array(black, dtype=float, device=self.device), out=share)
        vectors.divide(share, self._seen, floor=NEVER_SEEN, out=share)
        blur(share, self.options.fade_blur, scratch=self._scratch, out=share)
        vectors.fade(volume, share, self._cover, limit=self.options.fade)

    def _rescale_slices(self, volume: wp.array) -> None:
        """Give every horizontal slice the light of its row in the inputs."""
        total = volume.numpy().sum(axis=(0, 1), dtype=np.float64)
        factor = np.where(total > 1e-6, self.inputs.row_sums / np.maximum(total, 1e-6), 0).astype(np.float32)
        scale = wp.array(np.broadcast_to(factor, volume.shape), dtype=float, device=self.device)
        vectors.multiply(volume, scale, out=volume)

    def _volume(self) -> wp.array:
        return wp.empty(self._fan.shape, dtype=float, device=self.device)


def fan_angles(count: int, measured_deg: tuple[float, ...]) -> tuple[tuple[float, ...], list[int]]:
    """Spread angles over half a turn so that the measured ones are among them.

    Args:
        count: Number of angles.
        measured_deg: Measured angles in [0, 180).

    Returns:
        The angles, ascending, and where the measured ones are. The nearest angle moves onto a measured one; where
        measured angles are closer than the spacing, angles are added.
    """
    fan = list(np.arange(count) * 180.0 / count)
    taken: dict[int, float] = {}
    for angle in measured_deg:
        distance = [math.inf if i in taken else abs((a - angle + 90) % 180 - 90) for i, a in enumerate(fan)]
        nearest = int(np.argmin(distance))
        if distance[nearest] <= 90.0 / count + 1e-9:
            taken[nearest] = fan[nearest] = angle
        else:
            taken[len(fan)] = angle
            fan.append(angle)
    ordered = sorted(fan)
    return tuple(float(a) for a in ordered), [ordered.index(angle) for angle in measured_deg]


def _symmetric(volume: np.ndarray, angle_deg: float) -> np.ndarray:
    """Make a volume from one view given twice exactly symmetric: rounding alone made it differ."""
    if angle_deg % 90:
        return volume
    mirrored = volume.transpose(1, 0, 2)
    if angle_deg % 180:
        mirrored = mirrored[::-1, ::-1]
    return np.float32(0.5) * (volume + mirrored)


def _empty(views: Views) -> Reconstruction:
    """Return the empty volume of a frame in which nothing is lit."""
    _, width, height = views.images.shape
    nothing = np.zeros((width, width, height), np.float32)
    return Reconstruction(nothing, nothing, np.zeros((0, 2)), views.angles_deg, 0.0, views.white)
