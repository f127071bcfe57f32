"""The numbers of a simulation as they are at a frame."""

from dataclasses import dataclass

from warpfluid.kernels.sides import SIX
from warpfluid.options import SimulateOptions
from warpfluid.options.keys import Keyed, Ramp, is_ramp
from warpfluid.simulation.placing import Placing


@dataclass(frozen=True)
class Physics:
    """What a solver works with.

    Attributes:
        options: Its choices.
        placing: Its lattice.
        sides: What the sides of the box are.
    """

    options: SimulateOptions
    placing: Placing
    sides: SIX

    def number(self, name: str, frame: float) -> float:
        """Return an option's value at a frame; of a ramp over a field its greatest one."""
        value = getattr(self.options, name)
        return float(Ramp(value).values.max()) if is_ramp(value) else Keyed(value).at(frame)
