"""What launchers check: Warp itself compares types and dimensions, never shapes or devices."""

import warp as wp


def same_device(**arrays: wp.array) -> wp.Device:
    """Return the device that all arrays are on.

    Raises:
        ValueError: If something is no Warp array or the devices differ.
    """
    for name, array in arrays.items():
        if not isinstance(array, wp.array):
            raise ValueError(f"{name} is {type(array).__name__}, expected a Warp array: wrap it with wp.array(...)")
    devices = {str(array.device) for array in arrays.values()}
    if len(devices) > 1:
        found = ", ".join(f"{name} on {array.device}" for name, array in arrays.items())
        raise ValueError(f"arrays are on different devices: {found}; copy them to one with .to(device)")
    return next(iter(arrays.values())).device


def floats(dimensions: int, **arrays: wp.array) -> None:
    """Check that arrays are contiguous float32 with a number of dimensions.

    Raises:
        ValueError: If one is not.
    """
    typed(wp.float32, dimensions, **arrays)


def typed(dtype: type, dimensions: int, **arrays: wp.array) -> None:
    """Check that arrays are contiguous and have a type and a number of dimensions.

    Raises:
        ValueError: If one is not or has not.
    """
    for name, array in arrays.items():
        if array.dtype is not dtype or array.ndim != dimensions:
            found = f"{array.ndim}-D {array.dtype.__name__}"
            raise ValueError(f"{name} is {found}, expected {dimensions}-D {dtype.__name__}")
        if not array.is_contiguous:
            raise ValueError(f"{name} is not contiguous: pass {name}.contiguous()")


def shape(expected: tuple[int, ...], **arrays: wp.array) -> None:
    """Check that arrays have a shape.

    Raises:
        ValueError: If one has another.
    """
    for name, array in arrays.items():
        if tuple(array.shape) != tuple(expected):
            raise ValueError(f"{name} has shape {tuple(array.shape)}, expected {tuple(expected)}")


def same_shape(**arrays: wp.array) -> None:
    """Check that all arrays have the shape of the first.

    Raises:
        ValueError: If one has another.
    """
    (first, *_) = arrays.values()
    shape(first.shape, **arrays)


def block(first: tuple[int, int, int], size: tuple[int, int, int], **arrays: wp.array) -> None:
    """Check that a block of voxels lies inside of arrays.

    Raises:
        ValueError: If it is empty or reaches out of one.
    """
    for name, array in arrays.items():
        inside = all(f >= 0 and n > 0 and f + n <= m for f, n, m in zip(first, size, array.shape, strict=True))
        if not inside:
            found = f"{tuple(size)} from {tuple(first)}"
            raise ValueError(f"a block of {found} does not lie in {name}, whose shape is {tuple(array.shape)}")
