"""Flows as files: numbers that come back, and the colours of the Middlebury wheel."""

import numpy as np
import pytest

from warpfluid.files.images import read_image
from warpfluid.motion.flow_files import colour_flow, colour_wheel, draw_flow, saturated_speed, write_flow

SIZE = (60, 44)


def turning():
    """A flow about the middle, shape (2, u, v)."""
    u, v = np.indices(SIZE) - np.reshape(SIZE, (2, 1, 1)) / 2
    return 0.1 * np.stack([-v, u]).astype(np.float32)


def test_numbers_come_back(tmp_path):
    """Channels u and v, the top row of the picture first."""
    import OpenEXR

    flow = turning()
    numbers, colours = write_flow(tmp_path, 12, -52.5, flow)
    assert (numbers.name, colours.name) == ("flow.-52.5.0012.exr", "flow.-52.5.0012.png")
    channels = OpenEXR.File(str(numbers), separate_channels=True).channels()
    assert set(channels) == {"u", "v"}
    for name, component in zip("uv", flow, strict=True):
        np.testing.assert_array_equal(channels[name].pixels, component.T[::-1])
    assert read_image(colours).shape == (SIZE[1], SIZE[0], 3)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([numbers.name, colours.name])


@pytest.mark.parametrize(
    ("direction", "colour"),
    [
        ((1, 0), (255, 0, 0)),  # right is red, as in the Middlebury benchmark
        ((-1, 0), (0, 209, 255)),
        ((0, -1), (255, 234, 0)),  # down is yellow
        ((0, 1), (103, 0, 255)),
    ],
)
def test_directions_have_their_colours(direction, colour):
    """Full saturation at full speed; half of it at half speed; white at rest."""
    flow = np.reshape(np.array(direction, float), (2, 1))
    full, half, still = (colour_flow(scale * flow, 2.0)[0].astype(int) for scale in (2, 1, 0))
    np.testing.assert_allclose(full, colour, atol=12)
    np.testing.assert_allclose(half, (full + 255) / 2, atol=1)
    np.testing.assert_array_equal(still, 255)
    assert (colour_flow(3 * flow, 2.0)[0] <= full).all()


def test_the_wheel_turns_steadily():
    """55 colours, no two alike, neighbours near one another, all of them saturated."""
    wheel = colour_wheel()
    assert wheel.shape == (55, 3)
    assert len(np.unique(wheel, axis=0)) == 55
    assert np.abs(wheel - np.roll(wheel, 1, axis=0)).max() < 70
    np.testing.assert_array_equal(wheel.max(axis=1), 255)
    np.testing.assert_array_equal(wheel.min(axis=1), 0)


@pytest.mark.parametrize(("speed", "full"), [(0.7, 1), (1.3, 2), (2.9, 3), (4, 5), (6.1, 10), (20, 20), (0.05, 0.05)])
def test_full_saturation_is_a_round_speed(speed, full):
    """The next of 1, 2, 3, 5, 10 above what moves; a still picture has one too."""
    flow = np.zeros((2, *SIZE))
    flow[0, 5:, 3:] = speed
    assert saturated_speed(flow) == pytest.approx(full)
    assert saturated_speed(0 * flow) == 1


def test_the_legend_is_a_corner():
    """A wheel with its rim's speed, top right; the rest of the picture is the flow; tiny pictures have none."""
    flow = turning()
    bare = colour_flow(flow, saturated_speed(flow)).transpose(1, 0, 2)[::-1]
    drawn = draw_flow(flow)
    changed = (drawn != bare).any(axis=2)
    rows, columns = np.nonzero(changed)
    assert changed.mean() > 0.05
    assert rows.max() < SIZE[1] * 0.95
    assert columns.min() > SIZE[0] / 2
    tiny = flow[:, :20, :20]
    np.testing.assert_array_equal(draw_flow(tiny), colour_flow(tiny, saturated_speed(tiny)).transpose(1, 0, 2)[::-1])


@pytest.mark.parametrize("wrong", [np.zeros((3, 9, 9)), np.zeros((9, 9)), np.full((2, 9, 9), np.nan)])
def test_refuses_what_is_no_flow(tmp_path, wrong):
    """By its shape, or its values; nothing is written."""
    with pytest.raises(ValueError, match="flow has shape"):
        write_flow(tmp_path, 1, 0, wrong)
    assert not list(tmp_path.iterdir())
