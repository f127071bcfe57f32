"""Forces that depend on the place alone: a push, an explosion's blast, a magnet, a whirl.

Profiles are smooth and have no singular point, so that a centre may lie anywhere.
"""

import math

import warp as wp

from warpfluid.kernels.fluid.faces import check_faces, launch_run, on_wall
from warpfluid.kernels.sides import SIX, WRAP

wp.set_module_options({"enable_backward": False})

KINDS = ("uniform", "radial", "attractor", "vortex")
UNIFORM, RADIAL, ATTRACTOR, VORTEX = range(4)


@wp.func
def away(i: float, centre: float, n: int, wraps: bool) -> float:
    """Return the distance from a centre along an axis, the shortest where the box wraps."""
    distance = i - centre
    if wraps:
        distance = distance - float(n) * wp.round(distance / float(n))
    return distance


@wp.func
def push(kind: int, d: wp.vec3, direction: wp.vec3, radius: float) -> wp.vec3:
    """Return the acceleration at a place ``d`` away from the centre; vectors are (x, z, y)."""
    if kind == UNIFORM:
        if radius <= 0.0:
            return direction
        return wp.exp(-0.5 * wp.length_sq(d) / (radius * radius)) * direction
    if kind == RADIAL:
        r = wp.length(d) / radius
        return wp.exp(0.5 - 0.5 * r * r) / radius * d
    if kind == ATTRACTOR:
        soft = wp.sqrt(wp.length_sq(d) + radius * radius)
        return -radius * radius / (soft * soft * soft) * d
    off = d - wp.dot(d, direction) * direction
    r = wp.length(off) / radius
    # As (x, z, y) is left-handed, this order turns counterclockwise around the axis' tip.
    return wp.exp(0.5 - 0.5 * r * r) / radius * wp.cross(off, direction)


@wp.kernel
def push_kernel(
    first_row: int,
    first_block: int,
    kind: int,
    strength: float,
    direction: wp.vec3,
    centre: wp.vec3,
    radius: float,
    axis: int,
    cells: wp.vec3i,
    sides: SIX,
    run: int,
    velocity: wp.array3d[float],
):
    """Speed a face up by one component of the force at its middle."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, velocity.shape[2])):
        if not on_wall(axis, x, z, y, cells, sides):
            d = wp.vec3()
            for k in range(3):
                i = wp.where(k == 0, x, wp.where(k == 1, z, y))
                wraps = sides[2 * k] == WRAP
                if wraps and i == cells[k]:
                    i = 0  # the same face: the same bits
                shift = wp.where(k == axis, 0.5, 0.0)
                d[k] = away(float(i) - shift, centre[k], cells[k], wraps)
            velocity[x, z, y] = velocity[x, z, y] + strength * push(kind, d, direction, radius)[axis]


def add_push(
    velocity_x: wp.array3d[float],
    velocity_z: wp.array3d[float],
    velocity_y: wp.array3d[float],
    *,
    kind: str,
    strength: float,
    sides: SIX,
    time_step: float,
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0),
    radius: float = 0.0,
    direction: tuple[float, float, float] = (0.0, 0.0, 1.0),
) -> None:
    """Add a force that depends on the place alone, in place.

    With d the way from the centre, r its length and R the radius, the acceleration is ``strength`` times

    - "uniform": the direction, times exp(-r^2 / 2R^2) if there is a radius;
    - "radial": (d / R) exp((1 - r^2 / R^2) / 2), an outward blast whose peak, 1, is at r = R;
    - "attractor": -R^2 d / (r^2 + R^2)^(3/2), a pull of (R / r)^2 far away (Plummer's softening);
    - "vortex": (a x d / R) exp((1 - r^2 / R^2) / 2), with r measured from the axis a through the centre: a whirl,
      counterclockwise seen from where the axis points to, whose peak, 1, is at r = R.

    Where the box wraps, d is the shortest way.

    Args:
        velocity_x: [voxel/s], shape (nx + 1, nz, ny).
        velocity_z: Shape (nx, nz + 1, ny).
        velocity_y: Shape (nx, nz, ny + 1).
        kind: One of ``KINDS``.
        strength: Acceleration [voxel/s^2]; below 0 it points the other way.
        sides: What the box's six sides are; faces on closed ones stay as they are.
        time_step: [s].
        centre: (x, z, y), voxel centres at whole numbers [voxel].
        radius: [voxel]; only a uniform push may do without.
        direction: Of a push or of a vortex's axis, (x, z, y), made a unit vector.

    Raises:
        ValueError: If shapes, types or devices do not fit, or a kind is unknown or lacks a radius or a direction.
    """
    cells, _ = check_faces(velocity_x, velocity_z, velocity_y)
    if kind not in KINDS:
        raise ValueError(f"kind is {kind!r}, expected one of {', '.join(KINDS)}")
    if radius < 0 or (radius == 0 and kind != "uniform"):
        raise ValueError(f"radius is {radius}, expected a number above 0 for a force of kind {kind}, in voxels")
    length = math.hypot(*direction)
    if not length > 0:
        raise ValueError(f"direction is {direction}, expected a vector that points somewhere")
    if strength * time_step == 0:
        return
    unit = wp.vec3(*(component / length for component in direction))
    inputs = [KINDS.index(kind), strength * time_step, unit, wp.vec3(*centre), radius]
    for axis, velocity in enumerate((velocity_x, velocity_z, velocity_y)):
        launch_run(push_kernel, [*inputs, axis, wp.vec3i(*cells), sides], velocity)
