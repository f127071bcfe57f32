"""A headless Chromium, driven through a pipe by its own protocol: pages, sizes, scripts, keys, mouse, pictures."""

import base64
import contextlib
import io
import json
import os
import shutil
import subprocess

import numpy as np
from PIL import Image

PROGRAM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))), None)
FLAGS = ("--headless", "--no-sandbox", "--no-first-run", "--hide-scrollbars", "--remote-debugging-pipe")
SOFTWARE = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")
WITHOUT = ("--disable-gpu", "--disable-3d-apis")
DRAWN = """new Promise((done) => {
  const there = () => document.body?.dataset.shown === FRAME;
  const look = () => there() ? requestAnimationFrame(() => done(true)) : setTimeout(look, 20);
  look();
})"""


class Browser:
    """One page of a browser.

    Args:
        profile: Folder for its files.
        graphics: Whether it draws 3D pictures, in software.
    """

    def __init__(self, profile, *, graphics=True):
        (from_us, self._out), (self._in, to_us) = os.pipe(), os.pipe()

        def place():  # the protocol's pipes are 3 and 4
            for source, target in ((os.dup(from_us), 3), (os.dup(to_us), 4)):
                os.dup2(source, target)

        flags = (*FLAGS, *(SOFTWARE if graphics else WITHOUT), f"--user-data-dir={profile}")
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self._process = subprocess.Popen([PROGRAM, *flags], preexec_fn=place, pass_fds=(3, 4), **quiet)
        os.close(from_us)
        os.close(to_us)
        self._number, self._rest, self.session = 0, b"", None
        (page,) = [t for t in self.call("Target.getTargets")["targetInfos"] if t["type"] == "page"] or [None]
        target = page or self.call("Target.createTarget", url="about:blank")
        self.session = self.call("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]

    def call(self, method, **params):
        """Call a method of the protocol and return its result."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": params}
        os.write(
            self._out, json.dumps(message | ({"sessionId": self.session} if self.session else {})).encode() + b"\0"
        )
        while True:
            answer = self._read()
            if answer.get("id") == self._number:
                assert "error" not in answer, answer["error"]
                return answer["result"]

    def _read(self):
        while b"\0" not in self._rest:
            part = os.read(self._in, 1 << 20)
            assert part, "the browser has gone"
            self._rest += part
        text, self._rest = self._rest.split(b"\0", 1)
        return json.loads(text)

    def open(self, path, hash="", *, size=(800, 400), frame=None):
        """Open a file at a size; wait until a frame is drawn."""
        self.call(
            "Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], deviceScaleFactor=1, mobile=False
        )
        self.call("Page.navigate", url="about:blank")  # another fragment alone would not load the page anew
        self.call("Page.navigate", url=f"file://{path}#{hash}")
        if frame is not None:
            self.run(DRAWN.replace("FRAME", repr(str(frame))))

    def run(self, script):
        """Return what a script, or the promise it makes, comes to."""
        answer = self.call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True, timeout=60000)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def press(self, *keys):
        """Press keys one after the other."""
        for key in keys:
            text = {"text": key} if len(key) == 1 else {}
            self.call("Input.dispatchKeyEvent", type="keyDown", key=key, **text)
            self.call("Input.dispatchKeyEvent", type="keyUp", key=key)

    def drag(self, start, end):
        """Drag the mouse from one place to another."""
        for kind, (x, y), button in (
            ("mouseMoved", start, "none"),
            ("mousePressed", start, "left"),
            ("mouseMoved", end, "left"),
            ("mouseReleased", end, "left"),
            ("mouseMoved", start, "none"),
        ):
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button, clickCount=1)

    def wheel(self, place, amount):
        """Turn the wheel."""
        x, y = place
        self.call("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y, deltaX=0, deltaY=amount)

    def address(self):
        """Return what the page's address says, once it is settled."""
        self.run("new Promise((done) => setTimeout(done, 600))")
        return dict(self.run("[...new URLSearchParams(location.hash.slice(1))]"))

    def picture(self):
        """Return what is seen, uint8, shape (rows, columns, 3)."""
        data = base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])
        return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))

    def close(self):
        """End the browser."""
        with contextlib.suppress(AssertionError, OSError):
            self.session = None
            self.call("Browser.close")
        os.close(self._out)
        os.close(self._in)
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
