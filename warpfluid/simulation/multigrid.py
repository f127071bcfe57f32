"""The Poisson equation around solids and of fluids of different mass: conjugate gradients, multigrid inside.

One multigrid cycle (Brandt 1977) is a good guess at the pressure that belongs to a divergence; the conjugate
gradients make it right however thin or crooked the solids are (Tatebe 1993; McAdams, Sifakis and Teran 2010). The
cycle is symmetric, as they need it: relaxation is a polynomial of the matrix, refining is coarsening transposed.
"""

import functools

import numpy as np
import warp as wp

from warpfluid.kernels import vectors
from warpfluid.kernels.poisson import coefficients
from warpfluid.kernels.poisson import multigrid as kernels
from warpfluid.kernels.sides import CLOSED, OPEN, SIX, WRAP
from warpfluid.simulation.state import Faces, face_shape

MOST_ITERATIONS = 100
COARSEST = 2  # voxels along an axis


def chebyshev_steps(lowest: float, count: int) -> list[float]:
    """Return weights of Jacobi steps that together damp all eigenvalues from ``lowest`` to 2, the largest there is."""
    middle, half = (2.0 + lowest) / 2, (2.0 - lowest) / 2
    return [1.0 / (middle - half * np.cos(np.pi * (k + 0.5) / count)) for k in range(count)][::-1]


RELAXATION = chebyshev_steps(1 / 3, 2)  # 1 / 3 is the smoothest wave that the next grid cannot hold
SOLUTION = chebyshev_steps(0.1, 6)


@functools.lru_cache(maxsize=64)
def transfer(n: int, low: int, high: int, device: str) -> tuple[tuple[wp.array, wp.array], tuple[wp.array, wp.array]]:
    """Return how one axis is made finer and coarser: voxels to take and their weights, for ``kernels.combine``.

    Finer is linear interpolation between the centres of the coarse voxels, coarser its transpose.
    """
    coarse = (n + 1) // 2
    finer = np.zeros((n, coarse))
    for i in range(n):
        there = i // 2 + (1 if i % 2 else -1)
        side = low if there < 0 else high
        finer[i, i // 2] += 0.75
        if 0 <= there < coarse or side == WRAP:
            finer[i, there % coarse] += 0.25
        else:
            finer[i, i // 2] += {OPEN: -0.25, CLOSED: 0.25}[side]
    return _taps(finer, device), _taps(finer.T, device)


def _taps(matrix: np.ndarray, device: str) -> tuple[wp.array, wp.array]:
    """Return the columns and values of what is not zero in each row, as many for each."""
    count = max((matrix != 0).sum(axis=1).max(), 1)
    order = np.argsort(matrix == 0, axis=1, kind="stable")[:, :count]
    values = np.take_along_axis(matrix, order, axis=1)
    return wp.array(order, dtype=int, device=device), wp.array(values, dtype=float, device=device)


class Level:
    """One grid of the staircase.

    A voxel that solids nearly fill, or that is heavy, pulls little weight when its neighbours are interpolated: the
    weights of ``transfer`` are multiplied by the root of the voxels' total coefficients and brought to total 1 again.
    """

    def __init__(self, coefficient: Faces, sides: SIX):
        """Work out what is needed again and again; ``coefficient`` is that of ``coefficients.face_coefficient``."""
        self.coefficient, self.sides = coefficient, sides
        self.shape = (coefficient.z.shape[0], coefficient.x.shape[1], coefficient.x.shape[2])
        self.device = coefficient.x.device
        self.scratch = self.volume()
        ones = wp.ones(self.shape, dtype=float, device=self.device)
        self.first_step = self.apply(wp.zeros_like(ones), right=ones, step=RELAXATION[0], out=self.volume())

    def volume(self, shape: tuple[int, ...] | None = None) -> wp.array:
        """Return memory for a field."""
        return wp.empty(shape or self.shape, dtype=float, device=self.device)

    def apply(self, field: wp.array, **arguments) -> wp.array:
        """Call ``kernels.apply`` on this grid."""
        return kernels.apply(field, *self.coefficient, sides=self.sides, **arguments)

    def relax(self, right: wp.array, solution: wp.array, steps: list[float]) -> None:
        """Take an even number of Jacobi steps."""
        a, b = solution, self.scratch
        for step in steps:
            self.apply(a, right=right, step=step, out=b)
            a, b = b, a

    def add_coarser(self) -> "Level":
        """Return the grid of half as many voxels along each axis."""
        halved = tuple((n + 1) // 2 for n in self.shape)
        coefficient = Faces.zeros(halved, self.device)
        for axis, out in enumerate(coefficient):
            coefficients.coarsen_coefficient(self.coefficient[axis], axis=axis, sides=self.sides, out=out)
        coarser = Level(coefficient, self.sides)
        axes = [(n, int(self.sides[2 * axis]), int(self.sides[2 * axis + 1])) for axis, n in enumerate(self.shape)]
        self.transfers = [transfer(*axis, str(self.device)) for axis in axes]
        coarser.right, coarser.solution = coarser.volume(), coarser.volume()
        coarser.weight = vectors.inverse_root(coarser.first_step, out=coarser.volume())
        ones = wp.ones(self.shape, dtype=float, device=self.device)
        whole, weighted = wp.zeros_like(ones), wp.zeros_like(ones)
        self._interpolate(wp.ones(halved, dtype=float, device=self.device), ones, whole)
        self._interpolate(coarser.weight, ones, weighted)
        self.scale = vectors.divide(whole, weighted, floor=1e-6, out=whole)
        return coarser

    def restrict(self, solution: wp.array, right: wp.array, coarser: "Level") -> None:
        """Carry what a solution leaves to the right side of the next grid."""
        field = self.apply(solution, right=right, scale=self.scale, out=self.scratch)
        for axis in (2, 1, 0):
            out = coarser.right if axis == 0 else self.volume(field.shape[:axis] + coarser.shape[axis:])
            field = kernels.combine(field, *self.transfers[axis][1], axis=axis, out=out)
        vectors.multiply(field, coarser.weight, out=field)

    def prolong(self, coarser: "Level", solution: wp.array) -> None:
        """Add the correction that was found on the next grid."""
        field = vectors.multiply(coarser.solution, coarser.weight, out=coarser.solution)
        self._interpolate(field, self.scale, solution)

    def _interpolate(self, field: wp.array, scale: wp.array, out: wp.array) -> None:
        """Add a coarse field, interpolated and scaled."""
        for axis in (0, 1, 2):
            arguments = {"scale": scale, "out": out}
            if axis < 2:
                arguments = {"out": self.volume(self.shape[: axis + 1] + field.shape[axis + 1 :])}
            field = kernels.combine(field, *self.transfers[axis][0], axis=axis, **arguments)


class Multigrid:
    """A Poisson equation, with what its solution needs."""

    def __init__(self, shape, sides: SIX, *, open: Faces | None = None, mass: wp.array | None = None, device=None):
        """Work the coefficients of all grids out.

        Args:
            shape: Voxels along x, z and y.
            sides: What the sides of the box are.
            open: Share of each face that is fluid; 1 when omitted.
            mass: Relative mass density of each voxel; 1 when omitted.
            device: Where the arrays are.
        """
        coefficient = Faces(*(wp.empty(face_shape(shape, axis), dtype=float, device=device) for axis in range(3)))
        for axis, out in enumerate(coefficient):
            share = None if open is None else open[axis]
            coefficients.face_coefficient(axis=axis, sides=sides, open=share, mass=mass, out=out)
        self.levels = [Level(coefficient, sides)]
        while max(self.levels[-1].shape) > COARSEST:
            self.levels.append(self.levels[-1].add_coarser())

    def cycle(self, right: wp.array, out: wp.array, depth: int = 0) -> wp.array:
        """Write a guess at the solution: one V-cycle from zero."""
        level = self.levels[depth]
        vectors.multiply(right, level.first_step, out=level.scratch)
        level.apply(level.scratch, right=right, step=RELAXATION[1], out=out)
        if depth == len(self.levels) - 1:
            level.relax(right, out, SOLUTION)
            return out
        below = self.levels[depth + 1]
        level.restrict(out, right, below)
        self.cycle(below.right, below.solution, depth + 1)
        level.prolong(below, out)
        level.relax(right, out, RELAXATION)
        return out

    def solve(self, right: wp.array, target: float) -> tuple[wp.array, int]:
        """Find the p whose Laplacian, -A p, is given: preconditioned conjugate gradients (Hestenes and Stiefel 1952).

        Args:
            right: b of -A p = b, shape (x, z, y); overwritten by what is left.
            target: Largest magnitude that may be left.

        Returns:
            p and the number of iterations.

        Raises:
            FloatingPointError: If the solution is not finite.
        """
        finest = self.levels[0]
        solution, guess, image = wp.zeros_like(right), finest.volume(), finest.volume()
        direction, size = wp.zeros_like(right), 1.0
        for iteration in range(MOST_ITERATIONS):
            if vectors.largest(right) <= target:
                return solution, iteration
            self.cycle(right, guess)
            last, size = size, vectors.dot(right, guess)
            vectors.add_scaled(guess, size / last, direction, out=direction)
            finest.apply(direction, out=image)
            steepness = vectors.dot(direction, image)
            if not np.isfinite(steepness):
                raise FloatingPointError(
                    "the pressure is not finite: look for extreme velocities, masses or expansions"
                )
            if steepness <= 0.0:
                return solution, iteration
            vectors.add_scaled(solution, -size / steepness, direction, out=solution)
            vectors.add_scaled(right, -size / steepness, image, out=right)
        return solution, MOST_ITERATIONS
