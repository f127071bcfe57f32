"""What a reconstruction will cost, before it runs."""

from dataclasses import replace

import numpy as np

from warpfluid.memory import check_memory, memory_limit
from warpfluid.options import (
    MUTATIONS_A_VOXEL,
    MUTATIONS_A_VOXEL_AND_E_STEP,
    ReconstructOptions,
    default_angles,
)

HULL_WIDTH = 48  # voxels; the hull is a share, so a coarse one tells it
BULK = 0.1  # share of a row's light outside its bulk, either side
# Measured on two CPU cores at 96 x 144 and 271 x 144 pixels, 90 and 180 angles
SECONDS_A_FRAME = 0.2
SECONDS_A_VOXEL = 6e-8  # of the whole box: noise, least squares, file
SECONDS_AN_ITERATION = 0.05
SECONDS_A_RAY_STEP = 1.9e-10  # one projection or back-projection, by angle and voxel inside the hull
SECONDS_A_STATISTIC = 7e-8  # one M-step, by angle and pixel
SECONDS_A_SWEEP = 3.5e-7  # over joint statistics, by angle and pixel
SECONDS_A_PATCHED_PIXEL = 7e-7  # of texture optimisation, by angle
SECONDS_A_FLOW_PIXEL = 7e-6
SECONDS_A_MUTATION = 5e-8  # of a random walk over two views
SECONDS_A_MADE_MUTATION = 1.2e-8  # of one in an E-step, by angle
SECONDS_A_CONVEX_STEP = 2e-8  # by voxel inside the hull
SECONDS_OF_FILM = 2.0
SECONDS_OF_PAGE = 1.5  # by frame shown
SHOWN_FRAMES = 6
BYTES = 20e6
BYTES_A_VOXEL = 16  # of the whole box
BYTES_A_HULL_VOXEL = 48  # of the part of the box that the hull needs
PART_OVER_HULL = 2.5  # that part is rectangular, the hull is not
BYTES_A_PIXEL = 32
LONG = 3600.0  # s; a run that takes longer gets a smaller width proposed
MINUTES = 1200.0  # s that it should take then
NARROWEST, WIDTH_STEP = 64, 16  # pixels; widths to propose


def hull_share(images: np.ndarray, angles_deg: tuple[float, ...], options: ReconstructOptions) -> float:
    """Return the share of the box inside the visual hull of one frame, on a coarse grid.

    Args:
        images: Shape (view, u, v).
        angles_deg: One a view.
        options: Its threshold and hull are used; the round hull where one view has it.
    """
    stride = max(1, -(-images.shape[1] // HULL_WIDTH))
    images = images[:, ::stride, ::stride]
    across = np.arange(images.shape[1]) - (images.shape[1] - 1) / 2
    x, z = np.meshgrid(across, across, indexing="ij")
    hull = np.ones((*x.shape, images.shape[2]), bool)
    for image, angle_deg in zip(images, angles_deg, strict=True):
        u = np.cos(np.radians(angle_deg)) * x + np.sin(np.radians(angle_deg)) * z - across[0]
        inside = (u > -0.5) & (u < len(across) - 0.5)
        lit = image > options.threshold
        hull &= inside[..., None] & lit[u.round().astype(int).clip(0, len(across) - 1)]
    if len(images) == 1 and options.hull != "silhouette":
        hull &= _round_hull(images[0], np.radians(angles_deg[0]), x, z, options.hull_radius)
    return float(hull.mean())


def estimate_cost(size: tuple[int, int], share: float, options: ReconstructOptions) -> tuple[float, int]:
    """Return seconds a frame on two CPU cores, and bytes of memory.

    Args:
        size: Width and height of an image [pixel].
        share: Share of the box inside the visual hull.
        options: Iterations, angles and steps.
    """
    u, v = size
    voxels, pixels = u * u * v, (options.angles or default_angles(u)) * u * v
    iterations = options.iterations if options.method == "appearance-transfer" else 0
    projections = 2 + 2 * options.cg_steps
    iteration = SECONDS_AN_ITERATION + pixels * _seconds_of_transfer(options)
    iteration += projections * pixels * u * share * SECONDS_A_RAY_STEP
    seconds = SECONDS_A_FRAME + voxels * SECONDS_A_VOXEL + iterations * iteration
    seconds += _seconds_of_walks(voxels * share, pixels // (u * v), options)
    if options.method == "convex":
        seconds += options.convex_steps * voxels * share * SECONDS_A_CONVEX_STEP
    part = min(PART_OVER_HULL * share, 1)
    return seconds, int(BYTES + voxels * (BYTES_A_VOXEL + part * BYTES_A_HULL_VOXEL) + pixels * BYTES_A_PIXEL)


def _seconds_of_transfer(options: ReconstructOptions) -> float:
    """Return seconds of an M-step, by angle and pixel."""
    if options.transfer == "texture-optimization":
        return SECONDS_A_PATCHED_PIXEL
    if options.transfer == "portilla-simoncelli":
        return SECONDS_A_STATISTIC + options.sweeps * SECONDS_A_SWEEP
    return SECONDS_A_STATISTIC


def _seconds_of_walks(hull_voxels: float, angles: int, options: ReconstructOptions) -> float:
    """Return seconds that a frame's random walks take."""
    if options.method == "stochastic":
        return (options.mutations or MUTATIONS_A_VOXEL * hull_voxels) * SECONDS_A_MUTATION
    if options.method != "appearance-transfer" or options.e_step != "stochastic":
        return 0.0
    proposals = options.mutations or MUTATIONS_A_VOXEL_AND_E_STEP * hull_voxels
    return options.iterations * proposals * angles * SECONDS_A_MADE_MUTATION


def estimate_carried(size: tuple[int, int], share: float, options: ReconstructOptions, views: int) -> float:
    """Return seconds for a frame that starts from the one before.

    Args:
        size: Width and height of an image [pixel].
        share: Share of the box inside the visual hull.
        options: Iterations, angles and steps.
        views: How many.
    """
    if options.coherence == "none" or options.method != "appearance-transfer":
        return estimate_cost(size, share, options)[0]
    few = replace(options, iterations=options.coherent_iterations)
    return estimate_cost(size, share, few)[0] + views * size[0] * size[1] * SECONDS_A_FLOW_PIXEL


def estimate_run(frames: int, first: float, others: float, options: ReconstructOptions) -> float:
    """Return seconds for a run with film and page.

    Args:
        frames: How many.
        first: Seconds for a frame that starts anew, the first of a piece.
        others: Seconds for each of the others.
        options: A piece is led up to by frames that are not kept.
    """
    is_coherent = options.coherence == "flow" and options.method == "appearance-transfer"
    begins = range(0, frames, options.piece or frames) if is_coherent else range(1)
    led = sum(min(options.overlap, begin) for begin in begins)
    made = len(begins) * first + (frames + led - len(begins)) * others
    return made + SECONDS_OF_FILM + min(frames, SHOWN_FRAMES) * SECONDS_OF_PAGE


def affordable_width(
    size: tuple[int, int], frames: int, share: float, options: ReconstructOptions, views: int
) -> tuple[int, float] | None:
    """Return a width at which a long run takes minutes, and its seconds; None if the run is short as it is.

    Args:
        size: Width and height of an image [pixel].
        frames: How many.
        share: Share of the box inside the visual hull.
        options: Iterations, angles and steps.
        views: How many.
    """
    memory = memory_limit() / 2

    def cost(width: int) -> tuple[float, int]:
        smaller = width, max(1, round(width * size[1] / size[0]))
        first, needed = estimate_cost(smaller, share, options)
        return estimate_run(frames, first, estimate_carried(smaller, share, options, views), options), needed

    seconds, needed = cost(size[0])
    if seconds <= LONG and needed <= memory:
        return None
    widths = [width for width in range(NARROWEST, size[0], WIDTH_STEP) if cost(width)[1] <= memory]
    fits = [width for width in widths if cost(width)[0] <= MINUTES] or widths[:1]
    return (fits[-1], cost(fits[-1])[0]) if fits else None


def check_cost(size: tuple[int, int], share: float, options: ReconstructOptions, device) -> None:
    """Refuse a reconstruction that there is no memory for.

    Args:
        size: Width and height of an image [pixel].
        share: Share of the box inside the visual hull.
        options: Choices of the method.
        device: Where it will run, a Warp device.

    Raises:
        ValueError: If the memory does not suffice; it names the largest width that would do.
    """
    angles = replace(options, angles=options.angles or default_angles(size[0]))
    told = {"what": "the volumes", "way_out": "reduce the footage, --resolution {width} or less"}
    check_memory(lambda smaller: estimate_cost(smaller, share, angles)[1], size, device, **told)


def format_duration(seconds: float) -> str:
    """Return a time as people say it: 4.2 s, 90 s, 12 min, 3.5 h."""
    for unit, length in (("h", 3600), ("min", 60)):
        if seconds >= 2 * length:
            return f"{seconds / length:.2g} {unit}" if seconds < 100 * length else f"{seconds / length:.0f} {unit}"
    return f"{seconds:.2g} s" if seconds < 10 else f"{seconds:.0f} s"


def _round_hull(image: np.ndarray, angle: float, x: np.ndarray, z: np.ndarray, radius: float) -> np.ndarray:
    """Return a circle about the bulk of each row's light, shape (x, z, v)."""
    share = np.cumsum(image, axis=0) / np.maximum(image.sum(axis=0), 1e-6)
    left, right = (share < BULK).sum(axis=0), (share < 1 - BULK).sum(axis=0)
    along = np.cos(angle) * x + np.sin(angle) * z
    depth = np.cos(angle) * z - np.sin(angle) * x
    centre = (left + right) / 2 - (len(image) - 1) / 2
    reach = radius * (right - left) / 2 + 1.5
    return (along[..., None] - centre) ** 2 + depth[..., None] ** 2 <= reach**2
