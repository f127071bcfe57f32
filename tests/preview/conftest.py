"""A page, a browser that draws it, and a simulation with solid things."""

import numpy as np
import pytest
from chromium import PROGRAM, Browser
from tiny import BARE, run

from warpfluid.files.npz import write_npz
from warpfluid.options import PreviewOptions
from warpfluid.preview.page import write_page
from warpfluid.preview.scene import open_scene

BODY = ("--body", "box center=2,7,0 size=2,1,3 rotation=0,30,0 weight=2 velocity=1,0,0")
OBSTACLES = ("--obstacle", "sphere center=-2,4,0 radius=1", "--obstacle", "cylinder center=0,6,0 radius=1 size=1,2,1")
BOX = ("--size", "16x24", "--emitter", "sphere center=0,2,0 radius=1.5 density=8")


@pytest.fixture(scope="session")
def solid_run(tmp_path_factory) -> str:
    """A simulation with a falling box and two obstacles."""
    folder = tmp_path_factory.mktemp("solid") / "run"
    flags = ("--frames", "1-3", *BARE, "--device", "cpu", "-q", "-o", folder)
    assert run("simulate", *BOX, *BODY, *OBSTACLES, *flags) == 0
    return str(folder)


@pytest.fixture(scope="session")
def page(tmp_path_factory, fire):
    """A page of two frames of a fire, and the volumes."""
    folder = tmp_path_factory.mktemp("page")
    volumes = {1001: fire, 1002: np.roll(fire, 5, axis=0)}
    for frame, volume in volumes.items():
        write_npz(folder / f"fire.{frame}.npz", volume.swapaxes(1, 2), frame=frame)
    scene = open_scene(folder, PreviewOptions(look="fire"))
    path = folder / "page.html"
    write_page(path, scene, budget=20.0)
    scale = scene.volumes.scale
    return path, {frame: volume * np.float32(scale) for frame, volume in volumes.items()}


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    """A browser that draws in software."""
    if PROGRAM is None:
        pytest.skip("there is no Chromium")
    browser = Browser(tmp_path_factory.mktemp("browser"))
    yield browser
    browser.close()
