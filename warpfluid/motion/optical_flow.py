"""Motion between two pictures of one view."""

import numpy as np

METHODS = ("ilk", "tvl1")


def optical_flow(now: np.ndarray, later: np.ndarray, *, method: str = "ilk", white: float = 255.0) -> np.ndarray:
    """Measure the motion from one image to the next.

    Args:
        now: Image, shape (u, v).
        later: The next image, the same shape.
        method: ``ilk``, iterative Lucas-Kanade with a Gaussian window (Le Besnerais and Champagnat 2005), or ``tvl1``
            (Zach, Pock and Bischof 2007).
        white: Pixel value of white.

    Returns:
        Displacement along u and v [pixel/frame], shape (2, u, v).

    Raises:
        ValueError: If the method is unknown or the shapes differ.
    """
    from skimage.registration import optical_flow_ilk, optical_flow_tvl1

    if now.shape != later.shape:
        raise ValueError(f"later has shape {later.shape}, expected {now.shape} as now has")
    a, b = (image.astype(np.float32) / np.float32(white) for image in (now, later))
    if method == "ilk":
        flow = optical_flow_ilk(a, b, gaussian=True, num_warp=20)
    elif method == "tvl1":
        flow = optical_flow_tvl1(a, b, attachment=40)
    else:
        raise ValueError(f"method is {method!r}, expected one of {', '.join(METHODS)}")
    return np.asarray(flow, np.float32)
