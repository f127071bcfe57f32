"""Let the velocity carry what the fluid holds, and itself (Stam 1999); let both spread by diffusion.

Four schemes, from the softest to the sharpest: "semi-lagrangian" interpolates linearly, "bfecc" and "maccormack" make
good the error of that, "cubic" interpolates with a spline. None makes values that were not around the source before.
Where the fluid is at rest, all but "cubic", which rounds, return the same values.
"""

import math
from collections.abc import Sequence

import warp as wp

from warpfluid.kernels.fluid import correction, spline, totals, transport
from warpfluid.kernels.fluid.diffusion import spread
from warpfluid.kernels.fluid.tracing import CENTRE, trace
from warpfluid.kernels.sides import SIX
from warpfluid.simulation.state import Faces, face_shape

SCHEMES = ("semi-lagrangian", "maccormack", "bfecc", "cubic")
BOTH_WAYS = ("maccormack", "bfecc")  # find their error by going back and forth


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
    return _carry(field, _paths(velocity, sides, time_step, scheme, CENTRE), sides, scheme, CENTRE, out)


def advect_scalars(
    fields: Sequence[wp.array], velocity: Faces, sides: SIX, time_step: float, *, scheme: str
) -> list[wp.array]:
    """Carry several fields, as ``advect_scalar`` does, along paths that are found once."""
    paths = _paths(velocity, sides, time_step, scheme, CENTRE)
    return [_carry(field, paths, sides, scheme, CENTRE, None) for field in fields]


def advect_velocity(
    moved: Faces, velocity: Faces, sides: SIX, time_step: float, *, scheme: str, out: Faces | None = None
) -> Faces:
    """Carry a vector field on the faces, such as the velocity itself, for one time step.

    Args:
        moved: What is carried; each component from and to its own faces.
        velocity: What carries [voxel/s].
        sides: What the six sides are: beyond open and closed ones stands the border's value.
        time_step: Duration [s].
        scheme: One of ``SCHEMES``.
        out: Arrays to write, none of the others; new ones when omitted.

    Returns:
        The moved components.

    Raises:
        ValueError: If shapes, types or devices do not fit, or there is no such scheme.
    """
    size = 3 * max(part.size for part in velocity)
    memory = [wp.empty(size, dtype=float, device=velocity.x.device) for _ in range(1 + (scheme in BOTH_WAYS))]
    parts = []
    for axis, to in enumerate([None] * 3 if out is None else out):
        paths = _paths(velocity, sides, time_step, scheme, axis, memory)
        parts.append(_carry(moved[axis], paths, sides, scheme, axis, to))
    return Faces(*parts)


def diffuse(
    field: wp.array | Faces, coefficient_times_time: float, sides: SIX, *, out: wp.array | Faces | None = None
) -> wp.array | Faces:
    """Let a scalar in the centres, or a velocity on the faces, spread by diffusion; stable for any strength.

    The variance of a blob grows by twice ``coefficient_times_time``. Closed sides let nothing through and do not brake
    what flows along them (free slip); beyond open ones scalars are 0.

    Args:
        field: Shape (x, z, y), or a velocity [voxel/s].
        coefficient_times_time: [voxel^2]; 0 leaves the bits equal.
        sides: What the six sides are.
        out: What to write; it may be ``field``; new when omitted.

    Returns:
        The spread field, of the kind of ``field``.

    Raises:
        ValueError: If shapes, types or devices do not fit, or the strength is below 0.
    """
    if not isinstance(field, Faces):
        return spread(field, 2.0 * coefficient_times_time, sides, place=CENTRE, out=out)
    outs = [None] * 3 if out is None else out
    parts = [
        spread(part, 2.0 * coefficient_times_time, sides, place=axis, out=to)
        for axis, (part, to) in enumerate(zip(field, outs, strict=True))
    ]
    return Faces(*parts)


def keep_total(field: wp.array, total: float) -> wp.array:
    """Scale a field, in place, so that its sum is what it was: for boxes that let nothing out.

    Args:
        field: What was carried, shape (x, z, y), not negative. Where it is 0 everywhere it stays so.
        total: The sum to have, as ``totals.total`` said before.

    Returns:
        The field.

    Raises:
        ValueError: If the type does not fit.
    """
    now = totals.total(field)
    return totals.scale(field, total / now) if now > 0.0 else field


def _paths(
    velocity: Faces, sides: SIX, time_step: float, scheme: str, place: int, memory: Sequence[wp.array] = ()
) -> list[wp.array]:
    """Trace where the fluid came from and, if the scheme asks, where it goes; into flat arrays where there are any."""
    if scheme not in SCHEMES:
        raise ValueError(f"scheme is {scheme!r}, expected one of {', '.join(SCHEMES)}")
    shape = (3, *face_shape((*velocity.y.shape[:2], velocity.x.shape[2]), place))
    size = math.prod(shape)
    outs = [array[:size].reshape(shape) for array in memory] or [None, None]
    ways = (-1, 1) if scheme in BOTH_WAYS else (-1,)
    return [trace(*velocity, sides, place=place, time_step=way * time_step, out=outs[i]) for i, way in enumerate(ways)]


def _carry(
    field: wp.array, paths: Sequence[wp.array], sides: SIX, scheme: str, place: int, out: wp.array | None
) -> wp.array:
    """Carry one field along paths that are known."""
    back = paths[0]
    if scheme == "cubic":
        out = spline.carry_spline(field, back, sides, place=place, out=out)
        return transport.limit(field, back, sides, place=place, out=out)
    if scheme == "semi-lagrangian":
        return transport.carry(field, back, sides, place=place, out=out)
    carried = transport.carry(field, back, sides, place=place)
    if scheme == "maccormack":
        return correction.correct(field, carried, *paths, sides, place=place, out=out)
    mended = correction.mend(field, carried, paths[1], sides, place=place)
    out = transport.carry(mended, back, sides, place=place, out=carried if out is None else out)
    return transport.limit(field, back, sides, place=place, out=out)
