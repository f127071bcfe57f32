"""The page in a browser: ray sums, closed forms of absorption and shadows, what stands there, keys and mouse."""

import numpy as np
import pytest
from chromium import DRAWN, PROGRAM, Browser
from scipy import ndimage

from warpfluid.files.npz import write_npz
from warpfluid.preview.page import LAMPS, SHADOW, TO_LIGHT, write_page
from warpfluid.preview.scene import open_scene
from warpfluid.preview.solids import pack_solids
from warpfluid.projector import Projector
from warpfluid.rendering.ramps import apply_ramp
from warpfluid.rendering.surfaces import Surface
from warpfluid.rendering.turntable import render_turntable

TURN = [0, 35, -135]


@pytest.mark.slow
@pytest.mark.parametrize("angle", TURN)
def test_a_pixel_a_voxel_is_the_projection(browser, page, angle):
    """On the floor's plane the picture is Joseph's projection, coloured; bytes and linear filters cost little."""
    path, volumes = page
    volume = volumes[1002]
    size = (volume.shape[0], volume.shape[2])
    browser.open(path, f"frame=1002&angle={angle}&zoom=1&bare=true&ramp=gray", size=size, frame=1002)
    sums = Projector([angle], volume.shape, footprint="joseph", device="cpu").project(volume)[0]
    expected = apply_ramp(sums.T[::-1], "gray").astype(int)
    off = np.abs(browser.picture().astype(int) - expected)
    assert off.max() <= 4
    assert off[expected.max(axis=-1) > 0].mean() < 0.6


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shape", "lit", "where"),
    [((6, 6, 9), None, None), ((1, 1, 1), (0, 0, 0), (50, 50)), ((7, 5, 9), (6, 0, 4), (83, 50))],
)
def test_odd_boxes(browser, tmp_path, shape, lit, where):
    """An empty volume is black, a single voxel shows where it is, also in a box that is not as wide as deep."""
    volume = np.zeros(shape, np.float32)
    if lit:
        volume[lit] = 1
    write_npz(tmp_path / "a.1.npz", volume.swapaxes(1, 2))
    write_page(tmp_path / "page.html", open_scene(tmp_path), budget=1.0)
    browser.open(tmp_path / "page.html", "bare=true&zoom=1&ramp=gray", size=(100, 100), frame=1)
    picture = browser.picture()[..., 0]
    if not lit:
        assert not picture.any()
        return
    rows, columns = np.nonzero(picture > 200)
    np.testing.assert_allclose([columns.mean(), rows.mean()], where, atol=4)


@pytest.mark.slow
@pytest.mark.parametrize("look", ["fire", "smoke"])
def test_it_looks_like_the_turntable(browser, page, look):
    """At twice the size its linear interpolation stays near the turntable's cubic one."""
    path, volumes = page
    volume = volumes[1001]
    size = (2 * volume.shape[0], 2 * volume.shape[2])
    browser.open(path, f"frame=1001&angle=20&zoom=1&bare=true&ramp={look}", size=size, frame=1001)
    wanted = render_turntable(volume, [20], look)[0].astype(int)
    assert np.abs(browser.picture() - wanted)[wanted.max(axis=-1) > 4].mean() < 4


@pytest.mark.slow
def test_from_above_it_is_the_sum_over_the_heights(browser, page):
    """Seen from 89 degrees the front lies below; scaled to the sum along y both pictures are alike."""
    path, volumes = page
    volume = volumes[1002]
    side, tall, lift = volume.shape[0], volume.shape[2], np.radians(89)
    farther = tall / (tall * np.cos(lift) + 1.04 * np.hypot(side, side) * np.sin(lift))  # what the page makes of zoom
    address = f"frame=1002&elevation=89&zoom={1 / farther}&bare=true&ramp=gray&exposure=-2"
    browser.open(path, address, size=(side, side), frame=1002)
    expected = apply_ramp(volume.sum(axis=2).T / 4, "gray")[..., 0].astype(int)
    seen = browser.picture()[..., 0].astype(int)
    assert np.corrcoef(seen.ravel(), expected.ravel())[0, 1] > 0.98
    assert np.corrcoef(seen[::-1].ravel(), expected.ravel())[0, 1] < 0.9


@pytest.mark.slow
@pytest.mark.parametrize(("angle", "bodies"), [(0, "true"), (20, "true"), (35, "true"), (35, "false")])
def test_bodies_stand_in_the_light(browser, solid_run, tmp_path, angle, bodies):
    """As in the turntable, where no shadow falls: what is in front adds to a surface, what is behind is hidden."""
    scene = open_scene(solid_run)
    frame, density = 3, scene.volumes.density(3)
    write_page(tmp_path / "page.html", scene, budget=5.0)
    height, width = render_turntable(density, [angle], "smoke").shape[1:3]
    address = f"frame={frame}&angle={angle}&zoom=1&bare=true&ramp=smoke&bodies={bodies}"
    browser.open(tmp_path / "page.html", address, size=(width, height), frame=frame)
    seen = browser.picture().astype(int)
    surfaces = []
    for part, solid in zip(pack_solids(scene, density.shape), scene.solids(frame, density.shape), strict=True):
        surfaces.append(Surface(solid.vertices, solid.triangles, tuple(part["color"])))
    bare, full = (render_turntable(density, [angle], "smoke", surfaces=s)[0].astype(int) for s in ((), surfaces))
    covered = np.abs(full - bare).max(axis=-1) > 20
    assert covered.mean() > 0.03
    wanted = full if bodies == "true" else bare
    assert np.quantile(np.abs(seen - wanted)[covered], 0.75) < 6
    assert np.abs(seen - wanted)[~covered].mean() < 4


@pytest.mark.slow
@pytest.mark.parametrize("depth", [0.1, 3.0])
def test_absorption_has_its_closed_form(browser, page, depth):
    """Light that is absorbed as it is emitted comes to (1 - exp(-depth s)) over the same of white."""
    path, volumes = page
    address = f"frame=1001&zoom=1&bare=true&ramp=gray&theme=dark&mode=absorbing&absorption={depth}"
    volume = volumes[1001]
    browser.open(path, address, size=(volume.shape[0], volume.shape[2]), frame=1001)
    sums = volume.sum(axis=1).T[::-1]
    clear = np.exp(-depth * sums / 255)
    expected = 255 * (1 - clear) / (1 - np.exp(-depth)) + clear * 0.075 * 255
    assert np.abs(browser.picture()[..., 0] - np.minimum(expected, 255)).max() < 5


@pytest.mark.slow
def test_light_from_above_casts_shadows(browser, page):
    """What reaches a voxel is marched through the volume with SciPy; the picture adds up what is scattered."""
    path, volumes = page
    volume, depth = volumes[1001], 6.0
    address = f"frame=1001&zoom=1&bare=true&ramp=gray&theme=dark&mode=lit&absorption={depth}"
    browser.open(path, address, size=(volume.shape[0], volume.shape[2]), frame=1001)
    x, y, z = np.array(TO_LIGHT) / np.linalg.norm(TO_LIGHT)
    places, towards = np.indices(volume.shape), np.array([x, z, y]).reshape(3, 1, 1, 1)
    above = 0.5 * sum(ndimage.map_coordinates(volume, places + t * towards, order=1) for t in np.arange(0.25, 60, 0.5))
    light = LAMPS[0] * np.exp(-SHADOW * depth / 255 * above) + LAMPS[1]
    optical = depth / 255 * volume[:, ::-1]  # the front first
    clear = np.exp(-np.cumsum(optical, axis=1))
    expected = 255 * ((clear * np.exp(optical)) * (1 - np.exp(-optical)) * light[:, ::-1]).sum(axis=1)
    expected = np.minimum(expected, 255 * (1 - clear[:, -1])) + clear[:, -1] * 0.075 * 255  # white covers what it hides
    off = np.abs(browser.picture()[..., 0].T[:, ::-1] - np.minimum(expected, 255))
    assert off.mean() < 1.5
    assert np.quantile(off, 0.99) < 16
    unlit = 255 * (1 - clear[:, -1]) * (LAMPS[0] + LAMPS[1])
    assert np.abs(np.minimum(unlit, 255) - expected).mean() > 6  # there are shadows to be seen


@pytest.mark.slow
def test_keys_and_mouse(browser, page):
    """Keys step, colour, stand at a view and hide; a drag turns and lifts; the address keeps it all."""
    path, _ = page
    browser.open(path, frame=1002)
    browser.press("c", "ArrowUp", "2", "ArrowLeft")
    assert browser.address() == {"ramp": "smoke", "exposure": "0.25", "angle": "90", "frame": "1001"}
    browser.press("a", "o", "h", "End", "ArrowRight")
    settings = browser.address()
    assert {name: settings[name] for name in ("mode", "box", "bare", "frame")} == {
        "mode": "absorbing", "box": "false", "bare": "true", "frame": "1001",
    }  # fmt: skip
    browser.open(path, frame=1002)
    browser.drag((100, 100), (150, 125))
    browser.wheel((100, 100), -200)
    settings = browser.address()
    assert (settings["angle"], settings["elevation"]) == ("20", "10")
    assert float(settings["zoom"]) == pytest.approx(0.92 * 1.0015**200, abs=1e-3)
    browser.press("0")
    assert browser.address() == {}


@pytest.mark.slow
def test_an_address_opens_the_same_view(browser, page):
    """What one reader passes on, another sees; nonsense in it is left out."""
    path, _ = page
    browser.open(path, "frame=1001&ramp=jet&angle=400&zoom=99&exposure=x&nothing=1&__proto__=1", frame=1001)
    browser.press("t", "t")
    settings = browser.address()
    assert (settings["frame"], settings["ramp"], settings["zoom"]) == ("1001", "jet", "20")
    assert float(settings["angle"]) == pytest.approx(40, abs=25)  # it turned a little
    assert "exposure" not in settings


@pytest.mark.slow
def test_play_shows_every_frame(browser, page):
    """The space key plays and stops; the last frame is followed by the first."""
    path, _ = page
    browser.open(path, frame=1002)
    browser.press(" ")
    for frame in (1001, 1002, 1001):
        browser.run(DRAWN.replace("FRAME", repr(str(frame))))
    browser.press(" ")
    browser.run("new Promise((done) => setTimeout(done, 300))")
    number = browser.run("document.body.dataset.shown")
    browser.run("new Promise((done) => setTimeout(done, 500))")
    assert browser.run("document.body.dataset.shown") == number


@pytest.mark.slow
def test_nothing_is_logged(browser, page):
    """No error, and no complaint of the page's own policy."""
    path, _ = page
    browser.open(path, frame=1002)
    assert browser.run("document.getElementById('message').hidden")
    assert browser.run("document.getElementById('still').hidden")
    blocked = browser.run("fetch('https://example.invalid/').then(() => 'sent', () => 'blocked')")
    assert blocked == "blocked"


@pytest.mark.slow
def test_without_graphics_the_still_picture_stays(page, tmp_path):
    """A browser without WebGL says so and shows what it has."""
    if PROGRAM is None:
        pytest.skip("there is no Chromium")
    browser = Browser(tmp_path / "profile", graphics=False)
    try:
        browser.open(page[0])
        browser.run("new Promise((done) => setTimeout(done, 1000))")
        assert "WebGL 2" in browser.run("document.getElementById('message').textContent")
        assert not browser.run("document.getElementById('message').hidden")
        assert not browser.run("document.getElementById('still').hidden")
        assert browser.run("document.getElementById('still').naturalWidth") == 96
    finally:
        browser.close()
