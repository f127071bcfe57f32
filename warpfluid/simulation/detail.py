"""Frames finer than the simulation (wavelet turbulence: Kim, Thuerey, James and Gross 2008).

The simulation stays as it is. For the files its fields are read on a finer grid, from where eddies of sizes that the
coarse grid damps or cannot hold have taken them. These are as strong as the smallest eddies that it holds, they are
carried along by the fluid, and what a few coarse voxels have in all, they only share out anew.

A pattern that is carried along is torn after a while. So there are two, each of which starts anew when it is faintest
(advected textures: Neyret 2003).
"""

import functools
import math
from collections.abc import Mapping

import numpy as np
import warp as wp

from warpfluid.kernels import vectors
from warpfluid.kernels.blur import blur
from warpfluid.kernels.coarsen import coarsen, refine
from warpfluid.kernels.fluid import fine_paths
from warpfluid.kernels.fluid.centres import to_centres
from warpfluid.kernels.fluid.totals import scale, total
from warpfluid.kernels.fluid.tracing import CENTRE, trace
from warpfluid.kernels.fluid.transport import carry
from warpfluid.kernels.forces import eddies
from warpfluid.kernels.forces.lattice import interpolate
from warpfluid.kernels.forces.random_waves import NODES_A_WAVE, TILE, curl_size, draw_tiles, make_waves
from warpfluid.kernels.sides import SIX
from warpfluid.simulation.fields import mark_fluid
from warpfluid.simulation.state import CELLS, Faces, FluidState
from warpfluid.simulation.written import Fields

FINEST = 0.25  # [cycle/voxel] that a grid resolves; the new eddies lie between the coarse grid's and the fine one's
FIRST = FINEST / math.sqrt(2)  # middle of the first octave: a grid damps the finest eddies that it resolves
FADE = 0.5  # how far an octave carries, as a part of the one before
BAND = 1.0  # [voxel] standard deviation of the blur that leaves all but the finest eddies of a grid
SMOOTH = 1.5  # [voxel] the same of the one that makes their speed even
SECONDS = 0.25  # how long the new eddies carry density
LIMIT = 2.5  # [voxel] that they carry it at most
THIN = 0.02  # of full density; where there is less, eddies fade
FAINT = 0.02  # part of that, at which they are gone
FINER = 2  # nodes of a tile between those of the waves, which are joined by splines: linear steps are then small
STEPS = 4  # of a path through them
NEARLY_0 = 1e-3  # [cycle/voxel] differences of so long waves are slopes
CALM = 3.0  # [voxel] standard deviation of the blur of the velocity that carries the patterns
WEAR = 0.8  # strain after which a pattern is worn
SHORTEST, LONGEST = 0.25, 2.0  # [s] that it lives
KEPT = 1.5  # [voxel] standard deviation of the blur that shows what is kept of the coarse fields
SWEEPS, CAP = 3, 4.0  # of keeping it
AMOUNTS = ("density", "fuel", "flame")  # fields of which a voxel has an amount
SUMMED = ("density", "fuel")  # and those whose unit is that of a ray's sum
MOST = 2**31  # voxels that kernels can count


class Detail:
    """The patterns of fine eddies that a fluid carries along.

    Args:
        factor: Fine voxels in a coarse one, along each axis.
        shape: Coarse voxels (x, z, y).
        sides: What the sides of the box are.
        seed: Of the patterns.
        device: Where to compute.

    Raises:
        ValueError: If the finer grid has too many voxels.
    """

    def __init__(self, factor: int, shape: tuple[int, int, int], sides: SIX, seed: int, device: wp.Device):
        if factor**3 * math.prod(shape) >= MOST:
            found = f"detail {factor} of {shape[0]} x {shape[2]} x {shape[1]} voxels"
            raise ValueError(f"{found} makes more than 2^31: lower --detail, --size or --resolution-scale")
        self.factor, self._sides, self._seed, self._device = factor, sides, seed, device
        self._phase = 0.0  # lives of the first pattern; the second is half a life older
        self._away = [[wp.zeros(shape, dtype=float, device=device) for _ in range(3)] for _ in range(2)]

    def state(self) -> dict[str, np.ndarray]:
        """Return everything that changes, by name."""
        fields = {f"{k}{axis}": field.numpy() for k, away in enumerate(self._away) for axis, field in enumerate(away)}
        return {"phase": np.array(self._phase, np.float64), **fields}

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Take back what ``state`` returned."""
        self._phase = float(values["phase"])
        for k, away in enumerate(self._away):
            for axis, field in enumerate(away):
                field.assign(values[f"{k}{axis}"])

    def advance(self, state: FluidState, seconds: float, reference: float) -> None:
        """Let the fluid carry the patterns along, and start anew the one whose life is over."""
        calm = Faces(*(blur(part, CALM) for part in state.velocity))
        strain = mean_strain(calm, state.density.numpy() > THIN * reference)
        life = min(max(WEAR / max(strain, 1e-9), SHORTEST), LONGEST)
        lives = [math.floor(self._phase + k / 2) for k in range(2)]
        self._phase += min(seconds / life, 0.5)
        path = trace(*calm, self._sides, place=CENTRE, time_step=-seconds)
        gone = [wp.array(part, dtype=float, device=self._device) for part in _way(path.numpy())]
        for k, away in enumerate(self._away):
            fresh = math.floor(self._phase + k / 2) > lives[k]
            for axis, field in enumerate(away):
                if fresh:
                    field.zero_()
                else:
                    moved = carry(field, path, self._sides, place=CENTRE)
                    vectors.add_scaled(moved, 1.0, gone[axis], out=field)

    def refine(self, state: FluidState, reference: float, *, strength: float) -> Fields:
        """Return a frame on the finer grid; its rays have the sums that they had.

        Args:
            state: The fluid.
            reference: Full density.
            strength: How far the eddies carry, in parts of the usual; at 0 the frame is interpolated.
        """
        cover = mark_fluid(state, THIN * reference)
        blur(cover, 1.0, out=cover)
        fine = tuple(self.factor * n for n in cover.shape)
        flow, path = (wp.zeros(fine, dtype=wp.vec3, device=self._device) for _ in range(2))
        if strength > 0:
            self._draw(path, self._reach(state, cover, strength))
            eddies.curl(path, scale=0.5 * self.factor**2, out=flow)
        fine_paths.follow_back(flow, steps=STEPS, out=path)
        scratch = wp.empty(fine, dtype=float, device=self._device)
        cells = {name: self._read(getattr(state, name), path, cover, scratch, name in AMOUNTS) for name in CELLS}
        for name in SUMMED:
            cells[name] /= np.float32(self.factor)
        parts = (to_centres(part, axis=axis) for axis, part in enumerate(state.velocity))
        fine_parts = (refine(part, factor=self.factor, out=scratch).numpy() for part in parts)
        return Fields(cells, [part * np.float32(self.factor) for part in fine_parts])

    def _read(self, field: wp.array, path: wp.array, cover: wp.array, scratch: wp.array, keeps: bool) -> np.ndarray:
        """Return a field on the finer grid, with the means of the coarse one if it keeps them."""
        made = wp.zeros_like(scratch)
        if vectors.largest(field):
            fine_paths.sample(field, path, factor=self.factor, cover=cover, out=made)
            if keeps:
                keep_means(made, field, factor=self.factor, scratch=scratch)
        return made.numpy()

    def _draw(self, potential: wp.array, reach: wp.array) -> None:
        """Add the potential of both patterns, as old as they are."""
        tile, size = _draw_tile(self._seed, str(self._device))
        for octave, frequency in enumerate(_octaves(self.factor)):
            for k, away in enumerate(self._away):
                life, age = divmod(self._phase + k / 2, 1.0)
                draw = np.random.default_rng([self._seed, octave, k, int(life)])
                eddies.lay_tile(
                    tile,
                    reach,
                    *away,
                    offset=tuple(draw.uniform(0, FINER * TILE, 3)),
                    nodes_a_voxel=FINER * NODES_A_WAVE * frequency,
                    gain=math.sin(math.pi * age) * FADE**octave / (size * frequency),
                    factor=self.factor,
                    out=potential,
                )

    def _reach(self, state: FluidState, cover: wp.array, strength: float) -> wp.array:
        """Return how far the largest of the new eddies carry, from the speed of the finest old ones [voxel]."""
        squares = wp.zeros_like(cover)
        for axis, part in enumerate(state.velocity):
            speed = to_centres(part, axis=axis)
            vectors.add_scaled(speed, -1.0, blur(speed, BAND), out=speed)
            vectors.add_scaled(squares, 1.0, vectors.multiply(speed, speed, out=speed), out=squares)
        blur(squares, SMOOTH, out=squares)
        return eddies.limit_reach(
            squares, cover, faint=FAINT, gain=SECONDS * strength, limit=LIMIT * max(strength, 1.0), out=squares
        )


def keep_means(fine: wp.array, coarse: wp.array, *, factor: int, scratch: wp.array) -> None:
    """Make the means of a fine field over a few coarse voxels those of a coarse field, and the mean of all, in place.

    Args:
        fine: Not negative, shape (x, z, y).
        coarse: What it is made of, shape (x, z, y).
        factor: Fine voxels in a coarse one, along each axis.
        scratch: Memory of the shape of ``fine``.
    """
    floor = 1e-6 * vectors.largest(coarse)
    wanted = blur(coarse, KEPT)
    for _ in range(SWEEPS):
        means = coarsen(fine, factor=factor)
        vectors.ratio(wanted, blur(means, KEPT, out=means), floor=floor, cap=CAP, power=1.0, out=means)
        vectors.multiply(fine, refine(means, factor=factor, out=scratch), out=fine)
    scale(fine, factor**3 * total(coarse) / max(total(fine), 1e-30))


def mean_strain(velocity: Faces, where: np.ndarray) -> float:
    """Return how quickly a smooth velocity deforms what is somewhere, root mean square [1/s].

    Args:
        velocity: [voxel/s].
        where: Which voxels count, bool, shape (x, z, y).
    """
    coarse = where[::2, ::2, ::2]
    if not coarse.any():
        return 0.0
    slopes = [
        np.gradient(to_centres(part, axis=axis).numpy()[::2, ::2, ::2], 2.0) for axis, part in enumerate(velocity)
    ]
    squares = sum(((slopes[a][b] + slopes[b][a]) / 2) ** 2 for a in range(3) for b in range(3))
    return float(np.sqrt(squares[coarse].mean(dtype=np.float64)))


def _way(path: np.ndarray) -> list[np.ndarray]:
    """Return how far paths back lead, along each axis."""
    ends = [path[axis] for axis in range(3)]
    return [grid - end for grid, end in zip(np.indices(ends[0].shape, np.float32, sparse=True), ends, strict=True)]


def _octaves(factor: int) -> list[float]:
    """Return the frequencies of the new eddies [cycle/coarse voxel]."""
    return [FIRST * 2**octave for octave in range(4) if FIRST * 2**octave <= FINEST * factor]


@functools.lru_cache(maxsize=2)
def _draw_tile(seed: int, device: str) -> tuple[wp.array, float]:
    """Return one period of random waves, and the size of their curl times their length."""
    waves = make_waves((TILE,) * 3, (1.0,) * 3, seed, 0)
    parts = []
    for nodes in draw_tiles((TILE,) * 3, waves, 0.0):
        fine = wp.zeros((FINER * TILE,) * 3, dtype=float, device=device)
        coefficients = wp.array(nodes, dtype=float, device=device)
        parts.append(interpolate(coefficients, first=(0.0,) * 3, spacing=(FINER,) * 3, gain=1.0, out=fine).numpy())
    return wp.array(np.stack(parts, -1), dtype=wp.vec3, device=device), curl_size(waves, NEARLY_0) / NEARLY_0
