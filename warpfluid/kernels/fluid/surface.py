"""Keep the surface of a liquid sharp (conservative level set: Olsson and Kreiss 2005).

A liquid that is carried from voxel to voxel fades into mist. Here its share of a voxel, phi, flows towards where there
is more of it, and spreads a little against that: d phi / dt = -div(phi (1 - phi) n - width grad phi), n along grad phi.
The profile at which both balance is 1 / (1 + exp(-x / width)), across the surface. What is fuller than full flows out.
"""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.fluid.faces import cell_or_none, launch_run
from warpfluid.kernels.sides import SIX, WRAP

wp.set_module_options({"enable_backward": False})

FULLEST = 1.5  # share up to which overfull voxels flow out ever faster
SIXTH = 1.0 / 6.0  # of what a voxel holds, at most, goes through each of its faces


@wp.func
def beside(x: int, z: int, y: int, axis: int, step: int, cells: wp.vec3i, sides: SIX) -> wp.vec3i:
    """Return a neighbour along an axis; beyond a border that does not wrap, the voxel itself."""
    at = wp.vec3i(x, z, y)
    there = cell_or_none(at[axis] + step, cells[axis], sides[2 * axis] == WRAP)
    if there >= 0:
        at[axis] = there
    return at


@wp.kernel
def point_inwards_kernel(
    first_row: int,
    first_block: int,
    field: wp.array3d[float],
    scale: float,
    cells: wp.vec3i,
    sides: SIX,
    run: int,
    out: wp.array3d[wp.vec3],
):
    """Compress: phi (1 - phi) towards where there is more."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, out.shape[2])):
        share = scale * field[x, z, y]
        flow = wp.vec3()
        if share > 0.0:
            for axis in range(3):
                more = beside(x, z, y, axis, 1, cells, sides)
                less = beside(x, z, y, axis, -1, cells, sides)
                flow[axis] = field[more[0], more[1], more[2]] - field[less[0], less[1], less[2]]
            flow = share * (1.0 - wp.min(share, FULLEST)) * wp.normalize(flow)
        out[x, z, y] = flow


@wp.func
def flow_out(
    field: wp.array3d[float],
    inwards: wp.array3d[wp.vec3],
    opening: wp.array3d[float],
    here: wp.vec3i,
    axis: int,
    step: int,
    scale: float,
    width: float,
    time_step: float,
    cells: wp.vec3i,
    sides: SIX,
) -> float:
    """Return what leaves a voxel through one of its faces; the neighbour finds the same with the other sign."""
    there = beside(here[0], here[1], here[2], axis, step, cells, sides)
    if there == here:
        return 0.0
    a, b = field[here[0], here[1], here[2]], field[there[0], there[1], there[2]]
    pull = 0.5 * (inwards[here[0], here[1], here[2]][axis] + inwards[there[0], there[1], there[2]][axis]) / scale
    flow = time_step * (float(step) * pull - width * (b - a))
    if opening.shape[0] > 0:
        face = here
        face[axis] = here[axis] + wp.max(step, 0)
        flow = flow * opening[face[0], face[1], face[2]]
    return wp.clamp(flow, -SIXTH * b, SIXTH * a)


@wp.kernel
def sharpen_kernel(
    first_row: int,
    first_block: int,
    field: wp.array3d[float],
    inwards: wp.array3d[wp.vec3],
    open_x: wp.array3d[float],
    open_z: wp.array3d[float],
    open_y: wp.array3d[float],
    scale: float,
    width: float,
    time_step: float,
    cells: wp.vec3i,
    sides: SIX,
    run: int,
    out: wp.array3d[float],
):
    """Take from a voxel what leaves it through its six faces; no openings are empty arrays."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, out.shape[2])):
        here = wp.vec3i(x, z, y)
        left = field[x, z, y]
        for side in range(2):
            step = 2 * side - 1
            left -= flow_out(field, inwards, open_x, here, 0, step, scale, width, time_step, cells, sides)
            left -= flow_out(field, inwards, open_z, here, 1, step, scale, width, time_step, cells, sides)
            left -= flow_out(field, inwards, open_y, here, 2, step, scale, width, time_step, cells, sides)
        out[x, z, y] = wp.max(left, 0.0)


def sharpen(
    field: wp.array3d[float],
    sides: SIX,
    *,
    reference: float,
    width: float,
    time_step: float,
    openings: tuple[wp.array3d[float], ...] = (),
    inwards: wp.array3d[wp.vec3] | None = None,
    out: wp.array3d[float] | None = None,
) -> wp.array3d[float]:
    """Draw a liquid together at its surface for a short time; its total stays.

    Args:
        field: Density, shape (x, z, y), not negative.
        sides: What the six sides are; nothing flows through any but those that wrap.
        reference: Density of a voxel that is full.
        width: Of the profile that the surface comes to [voxel].
        time_step: In units in which the surface moves a voxel, at most 0.25 for a width of 0.5.
        openings: Shares of the faces along x, z and y that solids leave open; all are when omitted.
        inwards: Memory of the field's shape to work in.
        out: Array to write, never ``field`` itself; a new one when omitted.

    Returns:
        The field with a sharper surface.

    Raises:
        ValueError: If shapes, types or devices do not fit, or a number makes no sense.
    """
    out = wp.empty_like(field) if out is None else out
    inwards = wp.empty(field.shape, dtype=wp.vec3, device=field.device) if inwards is None else inwards
    named = {f"openings[{axis}]": faces for axis, faces in enumerate(openings)}
    device = checks.same_device(field=field, inwards=inwards, out=out, **named)
    checks.floats(3, field=field, out=out, **named)
    checks.typed(wp.vec3, 3, inwards=inwards)
    checks.same_shape(field=field, inwards=inwards, out=out)
    for axis, (name, faces) in enumerate(named.items()):
        checks.shape(tuple(n + (k == axis) for k, n in enumerate(field.shape)), **{name: faces})
    if len(openings) not in (0, 3) or out is field:
        raise ValueError(f"there are {len(openings)} openings, expected none or three; out must not be the field")
    if not (reference > 0 and width >= 0 and time_step >= 0 and time_step * max(1.0, width) <= 0.25):
        raise ValueError(
            f"reference, width and time_step are {reference}, {width} and {time_step}: "
            "expected a density above 0, and a short step, at most 0.25 / width"
        )
    around = [1.0 / reference, wp.vec3i(*field.shape), sides]
    launch_run(point_inwards_kernel, [field, *around], inwards)
    none = [wp.empty((0, 0, 0), dtype=float, device=device)] * 3
    numbers = [1.0 / reference, width, time_step, *around[1:]]
    launch_run(sharpen_kernel, [field, inwards, *(openings or none), *numbers], out)
    return out
