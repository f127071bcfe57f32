"""What the pressure step does on faces: divergence and pressure gradient.

Velocity lives on the faces of a grid of (nx, nz, ny) voxels, pressure in their centres (Harlow and Welch 1965).
A face that a solid covers in part counts by the share that is open (Batty, Bertails and Bridson 2007; Ng, Min and
Gibou 2009): its flux is open u + (1 - open) u_solid.
"""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import RUN_OF_HEIGHTS, launch
from warpfluid.kernels.sides import SIX

wp.set_module_options({"enable_backward": False})

FLUX = (
    """
    const int heights = out.shape[2];"""
    + RUN_OF_HEIGHTS
    + """
    const size_t below = ((size_t)x * velocity.shape[1] + z) * velocity.shape[2] + y;
    const size_t above = below + (axis == 0 ? (size_t)velocity.shape[1] * heights : axis == 1 ? heights : 1);
    float* to = out.data + ((size_t)x * out.shape[1] + z) * heights + y;
    const float *a = velocity.data + below, *b = velocity.data + above;
    if (!open.data) {
        for (int l = 0; l < count; ++l) to[l] += b[l] - a[l];
        return;
    }
    const float *open_a = open.data + below, *open_b = open.data + above;
    const float *solid_a = solid.data + below, *solid_b = solid.data + above;
    for (int l = 0; l < count; ++l)
        to[l] += (solid_b[l] + open_b[l] * (b[l] - solid_b[l])) - (solid_a[l] + open_a[l] * (a[l] - solid_a[l]));
"""
)

# Without coefficients: an open side has pressure 0 half a voxel away, a wall bears no gradient, a wrap is inside.
GRADIENT = (
    """
    const int n = pressure.shape[axis], heights = velocity.shape[2];"""
    + RUN_OF_HEIGHTS
    + """
    const long long ny = pressure.shape[2], plane = pressure.shape[1] * ny;
    const long long stride = axis == 0 ? plane : axis == 1 ? ny : 1, across = n * stride;
    const size_t face = ((size_t)x * velocity.shape[1] + z) * heights + y;
    const float* p = pressure.data + x * plane + z * ny + y;
    const int first = axis == 0 ? x : axis == 1 ? z : y, last = axis == 2 ? first + count - 1 : first;
    const float beyond[3] = {2.0f, 0.0f, 1.0f};
    float step[RUN] = {};
    if (first > 0 && last < n)
        for (int l = 0; l < count; ++l) step[l] = p[l] - p[l - stride];
    else
        for (int l = 0; l < count; ++l) {
            const int i = axis == 2 ? y + l : first;
            const float before = i > 0 ? p[l - stride] : low == 2 ? p[l + across - stride] : 0.0f;
            const float after = i < n ? p[l] : high == 2 ? p[l - across] : 0.0f;
            const float factor = coefficient.data || (i > 0 && i < n) ? 1.0f : beyond[i == 0 ? low : high];
            step[l] = factor * (after - before);
        }
    float* u = velocity.data + face;
    if (!coefficient.data) {
        for (int l = 0; l < count; ++l) u[l] -= step[l];
        return;
    }
    const float *weight = coefficient.data + face, *share = open.data ? open.data + face : 0;
    if (share)
        for (int l = 0; l < count; ++l) u[l] -= weight[l] > 0.0f ? step[l] * weight[l] / share[l] : 0.0f;
    else
        for (int l = 0; l < count; ++l) u[l] -= step[l] * weight[l];
"""
)


@wp.func_native(snippet=FLUX)
def add_flux_run(
    velocity: wp.array3d[float],
    open: wp.array3d[float],
    solid: wp.array3d[float],
    axis: int,
    x: int,
    z: int,
    block: int,
    out: wp.array3d[float],
):
    """Add what leaves a run of heights along one axis."""


@wp.func_native(snippet=GRADIENT)
def subtract_gradient_run(
    pressure: wp.array3d[float],
    coefficient: wp.array3d[float],
    open: wp.array3d[float],
    axis: int,
    low: int,
    high: int,
    x: int,
    z: int,
    block: int,
    velocity: wp.array3d[float],
):
    """Take the pressure gradient from a run of faces."""


@wp.kernel
def add_flux_kernel(
    first_row: int,
    first_block: int,
    velocity: wp.array3d[float],
    open: wp.array3d[float],
    solid: wp.array3d[float],
    axis: int,
    out: wp.array3d[float],
):
    """Add what leaves each voxel along one axis."""
    i, z, j = wp.tid()
    x = first_row + i
    block = first_block + j
    add_flux_run(velocity, open, solid, axis, x, z, block, out)


@wp.kernel
def subtract_gradient_kernel(
    first_row: int,
    first_block: int,
    pressure: wp.array3d[float],
    coefficient: wp.array3d[float],
    open: wp.array3d[float],
    axis: int,
    sides: SIX,
    velocity: wp.array3d[float],
):
    """Take the pressure gradient from the faces of one axis."""
    i, z, j = wp.tid()
    x = first_row + i
    block = first_block + j
    low = sides[2 * axis]
    high = sides[2 * axis + 1]
    subtract_gradient_run(pressure, coefficient, open, axis, low, high, x, z, block, velocity)


def _face_shape(shape: tuple[int, ...], axis: int) -> tuple[int, ...]:
    return tuple(n + (k == axis) for k, n in enumerate(shape))


def add_flux(
    velocity: wp.array3d[float],
    *,
    axis: int,
    open: wp.array3d[float] | None = None,
    solid: wp.array3d[float] | None = None,
    out: wp.array3d[float],
) -> wp.array3d[float]:
    """Add what leaves each voxel along one axis; over the three axes this is the divergence.

    Args:
        velocity: Component along the axis on its faces [voxel/s].
        axis: 0 is x, 1 is z, 2 is y.
        open: Share of each face that is fluid, shape of ``velocity``; 1 when omitted.
        solid: Velocity of the solid at each face, together with ``open`` [voxel/s].
        out: Shape (x, z, y), added to [1/s].

    Returns:
        ``out``.

    Raises:
        ValueError: If shapes, types or devices do not fit or only one of ``open`` and ``solid`` is given.
    """
    if (open is None) != (solid is None):
        raise ValueError("open and solid go together: pass both or neither")
    extra = {} if open is None else {"open": open, "solid": solid}
    device = checks.same_device(velocity=velocity, out=out, **extra)
    checks.floats(3, velocity=velocity, out=out, **extra)
    checks.shape(_face_shape(out.shape, axis), velocity=velocity, **extra)
    launch(add_flux_kernel, out.shape, [velocity, open, solid, axis], [out], device)
    return out


def subtract_gradient(
    pressure: wp.array3d[float],
    *,
    axis: int,
    sides: SIX,
    coefficient: wp.array3d[float] | None = None,
    open: wp.array3d[float] | None = None,
    velocity: wp.array3d[float],
) -> wp.array3d[float]:
    """Take the pressure gradient along one axis from the velocity on its faces.

    Args:
        pressure: Times time over mass density, shape (x, z, y) [voxel^2/s].
        axis: 0 is x, 1 is z, 2 is y.
        sides: What the sides of the box are.
        coefficient: Of the Poisson equation at each face, sides included (``coefficients.face_coefficient``); without,
            the fluid is one and fills the box.
        open: Share of each face that is fluid, which the coefficient holds as a factor; 1 when omitted.
        velocity: Component along the axis on its faces, changed [voxel/s].

    Returns:
        ``velocity``.

    Raises:
        ValueError: If shapes, types or devices do not fit or shares come without a coefficient.
    """
    if coefficient is None and open is not None:
        raise ValueError("open needs coefficient: pass both")
    given = {"coefficient": coefficient, "open": open}
    extra = {name: array for name, array in given.items() if array is not None}
    device = checks.same_device(pressure=pressure, velocity=velocity, **extra)
    checks.floats(3, pressure=pressure, velocity=velocity, **extra)
    checks.shape(_face_shape(pressure.shape, axis), velocity=velocity, **extra)
    inputs = [pressure, coefficient, open, axis, sides]
    launch(subtract_gradient_kernel, velocity.shape, inputs, [velocity], device)
    return velocity
