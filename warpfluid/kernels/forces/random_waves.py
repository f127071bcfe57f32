"""Random waves of about one length that change in time: the eddies of a turbulent force.

A periodic lattice is filled with waves whose directions are all equally likely, whose lengths lie within half an
octave either side of one, and each of which turns its phase at its own random pace. So the pattern prefers no axis,
never repeats in time, and is as strong at any moment. It is worked out by a Fourier transform on a few nodes a wave,
which splines then join smoothly.
"""

import functools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

NODES_A_WAVE = 5  # what splines add between nodes is then below 2 %
TILE = 128  # nodes an axis: 25 waves before the pattern repeats
PACE = 2.0  # [rad] standard deviation of the phases' turn when phase grows by 1: 14 % of the pattern are left


class Lattice(NamedTuple):
    """A periodic lattice over a box.

    Attributes:
        nodes: How many before it repeats, along (x, z, y).
        spacing: Of the nodes [voxel].
    """

    nodes: tuple[int, int, int]
    spacing: tuple[float, float, float]

    def stretch(self, frequency: float) -> tuple[float, float, float]:
        """Return the spacing in parts of what a frequency [cycles/voxel] asks for, 1 unless an axis is wrapped."""
        return tuple(round(NODES_A_WAVE * frequency * spacing, 6) for spacing in self.spacing)


class Waves(NamedTuple):
    """Waves of one octave; half of them, the others are their mirror images.

    Attributes:
        index: Where they are in the transform's flat array, (waves,).
        cycles: Wave vectors [cycles/(1 / NODES_A_WAVE of the octave's wavelength)], (3, waves).
        amplitude: Of the coefficients of the splines, complex, (3, waves).
        power: Expected square of the wave itself and its mirror image, (waves,).
        pace: Turn of the phase, (3, waves).
    """

    index: np.ndarray
    cycles: np.ndarray
    amplitude: np.ndarray
    power: np.ndarray
    pace: np.ndarray


def lay_lattice(cells: tuple[int, int, int], frequency: float, wraps: tuple[bool, bool, bool]) -> Lattice:
    """Return a lattice for waves of a frequency [cycles/voxel], of whose period a wrapped axis is a multiple.

    Along a wrapped axis that is shorter than a wave the lattice has one node: the pattern does not change along it.
    """
    nodes, spacing = [], []
    for n, wrapped in zip(cells, wraps, strict=True):
        count = n * frequency * NODES_A_WAVE
        repeats = -(-count // TILE) if wrapped else 1.0
        fitting = int(count / repeats + 1e-6) if wrapped else TILE
        fitting = fitting if fitting >= NODES_A_WAVE else 1
        nodes.append(fitting)
        spacing.append(n / (repeats * fitting) if wrapped else 1 / (frequency * NODES_A_WAVE))
    return Lattice(tuple(nodes), tuple(spacing))


@functools.lru_cache(maxsize=8)
def make_waves(nodes: tuple[int, int, int], stretch: tuple[float, float, float], seed: int, octave: int) -> Waves:
    """Draw the waves of one octave.

    Args:
        nodes: Of the lattice.
        stretch: Spacing of its nodes in parts of 1 / ``NODES_A_WAVE`` of a wavelength.
        seed: Of the pattern.
        octave: Each has a pattern of its own.
    """
    turns = [np.fft.fftfreq(n) for n in nodes[:2]] + [np.fft.rfftfreq(nodes[2])]
    grid = np.meshgrid(*(t / s for t, s in zip(turns, stretch, strict=True)), indexing="ij", sparse=True)
    length = np.sqrt(sum(k**2 for k in grid))
    with np.errstate(divide="ignore"):
        off = np.log2(NODES_A_WAVE * length)
    index = np.flatnonzero(np.abs(off) < 0.5)
    places = np.unravel_index(index, length.shape)
    cycles = np.stack([t[p] / s for t, p, s in zip(turns, places, stretch, strict=True)])
    shape = np.cos(np.pi * off.flat[index]) / length.flat[index] ** 2  # the curl's energy then peaks in the middle
    response = np.prod([(2 + np.cos(2 * np.pi * t[p])) / 3 for t, p in zip(turns, places, strict=True)], axis=0)
    # Of waves level in y the transform takes the mean with their mirror images, which are here too.
    level = places[2] == 0
    rng = np.random.default_rng([seed, octave])
    draws = rng.standard_normal((3, index.size, 3))
    random = (draws[..., 0] + 1j * draws[..., 1]) * np.sqrt(0.5)
    amplitude = random * shape * np.where(level, np.sqrt(2), 1) / response
    return Waves(index, cycles, amplitude, shape**2 * np.where(level, 1, 2), PACE * draws[..., 2])


def draw_tiles(
    nodes: tuple[int, int, int], waves: Waves, phase: float, wanted: Sequence[np.ndarray] | None = None
) -> np.ndarray:
    """Return spline coefficients of the three components of the waves at a moment, float32 (3, x, z, y).

    An inverse transform, axis after axis; frequencies without waves and nodes that nobody wants are left out.

    Args:
        nodes: Of the lattice.
        waves: Of one octave, on this lattice.
        phase: How far the pattern has moved on.
        wanted: Which nodes to return along x, z and y; all by default.
    """
    x, z, y = (slice(None),) * 3 if wanted is None else wanted
    half = np.zeros((3, *nodes[:2], nodes[2] // 2 + 1), np.complex64)
    half.reshape(3, -1)[:, waves.index] = waves.amplitude * np.exp(1j * phase * waves.pace)
    highest = int((waves.index % half.shape[3]).max(initial=0))
    part = np.fft.ifft(half[..., : highest + 1], axis=1, norm="forward")[:, x]
    part = np.fft.ifft(part, axis=2, norm="forward")[:, :, z]
    return np.fft.irfft(part, nodes[2], axis=3, norm="forward")[..., y]


def window(first: float, spacing: float, count: int, nodes: int) -> tuple[int, np.ndarray]:
    """Return which nodes of a periodic lattice splines need along an axis.

    Args:
        first: Where the first of the elements lies [node].
        spacing: Of the nodes [element].
        count: How many elements there are.
        nodes: Of the lattice before it repeats.

    Returns:
        The node that the window begins with, and its nodes on the lattice; all of them, from 0, if many are needed.
    """
    begin, end = math.floor(first) - 2, math.floor(first + (count - 1) / spacing) + 4
    return (begin, np.arange(begin, end) % nodes) if end - begin < nodes else (0, np.arange(nodes))


def curl_size(waves: Waves, frequency: float) -> float:
    """Return the root mean square of the waves' curl, as differences from voxel to voxel make it.

    Args:
        waves: Of one octave.
        frequency: The octave's [cycles/voxel].
    """
    differences = 2 * np.sin(np.pi * NODES_A_WAVE * frequency * waves.cycles)
    return float(np.sqrt(2 * (differences**2).sum(0) @ waves.power))
