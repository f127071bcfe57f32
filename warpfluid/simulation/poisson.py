"""Which equation the pressure obeys: that of an empty box, or one with solids or fluids of different mass."""

import weakref

import warp as wp

from warpfluid.kernels import vectors
from warpfluid.kernels.poisson import pressure as kernels
from warpfluid.kernels.poisson import squeeze, walls
from warpfluid.kernels.sides import OPEN, SIX
from warpfluid.simulation import spectral
from warpfluid.simulation.multigrid import Multigrid
from warpfluid.simulation.regions import Regions, remove_mean
from warpfluid.simulation.state import Faces, Solids

STANDING = weakref.WeakKeyDictionary()  # what was worked out of solids, for the steps in which they stay as they are


class EmptyBox:
    """One fluid fills the box."""

    def __init__(self, shape: tuple[int, int, int], sides: SIX, device: wp.Device):
        """Set memory aside."""
        self.sides, self.scratch = sides, wp.empty(shape, dtype=float, device=device)

    def drop_impossible(self, excess: wp.array) -> None:
        """Take away what no pressure can change: the mean, where all sides are shut."""
        if OPEN not in list(self.sides):
            remove_mean(excess)

    def solve(self, excess: wp.array, target: float) -> tuple[wp.array, int]:
        """Return the pressure whose Laplacian is given, and that it took one solve; overwrites its argument."""
        return spectral.solve(excess, self.sides, self.scratch), 1

    def subtract_gradient(self, pressure: wp.array, velocity: Faces) -> None:
        """Take the gradient of a pressure from a velocity, in place."""
        for axis, faces in enumerate(velocity):
            kernels.subtract_gradient(pressure, axis=axis, sides=self.sides, velocity=faces)


class FilledBox:
    """Solids stand in the box, or its fluids differ in mass."""

    def __init__(self, shape, sides: SIX, solids: Solids | None, mass: wp.array | None, device: wp.Device):
        """Work out the coefficients of all grids and which regions have no way out."""
        self.sides, self.open = sides, None if solids is None else solids.open
        standing = {} if solids is None else STANDING.setdefault(solids, {})
        key = tuple(sides)
        if solids is not None and key not in standing:
            standing[key] = Regions(solids.open, sides)
            standing[key, "squeeze"] = _squeeze(shape, sides, solids)
        self.regions, self.squeeze = standing.get(key), standing.get((key, "squeeze"))
        if solids is None or mass is not None:
            self.multigrid = Multigrid(shape, sides, open=self.open, mass=mass, device=device)
        else:
            if (key, "grids") not in standing:
                standing[key, "grids"] = Multigrid(shape, sides, open=self.open, device=device)
            self.multigrid = standing[key, "grids"]

    def drop_impossible(self, excess: wp.array) -> None:
        """Take away what no pressure can change.

        All of it inside solids, what they press out where there is no room, and the mean where there is no way out.
        """
        if self.squeeze is not None:
            vectors.add_scaled(excess, -1.0, self.squeeze, out=excess)
        if self.regions is not None:
            walls.clear_solid(self.multigrid.levels[0].first_step, out=excess)
            self.regions.remove_means(excess)
        elif OPEN not in list(self.sides):
            remove_mean(excess)

    def solve(self, excess: wp.array, target: float) -> tuple[wp.array, int]:
        """Return the pressure that flattens an excess to a target, and the iterations; overwrites the excess."""
        return self.multigrid.solve(excess, target)

    def subtract_gradient(self, pressure: wp.array, velocity: Faces) -> None:
        """Take the gradient of a pressure, over the mass, from a velocity, in place."""
        for axis, (faces, coefficient) in enumerate(zip(velocity, self.multigrid.levels[0].coefficient, strict=True)):
            open = None if self.open is None else self.open[axis]
            arguments = {"coefficient": coefficient, "open": open, "velocity": faces}
            kernels.subtract_gradient(pressure, axis=axis, sides=self.sides, **arguments)


def _squeeze(shape: tuple[int, int, int], sides: SIX, solids: Solids) -> wp.array | None:
    """Return what ``squeeze.measure_squeeze`` writes, None where nothing moves."""
    if not any(vectors.largest(part) for part in solids.velocity):
        return None
    out = wp.empty(shape, dtype=float, device=solids.fluid.device)
    parts = {"open": solids.open, "solid": solids.velocity}
    faces = {f"{name}_{axis}": getattr(part, axis) for name, part in parts.items() for axis in "xzy"}
    return squeeze.measure_squeeze(**faces, fluid=solids.fluid, sides=sides, out=out)
