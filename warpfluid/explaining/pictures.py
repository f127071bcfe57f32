"""What pictures and videos hold."""

from pathlib import Path

import numpy as np


def explain_picture(path: Path) -> dict:
    """Return size, kind and range of a picture.

    Raises:
        ValueError: If it is damaged.
        OSError: If it cannot be read.
    """
    if path.suffix.lower() == ".hdr":
        from warpfluid.files.hdr import read_hdr

        pixels, depth = read_hdr(path), "float (RGBE)"
    else:
        from warpfluid.files.images import decode_image

        pixels, depth = decode_image(path)
    rows, columns = pixels.shape[:2]
    channels = pixels.shape[2] if pixels.ndim == 3 else 1
    told = {"kind": "picture", "size": [columns, rows], "channels": channels, "depth": str(depth)}
    return told | _range(pixels)


def explain_exr(path: Path) -> dict:
    """Return the parts and channels of an OpenEXR picture, each with its type and range.

    Raises:
        ValueError: If it is damaged.
        OSError: If it cannot be opened.
    """
    import OpenEXR

    from warpfluid.files.exr import read_exr

    read_exr(path)  # says what is wrong with a damaged one
    channels, parts = [], OpenEXR.File(str(path), separate_channels=True).parts
    warnings = []
    for part in parts:
        for name, channel in part.channels.items():
            found = _range(channel.pixels)
            warnings += [f"{name}: {text}" for text in found.pop("warnings")]
            channels.append({"name": name, "type": str(channel.pixels.dtype), **found})
    rows, columns = next(iter(parts[0].channels.values())).pixels.shape[:2]
    about = {name: str(value) for name, value in parts[0].header.items() if isinstance(value, int | float | str)}
    return {
        "kind": "OpenEXR picture",
        "size": [int(columns), int(rows)],
        "parts": len(parts),
        "channels": channels,
        "header": about,
        "warnings": warnings,
    }


def explain_video(path: Path) -> dict:
    """Return size, length and speed of a video or an animation.

    Raises:
        ValueError: If it is no video, or cut off.
        OSError: If it cannot be opened.
    """
    if path.suffix.lower() in (".webp", ".gif"):
        from PIL import Image

        with Image.open(path) as picture:
            frames = getattr(picture, "n_frames", 1)
            return {"kind": "animation", "size": list(picture.size), "count": frames, "warnings": []}
    from warpfluid.files.video import Video

    video = Video(path)
    seconds = video.count / video.rate if video.rate else None
    told = {"kind": "video", "size": list(video.size), "count": video.count, "rate": video.rate, "seconds": seconds}
    warnings = [] if video.rate else ["it tells no frames a second"]
    return told | {"depth": str(video.depth), "warnings": warnings}


def _range(pixels: np.ndarray) -> dict:
    finite = np.isfinite(pixels)
    sound = pixels[finite].astype(np.float64)
    unknown = int(np.count_nonzero(np.isnan(pixels)))  # infinite is where there is nothing, in a layer of depth
    warnings = [f"{unknown} values are NaN"] if unknown else []
    return {"range": [float(sound.min()), float(sound.max())] if sound.size else None, "warnings": warnings}
