"""What fills a volume, as light meets it: what glows, what hides, what scatters."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import warp as wp


@dataclass(frozen=True)
class Curve:
    """An optical property as a function of a field, linear between its entries.

    Attributes:
        field: Which field it reads, a name in ``Medium.fields``: density, temperature, flame, speed.
        top: Field value of the last entry; the first stands at 0, the others evenly between; constant beyond.
        values: Entries, shape (n,), or (n, 3) for red, green and blue; one entry is a constant.
        times: A field that the entry is multiplied by, so that a colour by temperature can glow by density.

    Raises:
        ValueError: If an entry is negative or not finite, or the shape or top makes no sense.
    """

    field: str
    top: float
    values: np.ndarray
    times: str | None = None

    def __post_init__(self):
        values = np.asarray(self.values, np.float32)
        if values.ndim not in (1, 2) or not values.size or values.shape[1:] not in ((), (3,)):
            raise ValueError(
                f"values of the curve over {self.field} have shape {values.shape}, expected (n,) or (n, 3)"
            )
        if not (np.isfinite(values).all() and values.min() >= 0):
            raise ValueError(f"values of the curve over {self.field} are from {values.min()} to {values.max()}: "
                             "they must be finite and not negative")  # fmt: skip
        if not (np.isfinite(self.top) and self.top > 0):
            raise ValueError(f"top of the curve over {self.field} is {self.top}, expected a positive number")
        object.__setattr__(self, "values", values)

    def at(self, field: np.ndarray) -> np.ndarray:
        """Return the entries at field values, without ``times``: shape of ``field``, and (3,) for colours."""
        place = np.clip(np.asarray(field, np.float64) / self.top, 0, 1) * (len(self.values) - 1)
        low = np.minimum(place.astype(int), max(len(self.values) - 2, 0))
        share = (place - low).reshape(place.shape + (1,) * (self.values.ndim - 1))
        return self.values[low] * (1 - share) + self.values[np.minimum(low + 1, len(self.values) - 1)] * share


@dataclass(frozen=True, kw_only=True)
class Medium:
    """Fields and what they do to light.

    Attributes:
        fields: Volumes by name, shape (x, z, y), float32, all on one device.
        emission: Light given off a voxel's length [radiance/voxel], entries (n,) or (n, 3); None for none.
        extinction: Share of light lost a voxel's length [1/voxel], entries (n,); None for none.
        albedo: Share of the lost light that is scattered, 0 to 1, entries (n,) or (n, 3); None for none.
        anisotropy: g of Henyey and Greenstein's phase function, -1 to 1; above 0 scatters forward.
        edge_fade: Over how many voxels emission and extinction rise from the box's sides; 0 for not at all.

    Raises:
        ValueError: If a curve names no field, shapes differ, or a number is out of range.
    """

    fields: Mapping[str, wp.array]
    emission: Curve | None = None
    extinction: Curve | None = None
    albedo: Curve | None = None
    anisotropy: float = 0.0
    edge_fade: float = 0.0

    def __post_init__(self):
        if not self.fields:
            raise ValueError("fields is empty; a medium needs at least one")
        shapes = {name: tuple(field.shape) for name, field in self.fields.items()}
        if len(set(shapes.values())) > 1 or len(self.shape) != 3:
            raise ValueError(f"fields have the shapes {shapes}, expected one shape (x, z, y)")
        for name in ("emission", "extinction", "albedo"):
            self._check_curve(name, getattr(self, name))
        if not -1 < self.anisotropy < 1:
            raise ValueError(f"anisotropy is {self.anisotropy}, expected a number between -1 and 1")
        if not 0 <= self.edge_fade < np.inf:
            raise ValueError(f"edge_fade is {self.edge_fade}, expected a number of voxels, 0 or more")

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the fields (x, z, y)."""
        return tuple(next(iter(self.fields.values())).shape)

    def _check_curve(self, name: str, curve: Curve | None) -> None:
        """Refuse a curve that reads a field that is not there, or has entries of a wrong kind."""
        if curve is None:
            return
        for field in {curve.field, curve.times or curve.field} - set(self.fields):
            raise ValueError(f"{name} reads the field {field!r}; there are {', '.join(self.fields)}")
        if name == "extinction" and curve.values.ndim != 1:
            raise ValueError(f"extinction has entries of shape {curve.values.shape}, expected one number each")
        if name == "albedo" and curve.values.max() > 1:
            raise ValueError(f"albedo reaches {curve.values.max()}, expected at most 1")
