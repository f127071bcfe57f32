"""What pushes a fluid: its own lightness, and the wind."""

import math

import warp as wp

from warpfluid.kernels.fluid.faces import check_faces, face_mean, launch_run, on_wall
from warpfluid.kernels.sides import SIX

wp.set_module_options({"enable_backward": False})


@wp.kernel
def buoyancy_kernel(
    first_row: int,
    first_block: int,
    temperature: wp.array3d[float],
    density: wp.array3d[float],
    per_temperature: float,
    per_density: float,
    axis: int,
    cells: wp.vec3i,
    sides: SIX,
    run: int,
    velocity: wp.array3d[float],
):
    """Speed a face up by the mean of what its two voxels weigh less than air."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, velocity.shape[2])):
        if not on_wall(axis, x, z, y, cells, sides):
            warmth = face_mean(temperature, axis, x, z, y, sides)
            smoke = face_mean(density, axis, x, z, y, sides)
            velocity[x, z, y] = velocity[x, z, y] + per_temperature * warmth + per_density * smoke


@wp.kernel
def wind_kernel(
    first_row: int,
    first_block: int,
    wind: float,
    exponent: float,
    mask: wp.array3d[float],
    axis: int,
    cells: wp.vec3i,
    sides: SIX,
    run: int,
    velocity: wp.array3d[float],
):
    """Bring a face nearer to the wind's speed; no mask is an empty array."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, velocity.shape[2])):
        if not on_wall(axis, x, z, y, cells, sides):
            cover = float(1.0)
            if mask.shape[0] > 0:
                cover = face_mean(mask, axis, x, z, y, sides)
            if cover > 0.0:
                now = velocity[x, z, y]
                velocity[x, z, y] = wind + (now - wind) * wp.exp(-exponent * cover)


def add_buoyancy(
    velocity_x: wp.array3d[float],
    velocity_z: wp.array3d[float],
    velocity_y: wp.array3d[float],
    *,
    temperature: wp.array3d[float],
    density: wp.array3d[float],
    up: tuple[float, float, float],
    temperature_buoyancy: float,
    density_buoyancy: float,
    reference: float,
    sides: SIX,
    time_step: float,
) -> None:
    """Let what is hot rise, and smoke rise or sink (Boussinesq), in place.

    The acceleration is ``up * (temperature_buoyancy * temperature + density_buoyancy * density / reference)``, on a
    face the mean of its two voxels. Outside an open side both are 0.

    Args:
        velocity_x: [voxel/s], shape (nx + 1, nz, ny).
        velocity_z: Shape (nx, nz + 1, ny).
        velocity_y: Shape (nx, nz, ny + 1).
        temperature: 1 is as hot as an emitter of temperature 1, shape (nx, nz, ny).
        density: Smoke, the same shape.
        up: Against gravity, components (x, z, y) [voxel/s^2].
        temperature_buoyancy: Lift of temperature 1, in parts of ``up``.
        density_buoyancy: Lift of density ``reference``; below 0 smoke sinks.
        reference: A density that counts as 1.
        sides: What the box's six sides are; faces on closed ones stay as they are.
        time_step: [s].

    Raises:
        ValueError: If shapes, types or devices do not fit or ``reference`` is not above 0.
    """
    cells, _ = check_faces(velocity_x, velocity_z, velocity_y, temperature=temperature, density=density)
    if not reference > 0:
        raise ValueError(f"reference is {reference}, expected a density above 0")
    for axis, velocity in enumerate((velocity_x, velocity_z, velocity_y)):
        per_temperature = time_step * up[axis] * temperature_buoyancy
        per_density = time_step * up[axis] * density_buoyancy / reference
        if per_temperature or per_density:
            inputs = [temperature, density, per_temperature, per_density, axis, wp.vec3i(*cells), sides]
            launch_run(buoyancy_kernel, inputs, velocity)


def add_wind(
    velocity_x: wp.array3d[float],
    velocity_z: wp.array3d[float],
    velocity_y: wp.array3d[float],
    *,
    wind: tuple[float | None, float | None, float | None] = (0.0, 0.0, 0.0),
    rate: float,
    sides: SIX,
    time_step: float,
    mask: wp.array3d[float] | None = None,
) -> None:
    """Drag a fluid along with a wind, in place; without wind it is friction with still air.

    Solves ``du/dt = rate * mask * (wind - u)`` exactly: ``u = wind + (u - wind) exp(-rate * mask * time_step)``.

    Args:
        velocity_x: [voxel/s], shape (nx + 1, nz, ny).
        velocity_z: Shape (nx, nz + 1, ny).
        velocity_y: Shape (nx, nz, ny + 1).
        wind: Its velocity, components (x, z, y) [voxel/s]; those that are None stay as they are.
        rate: How fast the difference vanishes [1/s].
        sides: What the box's six sides are; faces on closed ones stay as they are.
        time_step: [s].
        mask: Where it blows, 0 to 1, shape (nx, nz, ny), 0 outside open sides; everywhere when omitted.

    Raises:
        ValueError: If shapes, types or devices do not fit or ``rate`` is below 0.
    """
    masks = {} if mask is None else {"mask": mask}
    cells, device = check_faces(velocity_x, velocity_z, velocity_y, **masks)
    if rate < 0 or not math.isfinite(rate):
        raise ValueError(f"rate is {rate}, expected a number >= 0, in 1/s")
    if rate * time_step == 0:
        return
    mask = wp.empty((0, 0, 0), dtype=float, device=device) if mask is None else mask
    for axis, velocity in enumerate((velocity_x, velocity_z, velocity_y)):
        if wind[axis] is not None:
            launch_run(wind_kernel, [wind[axis], rate * time_step, mask, axis, wp.vec3i(*cells), sides], velocity)
