"""Every choice a run can make: the paper's numbers, explained.

The command line makes its flags from these classes, and ``run.toml`` stores them. Defaults are what gives the
best volumes; ``ReconstructOptions.paper()`` sets everything to the paper's choices.
"""

import math
from dataclasses import dataclass, replace
from typing import Annotated, Literal

from warpfluid.options.checks import check_options

BRIGHT_FLAME = 1 / 3  # share of the lit pixels above grey level 200
FLAME_SHOULDER = 3.5
NOISE = (0.3, 2.0, 2.0)  # log-amplitude, grain across and along the height [voxel]
FLAME_NOISE = (1.0, 3.0, 8.0)
FEWEST_ANGLES = 180
MUTATIONS_A_VOXEL = 500  # of the hull
MUTATIONS_A_VOXEL_AND_E_STEP = 20
ANGLES_A_VOXEL = 0.25  # of width; below 0.2 there are streaks


@dataclass(frozen=True, kw_only=True)
class InputOptions:
    """How pictures become grey images of light on black."""

    frames: Annotated[
        str | None, "Frames to use, such as 1001-1024, 1-100x2 or 1,5,9; all that every view has by default"
    ] = None
    resolution: Annotated[str | None, "Size of a picture, WIDTH or WIDTHxHEIGHT; larger footage is reduced to it"] = (
        None
    )
    crop: Annotated[str | None, "Part of the picture to use, WIDTHxHEIGHT+LEFT+TOP in its pixels"] = None
    decode: Annotated[
        Literal["none", "srgb", "rec709"],
        "Tone curve to undo before the luminance is taken; float images are linear already",
    ] = "none"
    black_level: Annotated[float, "Grey level of the empty background, taken off every pixel [0-254]"] = 0.0
    background: Annotated[
        str | None, "Picture of the empty set to take off, or `median` for the median over the frames"
    ] = None
    largest_component: Annotated[bool, "Keep the largest connected lit region only: sparks and props go"] = False
    white: Annotated[
        float | None,
        "Pixel value that becomes 255; by default full range for integer footage, the brightest pixel for float",
    ] = None
    equalize_rows: Annotated[
        bool, "Give every view the same total in each image row, as light that no medium absorbs has"
    ] = True
    align: Annotated[
        Literal["none", "auto"],
        "auto: find when the other views play against the first, how high, how large and how bright, from row sums",
    ] = "none"
    align_subframe: Annotated[bool, "Let auto find parts of frames, too: two pictures are then blended"] = False
    view_time: Annotated[str | None, "Frames by which views play later, such as 90=3 or 90=3,-60=-1.5"] = None
    view_shift: Annotated[str | None, "Pixels of the footage by which the pictures of views move up: 90=2.5"] = None
    view_scale: Annotated[
        str | None, "How much larger the pictures of views are drawn, about their middle: 90=1.02"
    ] = None
    view_gain: Annotated[str | None, "By what the light of views is multiplied: 90=1.25"] = None

    def __post_init__(self):
        check_options(self)


@dataclass(frozen=True, kw_only=True)
class ReconstructOptions:
    """The reconstruction of Section 3."""

    method: Annotated[
        Literal["appearance-transfer", "lsm", "stochastic", "convex", "multiplication", "flame-sheet"],
        "appearance-transfer, or what it is compared with: least squares alone (Eq. 3), stochastic tomography and its "
        "energy's minimum by a convex solver, the multiplication and the flame sheet of Hasinoff and Kutulakos",
    ] = "appearance-transfer"
    start: Annotated[
        Literal["lsm", "multiplication", "flame-sheet"], "What appearance transfer starts from: lsm is Eq. 3"
    ] = "lsm"
    iterations: Annotated[int, "EM iterations; 5 serve for a preview"] = 8
    angles: Annotated[
        int | None,
        "Views that appearance is transferred to; from the width by default, 180 for the paper's sizes",
    ] = None
    # time
    coherence: Annotated[
        Literal["flow", "none"],
        "flow: a frame starts from the one before, carried along by the footage; none: frames alone (the paper)",
    ] = "flow"
    coherent_iterations: Annotated[int, "EM iterations of a carried frame; 2 are crisper and less calm"] = 1
    flow: Annotated[
        Literal["nltv-ncc", "ilk", "tvl1"],
        "Optical flow: non-local TV with cross-correlation (the paper), iterative Lucas-Kanade, or TV-L1",
    ] = "ilk"
    piece: Annotated[
        int | None, "Cut a coherent shot into pieces of so many pictures, which spread over processes; whole by default"
    ] = None
    overlap: Annotated[int, "Pictures over which a piece fades into the next, which starts that much earlier"] = 4
    # rays
    footprint: Annotated[
        Literal["box", "joseph"], "What a voxel looks like to a ray: box conserves light in every view"
    ] = "box"
    # E-step
    e_step: Annotated[
        Literal["least-squares", "stochastic"], "How a volume is fitted: conjugate gradients, or random walks (slow)"
    ] = "least-squares"
    cg_steps: Annotated[int, "Conjugate gradient steps of an E-step"] = 5
    lsm_steps: Annotated[int, "Conjugate gradient steps of the initial volume (Eq. 3)"] = 12
    preconditioner: Annotated[
        Literal["ramp", "none"], "ramp lets few steps reach fine horizontal detail; none is plain CG"
    ] = "ramp"
    blur: Annotated[float, "Standard deviation of the 3D blur that ends an E-step [voxel]"] = 0.4
    input_weight: Annotated[float, "Weight of a measured view against a made one"] = 10.0
    non_negative: Annotated[bool, "Clip negative density after every solve"] = True
    row_sums: Annotated[bool, "Give made views the row sums of the measured ones"] = True
    slice_rescale: Annotated[bool, "Rescale every horizontal slice to the measured row sum after an E-step"] = False
    balance: Annotated[int, "Multiplicative sweeps that make the measured views exact after an E-step"] = 2
    balance_power: Annotated[float, "Exponent of the ratio in balancing, 0-1; lower is milder where views disagree"] = (
        1.0
    )
    fade: Annotated[float, "Share of black views at which a voxel has faded to nothing; 0 is off"] = 0.5
    fade_blur: Annotated[float, "Smoothing of that share [voxel]"] = 1.5
    # stochastic tomography and the convex solver
    sad_weight: Annotated[
        float, "Weight of the sum of absolute differences between neighbours, beside squared grey levels"
    ] = 1.0
    mutations: Annotated[
        int | None, "Proposals of all random walks; by default 500 a voxel of the hull, 20 in an E-step"
    ] = None
    chains: Annotated[int, "Number of random walks"] = 10000
    quantum: Annotated[float, "Light that the first proposals add or take [grey level]; the last ones a 256th"] = 4.0
    convex_steps: Annotated[int, "Primal-dual steps of the convex solver"] = 500
    # visual hull and start
    threshold: Annotated[float, "Grey level above which a pixel belongs to the silhouette [0-255]"] = 1.0
    hull: Annotated[
        Literal["auto", "silhouette", "round"],
        "silhouette: what all views see; round: circles about one view's bulk; auto: round for one view",
    ] = "auto"
    hull_radius: Annotated[float, "Radius of the round hull over half the bulk's width"] = 1.7
    start_noise: Annotated[
        float | None,
        "Log-amplitude of the initial volume's noise; 0 is off; 0.3 by default, 1 for one bright flame",
    ] = None
    noise_grain: Annotated[float | None, "Scale of that noise [voxel]; 2 by default, 3 for one bright flame"] = None
    noise_grain_y: Annotated[
        float | None, "Its scale along the height; the same by default, 8 for one bright flame"
    ] = None
    seed: Annotated[int, "Seed of noise and random walks, the same for all frames"] = 0
    # M-step
    transfer: Annotated[
        Literal["histograms", "texture-optimization", "portilla-simoncelli"],
        "How views get the inputs' look: histograms of a pyramid's bands (the paper), patches of the inputs, or how "
        "coefficients go together (Portilla and Simoncelli)",
    ] = "histograms"
    patch: Annotated[int, "Size of a patch of texture optimisation [pixel]"] = 16
    sweeps: Annotated[int, "Sweeps over the statistics of portilla-simoncelli in an M-step"] = 2
    scales: Annotated[int | None, "Scales of the steerable pyramid; from the picture's size by default"] = None
    highpass: Annotated[
        Literal["parted", "whole"],
        "Finest detail of the pyramid: parted by direction, or one band (the paper), which leaves combs of level lines",
    ] = "parted"
    interpolation: Annotated[
        Literal["density", "quantile", "hybrid", "nearest", "first"],
        "How histograms of neighbouring inputs mix: density is Eq. 4",
    ] = "density"
    # one view
    stand_in: Annotated[
        Literal["mirror", "front", "measured"],
        "One view: the side looks like the mirrored front, like the front, or is the front, measured (the paper)",
    ] = "mirror"
    shoulder: Annotated[
        float | None,
        "Strength of a film-like tone curve to undo; 0 is off, the default; 3.5 for one view of a bright flame",
    ] = None

    def __post_init__(self):
        check_options(self)

    @classmethod
    def paper(cls, **changes) -> "ReconstructOptions":
        """Return the paper's choices, with ``changes`` on top."""
        return cls(**PAPER | changes)

    def settled(self, *, views: int, width: int, bright: float) -> "ReconstructOptions":
        """Return the options with the choices made that depend on the footage.

        One view of a flame whose core film has compressed to a flat white asks for a disc with a bright rim, crossed by
        chords. Undoing the tone curve, and starting from longer and stronger noise, gives filaments instead.

        Args:
            views: Number of views.
            width: Width of an image [pixel].
            bright: Share of the lit pixels above grey level 200; the same for all frames of a shot, or it flickers.

        Raises:
            ValueError: If an option does not suit the number of views.
        """
        if views > 1 and self.hull == "round":
            raise ValueError("hull is round, which one view needs; with several leave it at auto")
        shoulder = self.shoulder
        if shoulder is None:
            shoulder = FLAME_SHOULDER if views == 1 and bright > BRIGHT_FLAME else 0.0
        noise, grain, grain_y = FLAME_NOISE if views == 1 and shoulder > 0 else NOISE
        if self.noise_grain is not None:
            grain = grain_y = self.noise_grain
        return replace(
            self,
            shoulder=shoulder,
            start_noise=noise if self.start_noise is None else self.start_noise,
            noise_grain=grain,
            noise_grain_y=grain_y if self.noise_grain_y is None else self.noise_grain_y,
            angles=self.angles or default_angles(width),
        )


@dataclass(frozen=True, kw_only=True)
class OutputOptions:
    """What is written for a frame and for the run."""

    half: Annotated[bool, "Store density in half precision: half the size, three digits"] = False
    up: Annotated[Literal["y", "z"], "Axis that points up in the files: y for Houdini and Maya, z for Blender"] = "y"
    voxel_size: Annotated[float, "Edge of a voxel in the units of the scene"] = 0.01
    drop_below: Annotated[float, "Density not stored, as a part of the frame's maximum"] = 1e-4
    look: Annotated[
        Literal["fire", "smoke", "explosion", "blackbody", "water", "gray", "jet"],
        "Colours of the turntable and the report, and the look of render",
    ] = "fire"
    turntable: Annotated[bool, "Write turntable.mp4"] = True
    report: Annotated[bool, "Write report.html"] = True

    def __post_init__(self):
        check_options(self)


PAPER = {
    "angles": 180,
    "coherence": "none",
    "flow": "nltv-ncc",
    "preconditioner": "none",
    "input_weight": 10.0,
    "row_sums": False,
    "slice_rescale": True,
    "balance": 0,
    "fade": 0.0,
    "highpass": "whole",
    "start_noise": 0.0,
    "hull": "silhouette",
    "stand_in": "measured",
    "shoulder": 0.0,
}


def default_angles(width: int) -> int:
    """Return how many views appearance is transferred to: 180, and more for volumes wider than 720 voxels."""
    return max(FEWEST_ANGLES, math.ceil(ANGLES_A_VOXEL * width))
