"""How much memory a simulation takes: bytes a voxel, measured by ``examples/benchmarks/scale.py`` and beside it."""

from warpfluid.memory import check_memory
from warpfluid.options import SimulateOptions
from warpfluid.settings import SimulateSettings
from warpfluid.volumes import VolumeSequence

FLUID = 75  # velocity, density, heat, fuel, flame, and what carries them
FORCES = 20  # swirl and turbulence
FOLLOWED_FORCES = 110  # the same beside volumes and the motion that leads
COMBUSTION = 30
LIQUID = 45
SOLIDS = 50
DETAIL = 58  # of a voxel of the files


def bytes_needed(voxels: int, options: SimulateOptions, *, followed: bool, solids: bool) -> int:
    """Return the memory that a simulation takes [byte].

    Args:
        voxels: Of the simulation.
        options: What is simulated.
        followed: Volumes lead it.
        solids: Something stands or floats in it.
    """
    each = FLUID
    if options.swirl != 0 or options.turbulence_strength != 0:
        each += FOLLOWED_FORCES if followed else FORCES
    each += COMBUSTION * options.combustion + SOLIDS * solids
    each += LIQUID * (options.liquid_weight != 0)
    each += DETAIL * options.detail**3 if options.detail > 1 else 0
    return voxels * each


def check_need(settings: SimulateSettings, volumes: VolumeSequence | None, device) -> None:
    """Refuse a simulation that there is no memory for.

    Args:
        settings: What is simulated.
        volumes: What leads it; None for an empty box.
        device: Where it will run, a Warp device.

    Raises:
        ValueError: If the memory does not suffice; it names the largest box that would do.
    """
    options, scene = settings.simulate, settings.scene
    if volumes and volumes.shape:
        base = max(volumes.shape[0], volumes.shape[2]), volumes.shape[1]
    elif volumes:
        return
    else:
        base = settings.size
    solids = bool(scene.obstacle or scene.body)

    def bytes_of(size: tuple[int, int]) -> int:
        return bytes_needed(size[0] ** 2 * size[1], options, followed=volumes is not None, solids=solids)

    largest = "the largest box of width and height that fits has {size} voxels"
    way_out = f"{largest}: lower --resolution-scale" if volumes else f"{largest}: choose it with --size"
    size = tuple(round(n * options.resolution_scale) for n in base)
    check_memory(bytes_of, size, device, what="simulations of this size", way_out=way_out)
