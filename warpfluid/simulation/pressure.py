"""The pressure step: take from a velocity what makes it diverge (Chorin 1968; Stam 1999)."""

from dataclasses import dataclass

import numpy as np
import warp as wp

from warpfluid.kernels import checks, vectors
from warpfluid.kernels.poisson import pressure as kernels
from warpfluid.kernels.poisson import shares, walls
from warpfluid.kernels.sides import SIX
from warpfluid.simulation.poisson import EmptyBox, FilledBox
from warpfluid.simulation.state import Faces, Solids, face_shape

METHODS = ("auto", "direct", "multigrid")
PASSES = 4  # each solves for what the last left: a pressure in float32 resolves its own gradient only so far


@dataclass(frozen=True)
class Projection:
    """What a pressure step did.

    Attributes:
        method: ``direct`` or ``multigrid``.
        iterations: Solves of the direct method, or iterations of the conjugate gradients.
        before: Largest divergence there was, less what was wanted [1/s].
        residual: Largest divergence left, less what was wanted [1/s].
    """

    method: str
    iterations: int
    before: float
    residual: float

    @property
    def relative(self) -> float:
        """The share of the divergence that is left."""
        return self.residual / self.before if self.before else 0.0


def make_incompressible(
    velocity: Faces,
    sides: SIX,
    *,
    expansion: wp.array | None = None,
    solids: Solids | None = None,
    mass: wp.array | None = None,
    method: str = "auto",
    tolerance: float = 1e-4,
    pressure: wp.array | None = None,
) -> Projection:
    """Make a velocity divergence-free in place, by the gradient of a pressure.

    What cannot be had is left out: in a region without a way out, the mean of the expansion.

    Args:
        velocity: Changed [voxel/s].
        sides: What the sides of the box are.
        expansion: Divergence that is wanted, where fluid burns; shape (x, z, y) [1/s].
        solids: What stands in the fluid.
        mass: Relative mass density of each voxel, above 0, shape (x, z, y); 1 when omitted.
        method: ``direct`` (a box without solids and of one mass, on the CPU), ``multigrid`` or ``auto``.
        tolerance: Share of the largest divergence that may be left.
        pressure: The last step's, shape (x, z, y), a good guess for this one's; changed to this one's [voxel^2/s].

    Returns:
        What was done.

    Raises:
        ValueError: If arrays do not fit, the method is unknown or cannot do this, or a mass is not above 0.
        FloatingPointError: If the velocity, the expansion or the solution is not finite.
    """
    shape = _check(velocity, expansion, solids, mass, pressure)
    method = _pick(method, velocity.x.device, solids, mass)
    hold(velocity, sides, solids)
    device = velocity.x.device
    box = EmptyBox(shape, sides, device) if method == "direct" else FilledBox(shape, sides, solids, mass, device)
    excess = wp.empty(shape, dtype=float, device=device)
    left = before = _measure(velocity, expansion, solids, box, excess)
    if pressure is not None:
        box.subtract_gradient(pressure, velocity)
        left = _measure(velocity, expansion, solids, box, excess)
    iterations = 0
    for _ in range(PASSES):
        if left <= tolerance * before:
            break
        correction, count = box.solve(excess, 0.5 * tolerance * before)
        box.subtract_gradient(correction, velocity)
        if pressure is not None:
            vectors.add_scaled(pressure, 1.0, correction, out=pressure)
        iterations += count
        last, left = left, _measure(velocity, expansion, solids, box, excess)
        if left > 0.5 * last:
            break
    hold(velocity, sides, solids)
    return Projection(method, iterations, before, left)


def hold(velocity: Faces, sides: SIX, solids: Solids | None = None) -> None:
    """Give faces inside solids the solid's velocity and those on walls none; join wrapped sides, in place."""
    for axis, faces in enumerate(velocity):
        if solids is not None:
            shares.hold(faces, solids.open[axis], solids.velocity[axis])
        walls.hold_walls(faces, axis=axis, sides=sides)


def _check(velocity, expansion, solids, mass, pressure) -> tuple[int, int, int]:
    """Return the number of voxels along each axis, of arrays that fit together."""
    named = {"expansion": expansion, "mass": mass, "pressure": pressure}
    voxels = {name: array for name, array in named.items() if array is not None}
    fields = {"velocity": velocity}
    if solids is not None:
        voxels["solids.fluid"] = solids.fluid
        fields |= {"solids.open": solids.open, "solids.velocity": solids.velocity}
    faces = {f"{name}.{'xzy'[axis]}": part for name, field in fields.items() for axis, part in enumerate(field)}
    checks.same_device(**faces, **voxels)
    checks.floats(3, **faces, **voxels)
    shape = (velocity.z.shape[0], velocity.x.shape[1], velocity.x.shape[2])
    for axis in range(3):
        checks.shape(
            face_shape(shape, axis), **{f"{name}.{'xzy'[axis]}": field[axis] for name, field in fields.items()}
        )
    checks.shape(shape, **voxels)
    if mass is not None and not mass.numpy().min() > 0.0:
        raise ValueError("mass holds values that are not above 0: even air has some, such as 1 against 20")
    return shape


def _pick(method: str, device: wp.Device, solids: Solids | None, mass: wp.array | None) -> str:
    """Return the method to use."""
    if method not in METHODS:
        raise ValueError(f"method is {method!r}, expected one of {', '.join(METHODS)}")
    plain = solids is None and mass is None
    if method == "direct" and not plain:
        raise ValueError("the direct method takes neither solids nor mass: use method='multigrid' or 'auto'")
    if method == "auto":
        return "direct" if plain and not device.is_cuda else "multigrid"
    return method


def _measure(velocity: Faces, expansion: wp.array | None, solids: Solids | None, box, excess: wp.array) -> float:
    """Write the divergence less what is wanted and can be had; return its largest magnitude."""
    excess.zero_()
    for axis, faces in enumerate(velocity):
        around = {} if solids is None else {"open": solids.open[axis], "solid": solids.velocity[axis]}
        kernels.add_flux(faces, axis=axis, out=excess, **around)
    if expansion is not None and solids is not None:
        expansion = vectors.multiply(expansion, solids.fluid, out=wp.empty_like(expansion))
    if expansion is not None:
        vectors.add_scaled(excess, -1.0, expansion, out=excess)
    box.drop_impossible(excess)
    found = vectors.largest(excess)
    if not np.isfinite(found):
        raise FloatingPointError("the divergence is not finite: velocity or expansion hold infinities or NaN")
    return found
