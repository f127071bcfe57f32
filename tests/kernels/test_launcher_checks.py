"""No launcher lets a wrong array through: Warp would read garbage from it, or crash."""

import inspect
from importlib import import_module
from pkgutil import walk_packages

import numpy as np
import pytest
import warp as wp

from warpfluid import kernels
from warpfluid.device import pick_device
from warpfluid.kernels import advection, blur, coarsen, vectors
from warpfluid.kernels.flow import correlation, flow_lift, optical_flow, pair_prices, pictures
from warpfluid.kernels.fluid import (
    centres,
    combustion,
    correction,
    decay,
    diffusion,
    disagreement,
    emission,
    fine_paths,
    guidance,
    probe,
    shapes,
    spline,
    surface,
    totals,
    tracing,
    transport,
)
from warpfluid.kernels.forces import air, eddies, edges, lattice, pushes, ramp, reach, swirl, turbulence
from warpfluid.kernels.light import bricks, curves, lamps, march, scattered, shadow, surfaces
from warpfluid.kernels.poisson import coefficients, modes, multigrid, pressure, shares, squeeze, walls
from warpfluid.kernels.sides import CLOSED, OPEN, SIX
from warpfluid.kernels.tomography import filling, projection, sad, stochastic, visual_hull
from warpfluid.projector import directions

N, HEIGHTS, ANGLES = 6, 50, [0.0, 30.0, 90.0]
SLABS = -(-HEIGHTS // stochastic.SLAB)


def floats(*shape):
    return lambda device: wp.full(shape, 1.0, dtype=float, device=device)


def vectors_of(*shape):
    return lambda device: wp.zeros(shape, dtype=wp.vec3, device=device)


def bytes_(*shape):
    return lambda device: wp.full(shape, 1, dtype=wp.uint8, device=device)


def whole(*shape):
    return lambda device: wp.zeros(shape, dtype=int, device=device)


def fan(device):
    return directions(np.array(ANGLES), pick_device(device))


def runs(device):
    return visual_hull.occupied_runs(volume(device))


def spans(device):
    return projection.ray_spans(fan(device), runs(device), HEIGHTS, width=N)


def table(device):
    return wp.zeros((N, 4), dtype=int, device=device)


volume = floats(N, N, HEIGHTS)
images = floats(len(ANGLES), N, HEIGHTS)
picture = floats(N, HEIGHTS)
silhouettes = bytes_(len(ANGLES), N, HEIGHTS)
pair = {"a": volume, "b": volume}
paths = floats(3, N, N, HEIGHTS)
on_faces = {
    "velocity_x": floats(N + 1, N, HEIGHTS),
    "velocity_z": floats(N, N + 1, HEIGHTS),
    "velocity_y": floats(N, N, HEIGHTS + 1),
}
on_edges = {
    "edges_x": floats(N, N + 1, HEIGHTS + 1),
    "edges_z": floats(N + 1, N, HEIGHTS + 1),
    "edges_y": floats(N + 1, N + 1, HEIGHTS),
}
placed = {"sides": SIX(OPEN, OPEN, OPEN, OPEN, CLOSED, OPEN), "place": 3}
stepped = {"sides": placed["sides"], "time_step": 0.1}

# What launchers share; all other files of the package are launchers.
SHARED = {"checks", "launch", "sampling", "sides", "fluid.faces", "fluid.places", "forces.random_waves"}
FOUND = [module for module in walk_packages(kernels.__path__, "warpfluid.kernels.") if not module.ispkg]
LAUNCHING = sorted({module.name.removeprefix("warpfluid.kernels.") for module in FOUND} - SHARED)


def scene(device):
    """Fog in front of a camera."""
    found = march.Scene()
    found.camera = wp.array([*range(12), 1, 0, 0, 0], dtype=wp.float64, device=device)
    found.f0 = found.f1 = found.f2 = found.f3 = volume(device)
    found.extinction, found.emission = floats(2, 1)(device), floats(2, 3)(device)
    found.bricks, found.field_count, found.error = floats(1, 1, 7)(device), 1, 0.1
    return found


# Every public launcher: its arrays by name, and its other arguments.
LAUNCHERS = {
    blur.blur: ({"field": volume, "scratch": volume, "out": volume}, {"sigma": 1.0}),
    projection.ray_spans: ({"directions": fan, "occupied": runs}, {"heights": HEIGHTS, "width": N}),
    projection.project: (
        {"volume": volume, "directions": fan, "spans": spans, "out": images},
        {"footprint": "box"},
    ),
    projection.backproject: (
        {
            "images": images,
            "directions": fan,
            "weights": floats(len(ANGLES)),
            "hull": volume,
            "occupied": runs,
            "out": volume,
        },
        {"footprint": "box"},
    ),
    bricks.brick_maxima: ({"field": volume, "out": floats(1, 1, 7)}, {}),
    march.march_rays: (dict.fromkeys(("color", "emission", "sums"), floats(5, 4, 3)), {"scene": scene}),
    blur.convolve: ({"field": volume, "scratch": volume, "out": volume}, {"taps": (None, None, None)}),
    advection.advect: (
        {"field": volume, "velocity_x": volume, "velocity_z": volume, "velocity_y": volume, "out": volume},
        {},
    ),
    guidance.guide: ({"velocity": volume, "low": volume, "target": volume}, {"weight": 1.0}),
    guidance.blend: ({"density": volume, "volume": volume}, {"add": 0.2}),
    disagreement.quicken: ({"share": volume, "density": volume, "volume": volume}, {"factor": 2.0}),
    eddies.limit_reach: (
        {"squares": volume, "cover": volume, "out": volume},
        {"faint": 0.1, "gain": 1.0, "limit": 2.0},
    ),
    eddies.lay_tile: (
        {
            "tile": vectors_of(4, 4, 4),
            "size": volume,
            "away_x": volume,
            "away_z": volume,
            "away_y": volume,
            "out": vectors_of(2 * N, 2 * N, 2 * HEIGHTS),
        },
        {"offset": (0.0, 0.0, 0.0), "nodes_a_voxel": 1.0, "gain": 1.0, "factor": 2},
    ),
    eddies.curl: ({"potential": vectors_of(N, N, HEIGHTS), "out": vectors_of(N, N, HEIGHTS)}, {"scale": 0.5}),
    fine_paths.follow_back: ({"flow": vectors_of(N, N, HEIGHTS), "out": vectors_of(N, N, HEIGHTS)}, {"steps": 2}),
    fine_paths.sample: (
        {
            "field": volume,
            "path": vectors_of(2 * N, 2 * N, 2 * HEIGHTS),
            "cover": volume,
            "out": floats(2 * N, 2 * N, 2 * HEIGHTS),
        },
        {"factor": 2},
    ),
    guidance.mix: ({"field": volume, "other": volume, "share": volume}, {}),
    centres.to_centres: ({"component": floats(N + 1, N, HEIGHTS)}, {"axis": 0}),
    centres.measure_speed: (on_faces, {}),
    ramp.look_up: ({"field": volume, "out": volume}, {"inputs": np.array([0.0, 1.0]), "values": np.array([0.0, 2.0])}),
    reach.make_reach: (
        {"out": volume},
        {"centre": (3.0, 3.0, 3.0), "radius": 2.0, "sides": SIX(OPEN, OPEN, OPEN, OPEN, CLOSED, OPEN)},
    ),
    guidance.to_faces: ({"field": volume, "out": floats(N + 1, N, HEIGHTS)}, {"axis": 0, "scale": 1.0}),
    combustion.burn_fuel: (
        {"fuel": volume, "temperature": volume, "density": volume, "flame": volume, "out": volume},
        {"burn_rate": 1.0, "ignition": 0.1, "hottest": 2.0, "heat": 0.1, "smoke": 1.0, "expansion": 0.1}
        | {"flame_decay": 1.0, "time_step": 0.1},
    ),
    decay.decay: ({"field": volume}, {"rate": 1.0, "time_step": 0.1}),
    decay.radiate: ({"temperature": volume}, {"rate": 1.0, "hottest": 1.0, "time_step": 0.1}),
    decay.thin: ({"field": volume, "divergence": volume}, {"time_step": 0.1}),
    decay.make_mask: ({"density": volume, "out": volume}, {"reference": 1.0}),
    edges.mask_edges: ({**on_edges, "mask": volume}, {"sides": placed["sides"]}),
    edges.add_curl: ({**on_faces, **on_edges}, {"sides": placed["sides"]}),
    lattice.interpolate: (
        {"tile": volume, "out": volume},
        {"first": (0.0, 0.0, 0.0), "spacing": (2.0, 2.0, 2.0), "gain": 1.0},
    ),
    air.add_buoyancy: (
        {**on_faces, "temperature": volume, "density": volume},
        {"up": (0, 0, 9.8), "temperature_buoyancy": 1.0, "density_buoyancy": 1.0, "reference": 1.0} | stepped,
    ),
    air.add_wind: ({**on_faces, "mask": volume}, {"rate": 1.0} | stepped),
    pushes.add_push: (on_faces, {"kind": "radial", "strength": 1.0, "radius": 2.0} | stepped),
    swirl.add_swirl: ({**on_faces, "mask": volume}, {"strength": 1.0} | stepped),
    turbulence.add_turbulence: (
        {**on_faces, "mask": volume},
        {"strength": 1.0, "frequency": 0.1, "phase": 0.0, "octaves": 1, "seed": 0} | stepped,
    ),
    filling.missing: ({"picture": images, "rendered": images, "out": images}, {"slack": 1.2}),
    filling.widen: ({"lack": volume, "total": volume, "seen": volume}, {}),
    filling.fill: ({"volume": volume, "lack": volume, "source": volume}, {"gain": 2.0}),
    flow_lift.lift: ({"flow_u": images, "flow_v": images, "directions": fan}, {"shape": (N, N, HEIGHTS)}),
    coefficients.face_coefficient: (
        {"open": floats(N, N + 1, HEIGHTS), "mass": volume, "out": floats(N, N + 1, HEIGHTS)},
        {"axis": 1, "sides": placed["sides"]},
    ),
    coefficients.coarsen_coefficient: (
        {"fine": floats(N, N + 1, HEIGHTS), "out": floats(N // 2, N // 2 + 1, HEIGHTS // 2)},
        {"axis": 1, "sides": placed["sides"]},
    ),
    multigrid.apply: (
        dict.fromkeys(("field", "right", "scale", "out"), volume)
        | {name: on_faces[f"velocity_{name[2:]}"] for name in ("c_x", "c_z", "c_y")},
        {"sides": placed["sides"]},
    ),
    multigrid.combine: (
        {"field": volume, "source": table, "weight": floats(N, 4), "scale": volume, "out": volume},
        {"axis": 1},
    ),
    pressure.add_flux: (
        {name: floats(N, N + 1, HEIGHTS) for name in ("velocity", "open", "solid")} | {"out": volume},
        {"axis": 1},
    ),
    pressure.subtract_gradient: (
        {name: floats(N, N + 1, HEIGHTS) for name in ("coefficient", "open", "velocity")} | {"pressure": volume},
        {"axis": 1, "sides": placed["sides"]},
    ),
    squeeze.measure_squeeze: (
        {f"{name}_{axis}": on_faces[f"velocity_{axis}"] for name in ("open", "solid") for axis in "xzy"}
        | {"fluid": volume, "out": volume},
        {"sides": placed["sides"]},
    ),
    modes.change_basis: ({"field": volume, "modes": floats(N, N), "out": volume}, {"axis": 1}),
    modes.invert_laplacian: (
        {"values_x": floats(N), "values_z": floats(N), "values_y": floats(HEIGHTS), "out": volume},
        {},
    ),
    walls.clear_solid: ({"fluid": volume, "out": volume}, {}),
    walls.hold_walls: ({"velocity": volume}, {"axis": 1, "sides": placed["sides"]}),
    diffusion.spread: ({"field": volume, "scratch": volume, "out": volume}, placed | {"variance": 0.5}),
    totals.scale: ({"field": volume}, {"factor": 2.0}),
    totals.total: ({"field": volume}, {}),
    spline.carry_spline: ({"field": volume, "path": paths, "out": volume}, placed),
    tracing.trace: ({**on_faces, "out": paths}, placed | {"time_step": 0.1}),
    transport.carry: ({"field": volume, "path": paths, "out": volume}, placed),
    correction.correct: (
        {"field": volume, "carried": volume, "back": paths, "forth": paths, "out": volume},
        placed,
    ),
    correction.mend: ({"field": volume, "carried": volume, "path": paths, "out": volume}, placed),
    transport.limit: ({"field": volume, "path": paths, "out": volume}, placed),
    shapes.unite: ({"out": volume}, {"shape": shapes.PlacedShape(), "first": (0.0, 0.0, 0.0)}),
    shapes.nearest_velocity: (
        {"nearest": volume, "velocity": volume},
        {"shape": shapes.PlacedShape(), "axis": 1, "first": (0, 0, 0)},
    ),
    shares.face_share: (
        {"corners": floats(N + 1, N + 1, HEIGHTS + 1), "out": floats(N, N, HEIGHTS + 1)},
        {"axis": 2, "first": (0, 0, 0)},
    ),
    shares.voxel_share: ({"corners": floats(N + 1, N + 1, HEIGHTS + 1), "out": volume}, {"first": (0, 0, 0)}),
    shares.hold: ({"velocity": volume, "opening": volume, "solid": volume}, {}),
    shares.empty_covered: ({"field": volume, "fluid": volume}, {}),
    surface.sharpen: (
        {"field": volume, "inwards": vectors_of(N, N, HEIGHTS), "out": volume},
        {"sides": placed["sides"], "reference": 1.0, "width": 0.5, "time_step": 0.1},
    ),
    emission.cover: ({"share": volume}, {}),
    emission.soften: ({"distance": volume}, {"width": 2.0}),
    emission.let_in: (
        {"weight": volume, "density": volume, "fuel": volume, "temperature": volume},
        {"first": (0, 0, 0), "added": (1.0, 1.0), "hot": 1.0, "noise": (1.0, 0.1, 0.0)},
    ),
    emission.drive: (
        {"weight": volume, "velocity": floats(N, N + 1, HEIGHTS)},
        {"axis": 1, "first": (0, 0, 0), "target": 1.0, "rate": 1.0},
    ),
    probe.probe: (
        {"field": volume, "points": lambda device: wp.zeros(5, dtype=wp.vec3, device=device)},
        {"shift": (0.5, 0.0, 0.0)},
    ),
    vectors.dot: (pair, {}),
    vectors.divide: ({**pair, "out": volume}, {"floor": 0.1}),
    vectors.add_scaled: ({**pair, "out": volume}, {"factor": 2.0}),
    vectors.multiply: ({**pair, "out": volume}, {}),
    vectors.sharpen: (
        {"field": volume, "fine": volume, "coarse": volume, "mask": volume, "out": volume},
        {"fine_weight": 0.6, "coarse_weight": 0.3},
    ),
    vectors.clip: ({"field": volume}, {}),
    vectors.inverse_root: ({"a": volume, "out": volume}, {}),
    vectors.largest: ({"a": volume}, {}),
    vectors.ratio: (
        {"target": images, "rendered": images, "out": images},
        {"floor": 0.1, "cap": 4.0, "power": 1.0},
    ),
    vectors.apply_mean: ({"field": volume, "total": volume, "seen": volume}, {}),
    vectors.fade: ({"field": volume, "share": volume, "cover": volume}, {"limit": 0.5}),
    sad.sad: ({"volume": volume}, {}),
    sad.raise_dual: ({"volume": volume, "dual": paths}, {"step": 0.5, "weight": 1.0}),
    sad.lower_primal: (
        {"gradient": volume, "dual": paths, "hull": volume, "volume": volume, "ahead": volume},
        {"step": 0.1},
    ),
    sad.raise_views: ({"dual": images, "rendered": images, "wanted": images}, {"step": 0.5}),
    stochastic.walk: (
        {
            "volume": floats(HEIGHTS, N, N),
            "residual": floats(HEIGHTS, len(ANGLES), N),
            "hull": bytes_(HEIGHTS, N, N),
            "directions": fan,
            "weights": floats(len(ANGLES)),
            "counts": whole(SLABS),
            "places": whole(2 * SLABS, 3),
            "accepted": whole(SLABS),
        },
        {"quantum": 1.0, "sad": 1.0, "seed": 0, "sweep": 0},
    ),
    visual_hull.silhouette_hull: ({"lit": silhouettes, "directions": fan, "out": volume}, {}),
    visual_hull.occupied_runs: ({"hull": volume}, {}),
    correlation.expand: (
        {"now": picture, "later": picture, "flow": floats(2, N, HEIGHTS), "out": floats(5, N, HEIGHTS)},
        {"weight": 1.0},
    ),
    shadow.shadow: ({"extinction": volume, "out": volume}, {"direction": (1.0, 0.5, -2.0)}),
    coarsen.coarsen: ({"field": volume}, {"factor": 2}),
    coarsen.refine: ({"coarse": floats(N // 2, N // 2, HEIGHTS // 2), "out": volume}, {"factor": 2}),
    curves.look_up: (
        {"field": volume, "values": floats(3), "times": volume, "out": volume},
        {"top": 2.0},
    ),
    scattered.add_light: (
        {"transmittance": volume, "light": floats(7, N, N, HEIGHTS)},
        {"weight": 0.1, "radiance": (1.0, 2.0, 3.0)},
    ),
    scattered.scatter_again: (
        {
            "light": floats(7, N // 2, N // 2, HEIGHTS // 2),
            "field": volume,
            "albedo": lambda device: wp.zeros(2, dtype=wp.vec3, device=device),
            "suns": floats(2, N, N, HEIGHTS),
            "irradiance": lambda device: wp.zeros(2, dtype=wp.vec3, device=device),
        },
        {"factor": 2, "top": 1.0},
    ),
    lamps.light_of_lamps: (
        {
            "extinction": volume,
            "places": lambda device: wp.zeros(2, dtype=wp.vec4, device=device),
            "colors": lambda device: wp.zeros(2, dtype=wp.vec3, device=device),
        },
        {"spacing": 2.0},
    ),
    surfaces.see_surfaces: (
        {
            "camera": lambda device: wp.zeros(5, dtype=wp.vec3, device=device),
            "color": lambda device: wp.zeros((N, N), dtype=wp.vec3, device=device),
            "sums": lambda device: wp.zeros((N, N), dtype=wp.vec2, device=device),
        },
        {"stage": surfaces.Stage(), "perspective": True, "samples": 2},
    ),
    optical_flow.regularize: (
        {
            "flow": floats(2, N, HEIGHTS),
            "expansion": floats(5, N, HEIGHTS),
            "prices": floats(12, N, HEIGHTS),
            "steps": picture,
            "dual": floats(24, N, HEIGHTS),
        },
        {"iterations": 1},
    ),
    pair_prices.price_pairs: ({"picture": picture}, {}),
    pictures.median: ({"flow": floats(2, N, HEIGHTS), "out": floats(2, N, HEIGHTS)}, {}),
    pictures.resize: ({"field": images}, {"size": (3, 4)}),
}
OPTIONAL = {
    (surface.sharpen, "inwards"),
    (surface.sharpen, "out"),
    (ramp.look_up, "out"),
    (correlation.expand, "out"),
    (pictures.median, "out"),
    (advection.advect, "out"),
    (shadow.shadow, "out"),
    (curves.look_up, "times"),
    (curves.look_up, "out"),
    (bricks.brick_maxima, "out"),
    (blur.blur, "scratch"),
    (blur.blur, "out"),
    (blur.convolve, "scratch"),
    (blur.convolve, "out"),
    (combustion.burn_fuel, "out"),
    (decay.make_mask, "out"),
    (air.add_wind, "mask"),
    (diffusion.spread, "scratch"),
    (diffusion.spread, "out"),
    (multigrid.apply, "right"),
    (multigrid.apply, "scale"),
    (multigrid.combine, "scale"),
    (coefficients.face_coefficient, "mass"),
    (coefficients.face_coefficient, "open"),
    (pressure.subtract_gradient, "open"),
    (spline.carry_spline, "out"),
    (swirl.add_swirl, "mask"),
    (tracing.trace, "out"),
    (transport.carry, "out"),
    (correction.correct, "out"),
    (correction.mend, "out"),
    (turbulence.add_turbulence, "mask"),
    (visual_hull.silhouette_hull, "out"),
}
MAY_BE_SHORT = {
    (bricks.brick_maxima, "field"),  # within a brick
    (pair_prices.price_pairs, "picture"),
    (pictures.resize, "field"),
    (coarsen.coarsen, "field"),
    (lamps.light_of_lamps, "extinction"),
    (coarsen.refine, "out"),  # an odd number of voxels
    (curves.look_up, "values"),
    (scattered.scatter_again, "albedo"),
    (decay.decay, "field"),
    (lattice.interpolate, "tile"),
    (lattice.interpolate, "out"),
    (decay.radiate, "temperature"),
    (coefficients.coarsen_coefficient, "fine"),  # an odd number of voxels
    (walls.hold_walls, "velocity"),
    (totals.scale, "field"),
    (totals.total, "field"),
    (vectors.clip, "field"),
    (vectors.largest, "a"),
    (sad.sad, "volume"),
    (visual_hull.occupied_runs, "hull"),
    (projection.project, "volume"),  # a part of the box
    (projection.ray_spans, "occupied"),
    (projection.ray_spans, "directions"),
    (probe.probe, "field"),
    (probe.probe, "points"),
    (emission.cover, "share"),
    (emission.soften, "distance"),
    (emission.let_in, "weight"),  # a block
    (emission.drive, "weight"),
    (shapes.unite, "out"),  # any lattice
    (centres.to_centres, "component"),  # any shape
    (reach.make_reach, "out"),
    (eddies.lay_tile, "tile"),
    (shapes.nearest_velocity, "nearest"),  # a block
    (shares.face_share, "corners"),
    (shares.voxel_share, "corners"),
}


def strided(array):
    """The same numbers with gaps between them."""
    twice = wp.empty((*array.shape[:-1], 2 * array.shape[-1]), dtype=array.dtype, device=array.device)
    return twice[:, :, ::2] if array.ndim == 3 else twice[::2]


MISTAKES = {
    "None": lambda array: None,
    "NumPy": lambda array: array.numpy(),
    "short": lambda array: wp.empty((array.shape[0] - 1, *array.shape[1:]), dtype=array.dtype, device=array.device),
    "flat": lambda array: array.flatten() if array.ndim > 1 else array.reshape((1, -1)),
    "float64": lambda array: wp.zeros(array.shape, dtype=wp.float64, device=array.device),
    "strided": strided,
}


MAY_BE_FLAT = {
    (vectors.clip, "field"),
    (emission.cover, "share"),
    (emission.soften, "distance"),
    (totals.scale, "field"),
}
ALLOWED = {"None": OPTIONAL, "short": MAY_BE_SHORT, "flat": MAY_BE_FLAT}
CASES = [
    pytest.param(launcher, name, mistake, id=f"{launcher.__name__}-{name}-{mistake}")
    for launcher, (arrays, _) in LAUNCHERS.items()
    for name in arrays
    for mistake in MISTAKES
    if (launcher, name) not in ALLOWED.get(mistake, ())
]


def arguments(launcher, device):
    arrays, others = LAUNCHERS[launcher]
    others = {name: other(device) if callable(other) else other for name, other in others.items()}
    return {name: make(device) for name, make in arrays.items()} | others


@pytest.mark.parametrize("launcher", LAUNCHERS, ids=lambda launcher: launcher.__name__)
def test_takes_what_is_right(launcher, device):
    """Otherwise the refusals below would mean nothing."""
    launcher(**arguments(launcher, device))


@pytest.mark.parametrize(("launcher", "name", "mistake"), CASES)
def test_refuses_a_wrong_array(launcher, name, mistake, device):
    """Each array in turn is missing, short, of another type or layout."""
    kwargs = arguments(launcher, device)
    kwargs[name] = MISTAKES[mistake](kwargs[name])
    with pytest.raises(ValueError, match=r"\w"):
        launcher(**kwargs)


@pytest.mark.parametrize("launcher", LAUNCHERS, ids=lambda launcher: launcher.__name__)
def test_refuses_arrays_on_different_devices(launcher, device):
    """A kernel reads the memory of one device only."""
    kwargs = arguments(launcher, device)
    names = list(LAUNCHERS[launcher][0])
    others = [other for other in map(str, wp.get_devices()) if other != device]
    if not others or len(names) < 2:
        pytest.skip("needs a second device and a second array")
    kwargs[names[-1]] = kwargs[names[-1]].to(others[0])
    with pytest.raises(ValueError, match="device"):
        launcher(**kwargs)


@pytest.mark.parametrize("module", LAUNCHING)
def test_no_launcher_is_left_out(module):
    """A public function that takes arrays is in the table above."""
    module = import_module(f"warpfluid.kernels.{module}")
    public = {
        function
        for name, function in vars(module).items()
        if inspect.isfunction(function) and function.__module__ == module.__name__ and not name.startswith("_")
    }
    assert public <= set(LAUNCHERS)
