"""The page: one file without a network, names that stay names, and in a browser the paper's ray sums."""

import json
import re
from html.parser import HTMLParser

import numpy as np

from warpfluid.files.npz import write_npz
from warpfluid.preview import packing
from warpfluid.preview.page import write_page
from warpfluid.preview.scene import open_scene
from warpfluid.rendering.ramps import RAMPS

EVIL = "<!--<script>alert('1')</script>' onerror=x & ${body} $title"


class Tags(HTMLParser):
    """The tags of a page and the texts in some of them."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.tags, self.texts = [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        self.texts.append((self.tags[-1][0] if self.tags else None, data))


def told(path) -> dict:
    """What the page's script is told."""
    text = path.read_text("utf-8")
    return json.loads(re.search(r'id="scene">(.*?)</script>', text, re.DOTALL)[1])


def test_nothing_is_fetched(page):
    """No address of another place is in the page, and its policy forbids all of them."""
    path, _ = page
    text = path.read_text("utf-8")
    assert not re.search(r"https?:|url\(|@import|src=(?!\"data:)", text)
    tags = Tags(text).tags
    (policy,) = [a["content"] for tag, a in tags if a.get("http-equiv") == "Content-Security-Policy"]
    assert policy.startswith("default-src 'none'")
    assert not {tag for tag, _ in tags} & {"link", "iframe", "object"}


def test_volumes_in_the_page_are_those_of_the_run(page):
    """Every frame unpacks to its density, at its place in the box."""
    path, volumes = page
    scene = told(path)
    texts = re.findall(r'class="frame">([^<]+)<', path.read_text("utf-8"))
    assert scene["frames"] == list(volumes)
    nx, ny, nz = scene["cells"]
    peak = max(volume.max() for volume in volumes.values())
    for text, volume in zip(texts, volumes.values(), strict=True):
        part = packing.unpack(text, (nx, nz, ny), peak)
        low = np.rint(np.array(scene["low"]) + np.array([volume.shape[i] for i in (0, 2, 1)]) / 2).astype(int)
        whole = np.zeros(volume.shape, np.float32)
        whole[low[0] : low[0] + nx, low[2] : low[2] + nz, low[1] : low[1] + ny] = part
        np.testing.assert_allclose(np.sqrt(whole), np.sqrt(volume), atol=0.51 / 255 * np.sqrt(peak))
    halves = np.array(scene["table"], np.uint16).view(np.float16).astype(float) * scene["peak"]
    np.testing.assert_allclose(halves, (np.arange(256) / 255) ** 2 * peak, rtol=6e-4)


def test_ramps_are_those_of_the_turntable(page):
    """The page can show each of them, with the same stops."""
    ramps = told(page[0])["ramps"]
    assert {name: {stop[0]: tuple(stop[1:]) for stop in stops} for name, stops in ramps.items()} == RAMPS


def test_names_are_only_text(tmp_path):
    """A folder's name makes no tag, ends no script, and shows as it is."""
    folder = tmp_path / EVIL.replace("/", "")
    folder.mkdir()
    write_npz(folder / "a.1.npz", np.ones((4, 4, 4), np.float32))
    write_page(tmp_path / "evil.html", open_scene(folder), budget=5.0)
    tame = tmp_path / "tame"
    folder.rename(tame)
    write_page(tmp_path / "tame.html", open_scene(tame), budget=5.0)
    evil, calm = (Tags((tmp_path / name).read_text("utf-8")) for name in ("evil.html", "tame.html"))
    assert [(tag, set(attrs)) for tag, attrs in evil.tags] == [(tag, set(attrs)) for tag, attrs in calm.tags]
    assert [text for tag, text in evil.texts if tag in ("title", "h1") and text.strip()][:2] == [folder.name] * 2
