"""The colour of hot soot: Planck's law seen by the standard observer.

The colour-matching functions are the sums of Gaussian lobes that Wyman, Sloan and Shirley fitted to CIE 1931 ("Simple
Analytic Approximations to the CIE XYZ Color Matching Functions", 2013); the matrix is that of IEC 61966-2-1 (sRGB).
"""

import numpy as np

SECOND_RADIATION = 1.438776877e-2  # h c / k [m K]
WAVELENGTHS = np.arange(360.0, 831.0, 2.0)  # [nm]
# Of each function: height, centre [nm], inverse widths below and above it [1/nm].
LOBES = (
    ((1.056, 599.8, 0.0264, 0.0323), (0.362, 442.0, 0.0624, 0.0374), (-0.065, 501.1, 0.0490, 0.0382)),
    ((0.821, 568.8, 0.0213, 0.0247), (0.286, 530.9, 0.0613, 0.0322)),
    ((1.217, 437.0, 0.0845, 0.0278), (0.681, 459.0, 0.0385, 0.0725)),
)
XYZ_TO_RGB = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def blackbody_color(kelvin: np.ndarray) -> np.ndarray:
    """Return the colour of a black body at luminance 1, in linear sRGB.

    Below some 1900 K it is redder than any screen shows; what would be negative there is 0.

    Args:
        kelvin: Temperatures [K], shape (n,).

    Returns:
        Red, green and blue, shape (n, 3).
    """
    color = np.maximum(_tristimulus(kelvin) @ XYZ_TO_RGB.T, 0)
    return color / (color @ LUMINANCE)[:, None]


def _tristimulus(kelvin: np.ndarray) -> np.ndarray:
    """Return X, Y, Z in a unit of their own for every temperature, shape (n, 3)."""
    kelvin = np.asarray(kelvin, np.float64)[:, None]
    metres = WAVELENGTHS * 1e-9
    exponent = SECOND_RADIATION / (metres * kelvin)
    # Against the longest wavelength's, so that nothing underflows when it is cold.
    radiance = (metres[-1] / metres) ** 5 * np.exp(exponent[:, -1:] - exponent) / -np.expm1(-exponent)
    return radiance @ np.stack([_matching(lobes) for lobes in LOBES], axis=1)


def _matching(lobes: tuple) -> np.ndarray:
    """Return a colour-matching function at all wavelengths."""
    total = np.zeros_like(WAVELENGTHS)
    for height, centre, below, above in lobes:
        off = WAVELENGTHS - centre
        total += height * np.exp(-0.5 * (off * np.where(off < 0, below, above)) ** 2)
    return total
