"""The flow of a shot as files."""

import numpy as np
import pytest

from warpfluid.device import pick_device
from warpfluid.files.images import read_image, write_png
from warpfluid.footage.shot import open_shot
from warpfluid.motion.shot_flow import write_shot_flow
from warpfluid.options import InputOptions

SHIFTS = {"front": (3, 1), "side": (0, -2)}  # pixels to the right and up, a frame


@pytest.fixture
def shot(tmp_path):
    """Two views of three frames in which a textured blob moves steadily."""
    u, v = np.indices((64, 48))
    for name, (right, up) in SHIFTS.items():
        (tmp_path / name).mkdir()
        for frame in range(11, 14):
            x, y = u - 28 - right * (frame - 12), v - 24 - up * (frame - 12)
            blob = 200 * (1 + 0.4 * np.sin(0.7 * x) * np.cos(0.6 * y)) / 1.4 * np.exp(-(x**2 + y**2) / 120)
            write_png(tmp_path / name / f"{name}.{frame:04d}.png", blob.T[::-1].astype(np.uint8))
    views = [f"{angle}={tmp_path / name}" for angle, name in ((0, "front"), (90, "side"))]
    return open_shot(views, InputOptions(equalize_rows=False))


@pytest.mark.parametrize("method", ["nltv-ncc", "ilk"])
def test_every_pair_and_view_is_written(shot, tmp_path, device, method):
    """In order, with the speeds of what is lit."""
    found = list(write_shot_flow(shot, tmp_path, method=method, device=pick_device(device)))
    assert [(f.frame, f.later, f.angle_deg) for f in found] == [(11, 12, 0), (11, 12, 90), (12, 13, 0), (12, 13, 90)]
    for flow in found:
        speed = np.hypot(*SHIFTS["front" if flow.angle_deg == 0 else "side"])
        assert flow.median == pytest.approx(speed, abs=0.3)
        assert flow.median <= flow.fast < 1.5 * speed
        assert [f.rsplit(".", 1)[1] for f in flow.files] == ["exr", "png"]
    files = sorted(path.name for path in tmp_path.iterdir() if path.is_file())
    stems = [f"flow.{angle}.{frame:04d}" for angle in (0, 90) for frame in (11, 12)]
    assert files == sorted(f"{stem}.{suffix}" for stem in stems for suffix in ("exr", "png"))


def test_colours_do_not_flicker(shot, tmp_path):
    """Steady motion has the same colour in both pairs: one speed of full saturation for the shot."""
    list(write_shot_flow(shot, tmp_path, method="nltv-ncc", device=pick_device("cpu")))
    first, second = (read_image(tmp_path / f"flow.0.{frame:04d}.png")[24, 27] for frame in (11, 12))
    np.testing.assert_allclose(first, second, atol=0.05)


def test_black_pictures_are_still(tmp_path):
    """A frame before the fire begins has a flow of zero speed."""
    for frame in (1, 2, 3):
        picture = np.zeros((48, 64), np.uint8)
        picture[20:30, 20:40] = 200 * (frame == 3)
        write_png(tmp_path / f"fire.{frame:04d}.png", picture)
    shot = open_shot([f"0={tmp_path}"])
    (tmp_path / "flow").mkdir()
    first, second = write_shot_flow(shot, tmp_path / "flow", method="nltv-ncc", device=pick_device("cpu"))
    assert (first.median, first.fast, second.median) == (0, 0, 0)
