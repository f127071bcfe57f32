"""What a reconstruction returns."""

import base64
import io
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from warpfluid.projector import Projector

SHOWN_DEG = (0, 30, 60, 90)


@dataclass(frozen=True, eq=False)
class Step:
    """One iteration of appearance transfer (Fig. 3), in grey levels.

    Attributes:
        iteration: Its number, from 1.
        angles_deg: Angles of the views that appearance is transferred to.
        rendered: The volume before it, seen from there, shape (angle, u, v).
        made: What the M-step made of these views, the same shape.
        volume: What the E-step fitted to that, shape (x, z, y).
    """

    iteration: int
    angles_deg: tuple[float, ...]
    rendered: np.ndarray
    made: np.ndarray
    volume: np.ndarray


Observer = Callable[[Step], None]


@dataclass(frozen=True, eq=False)
class Reconstruction:
    """A volume and how it came about.

    Attributes:
        volume: Density, shape (x, z, y); its ray sums are pixel values of linear light.
        initial: The volume of least squares alone (Eq. 3), for comparison, or what the options name as start.
        energies: Eq. 1 after the M-step and after the E-step of every iteration; the energy of stochastic tomography
            before and after each round of its solvers. Shape (iteration, 2).
        angles_deg: Angles of the measured views.
        hull_share: Part of the box that the visual hull fills.
        white: Pixel value of white.
        walk: Share of the applied proposals and quantum [grey level] of each sweep of a random walk, shape (sweep, 2).
    """

    volume: np.ndarray
    initial: np.ndarray
    energies: np.ndarray
    angles_deg: tuple[float, ...]
    hull_share: float
    white: float = 255.0
    walk: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))

    @property
    def density(self) -> np.ndarray:
        """The volume in the order that files have, (x, y, z)."""
        return self.volume.transpose(0, 2, 1)

    def render(self, angles_deg) -> np.ndarray:
        """Render the volume at some angles; ray sums, shape (angle, u, v)."""
        return Projector(angles_deg, self.volume.shape, device="cpu").project(self.volume)

    def __repr__(self) -> str:
        x, z, y = self.volume.shape
        falls = f"{self.energies[0, 0]:.3g} -> {self.energies[-1, -1]:.3g}" if len(self.energies) else "none"
        return f"Reconstruction({x} x {y} x {z} voxels, hull {self.hull_share:.0%}, energy {falls})"

    def _repr_html_(self) -> str:
        """Show a notebook the volume from a few sides."""
        from PIL import Image

        pictures = np.concatenate([view.T[::-1] for view in self.render(SHOWN_DEG)], axis=1)
        grey = np.clip(pictures * (255 / self.white), 0, 255).astype(np.uint8)
        file = io.BytesIO()
        Image.fromarray(grey).save(file, "PNG")
        data = base64.b64encode(file.getvalue()).decode()
        angles = ", ".join(f"{angle}°" for angle in SHOWN_DEG)
        return f'<p>{self!r}</p><img alt="{angles}" src="data:image/png;base64,{data}"><p>{angles}</p>'
