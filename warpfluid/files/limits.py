"""How much a file may promise for its size: a thousand bytes cannot hold ten gigabytes of anything but nothing.

What headers say is held against these limits before memory is taken. Files of honest programs stay far below.
"""

SMALL = 2**27  # bytes that any file may open to
MOST_A_BYTE = 2**13  # bytes that a byte may open to: zlib reaches 1032, the DWAB of black OpenEXR pictures 7000
SMALLEST_VOXEL, LARGEST_VOXEL = 1e-30, 1e30  # world units; a float in 32 bits must hold it and its inverse
MOST_PIXELS = 2**26  # 8192 x 8192: a picture that claims more is damaged or a trap
FLAT_PICTURE = 16 * MOST_PIXELS  # bytes that any picture may open to: one colour takes no room in its file
EMPTY = 2**27  # voxels that volumes may have without any that is not empty
VOXELS_AN_ACTIVE = 1000  # of the box around active voxels


def check_promise(promised: float, size: int, small: int = SMALL) -> None:
    """Refuse a file that would open to far more than it can hold.

    Args:
        promised: What it would take in memory [byte].
        size: Of the file [byte].
        small: What any file may open to [byte].

    Raises:
        ValueError: If that cannot be; it does not know the file's name.
    """
    if not promised <= small + MOST_A_BYTE * size:
        raise ValueError(f"it promises {promised / 1e6:.0f} MB and has {size / 1e3:.1f} kB; write it again")


def check_sides(width: int, height: int, what: str = "its size") -> None:
    """Refuse a picture that is too large.

    Args:
        width: Columns.
        height: Rows.
        what: What the width and height are of.

    Raises:
        ValueError: If it is; it does not know the file's name.
    """
    if min(width, height) < 1 or width * height > MOST_PIXELS:
        raise ValueError(f"{what} is {width} x {height}, at least one and at most {MOST_PIXELS} pixels are allowed")


def check_pixels(width: int, height: int, channels: int, size: int, small: int = SMALL) -> None:
    """Refuse a picture that is too large, or that its file cannot hold.

    Args:
        width: Columns.
        height: Rows.
        channels: Numbers of a pixel.
        size: Of the file [byte].
        small: What any file may open to [byte].

    Raises:
        ValueError: If it is; it does not know the file's name.
    """
    check_sides(width, height)
    check_promise(4 * width * height * channels, size, small)


def check_box(voxels: int, active: int) -> None:
    """Refuse volumes that are large and nearly empty, as they seem when a byte was flipped.

    Args:
        voxels: Of the box that holds all grids.
        active: Voxels that are not empty, of all grids.

    Raises:
        ValueError: If there are too many; it does not know the file's name.
    """
    if voxels > EMPTY + VOXELS_AN_ACTIVE * active:
        raise ValueError(f"it is damaged or nearly empty: {active} voxels in a box of {voxels}")


def is_voxel_size(size: float) -> bool:
    """Return whether a voxel may have this side [world unit]; what is no number is none."""
    return SMALLEST_VOXEL < size < LARGEST_VOXEL
