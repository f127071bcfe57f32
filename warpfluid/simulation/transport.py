"""Let the velocity carry what the fluid holds, and itself (Stam 1999).

Four schemes, from the softest to the sharpest: "semi-lagrangian" interpolates linearly, "bfecc" and "maccormack" make
good the error of that, "cubic" interpolates with a spline. None makes values that were not around the source before.
Where the fluid is at rest, all but "cubic", which rounds, return the same values.
"""

from collections.abc import Sequence

import warp as wp

from warpfluid.kernels import spline, transport
from warpfluid.kernels.sides import SIX
from warpfluid.kernels.tracing import CENTRE, trace
from warpfluid.simulation.state import Faces

SCHEMES = ("semi-lagrangian", "maccormack", "bfecc", "cubic")


def advect_scalar(
    field: wp.array,
    velocity: Faces,
    sides: SIX,
    time_step: float,
    *,
    scheme: str,
    out: wp.array | None = None,
) -> wp.array:
    """Carry a field in the voxels' centres along the velocity for one time step.

    Args:
        field: Shape (x, z, y).
        velocity: [voxel/s].
        sides: What the six sides are: 0 enters through open ones, the border's value stands beyond closed ones.
        time_step: Duration [s].
        scheme: One of ``SCHEMES``.
        out: Array to write, never ``field`` itself; a new one when omitted.

    Returns:
        The moved field, shape of ``field``.

    Raises:
        ValueError: If shapes, types or devices do not fit, or there is no such scheme.
    """
    return _follow([field], velocity, sides, time_step, scheme, CENTRE, [out])[0]


def advect_scalars(
    fields: Sequence[wp.array], velocity: Faces, sides: SIX, time_step: float, *, scheme: str
) -> list[wp.array]:
    """Carry several fields, as ``advect_scalar`` does, along paths that are found once."""
    return _follow(fields, velocity, sides, time_step, scheme, CENTRE, [None] * len(fields))


def advect_velocity(moved: Faces, velocity: Faces, sides: SIX, time_step: float, *, scheme: str) -> Faces:
    """Carry a vector field on the faces, such as the velocity itself, for one time step.

    Args:
        moved: What is carried; each component from and to its own faces.
        velocity: What carries [voxel/s].
        sides: What the six sides are: beyond open and closed ones stands the border's value.
        time_step: Duration [s].
        scheme: One of ``SCHEMES``.

    Returns:
        The moved components, new arrays.

    Raises:
        ValueError: If shapes, types or devices do not fit, or there is no such scheme.
    """
    parts = [_follow([part], velocity, sides, time_step, scheme, axis, [None])[0] for axis, part in enumerate(moved)]
    return Faces(*parts)


def _follow(
    fields: Sequence[wp.array],
    velocity: Faces,
    sides: SIX,
    time_step: float,
    scheme: str,
    place: int,
    outs: Sequence[wp.array | None],
) -> list[wp.array]:
    """Carry fields that live in the same places."""
    if scheme not in SCHEMES:
        raise ValueError(f"scheme is {scheme!r}, expected one of {', '.join(SCHEMES)}")
    back = trace(*velocity, sides, place=place, time_step=-time_step)
    forth = trace(*velocity, sides, place=place, time_step=time_step) if scheme in ("maccormack", "bfecc") else None
    return [_carry(field, back, forth, sides, scheme, place, out) for field, out in zip(fields, outs, strict=True)]


def _carry(
    field: wp.array,
    back: wp.array,
    forth: wp.array | None,
    sides: SIX,
    scheme: str,
    place: int,
    out: wp.array | None,
) -> wp.array:
    """Carry one field along paths that are known."""
    if scheme == "cubic":
        out = spline.carry_spline(field, back, sides, place=place, out=out)
        return transport.limit(field, back, sides, place=place, out=out)
    if scheme == "semi-lagrangian":
        return transport.carry(field, back, sides, place=place, out=out)
    carried = transport.carry(field, back, sides, place=place)
    if scheme == "maccormack":
        return transport.correct(field, carried, back, forth, sides, place=place, out=out)
    mended = transport.mend(field, carried, forth, sides, place=place)
    out = transport.carry(mended, back, sides, place=place, out=carried if out is None else out)
    return transport.limit(field, back, sides, place=place, out=out)
