"""Give a carried volume new matter where a picture shows something that it lacks."""

import warp as wp

from warpfluid.kernels.launch import elementwise

wp.set_module_options({"enable_backward": False})


@wp.kernel
def missing_kernel(picture: wp.array[float], rendered: wp.array[float], slack: float, out: wp.array[float]):
    """Take the share of a pixel's light that a rendering lacks."""
    i = wp.tid()
    out[i] = wp.clamp((picture[i] - slack * rendered[i]) / wp.max(picture[i], 1.0), 0.0, 1.0)


@wp.kernel
def widen_kernel(total: wp.array[float], seen: wp.array[float], out: wp.array[float]):
    """Keep the greater of a value and the mean of a back-projected one."""
    i = wp.tid()
    out[i] = wp.max(out[i], total[i] / wp.max(seen[i], 1.0e-6))


@wp.kernel
def fill_kernel(lack: wp.array[float], source: wp.array[float], gain: float, out: wp.array[float]):
    """Raise a volume to a part of another one."""
    i = wp.tid()
    out[i] = wp.max(out[i], wp.clamp(gain * lack[i], 0.0, 1.0) * source[i])


def missing(picture: wp.array, rendered: wp.array, *, slack: float, out: wp.array) -> wp.array:
    """Write (picture - slack rendered) / picture within 0 and 1; ``out`` may be ``rendered``."""
    return elementwise(missing_kernel, [picture, rendered, slack], out)


def widen(lack: wp.array, total: wp.array, seen: wp.array) -> wp.array:
    """Raise ``lack`` to total / seen where that is more, in place."""
    return elementwise(widen_kernel, [total, seen], lack)


def fill(volume: wp.array, lack: wp.array, source: wp.array, *, gain: float) -> wp.array:
    """Raise a volume to the part ``gain lack``, at most 1, of a source, in place."""
    return elementwise(fill_kernel, [lack, source, gain], volume)
