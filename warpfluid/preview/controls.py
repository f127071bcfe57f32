"""A window on the screen: keys, the time slider, playing."""

from collections.abc import Callable

from warpfluid.preview import parts
from warpfluid.preview.window import Window
from warpfluid.rendering.ramps import RAMPS

KEYS = {"v": "volume", "s": "slices", "a": "arrows", "l": "streamlines", "i": "pictures", "b": "bodies", "o": "box"}
HELP = """space play   left/right frame   up/down exposure   c colours   1-9 view   r reset   q close
v volume   s slices (page up/down moves them)   a arrows   l streamlines   i pictures   b bodies   o box"""
STOP = 0.25  # of exposure that a key changes
LIFT = 0.04  # of the height that a key moves the slice


class Controls:
    """What an artist does with a window.

    Args:
        window: The window.

    Attributes:
        playing: Whether frame follows frame.
    """

    def __init__(self, window: Window):
        self.window, self.playing, self._slider = window, False, None

    def run(self) -> None:
        """Open the window; return when it is closed."""
        window, plotter = self.window, self.window.plotter
        plotter.add_text(HELP, position="lower_left", font_size=8, color=parts.LINE_COLOUR, name="help")
        last = len(window.scene.frames) - 1
        if last > 0:
            self._slider = plotter.add_slider_widget(
                callback=self._slide, rng=(0, last), value=window.index, fmt="", color=parts.WORD_COLOUR,
                pointa=(0.2, 0.1), pointb=(0.8, 0.1), interaction_event="always", slider_width=0.02, tube_width=0.004,
            )  # fmt: skip
            pause = max(1, round(1000 / window.scene.rate))  # ms
            plotter.add_timer_event(max_steps=2**31 - 1, duration=pause, callback=self._tick)
        plotter.iren.style.AddObserver("CharEvent", lambda *_: None)  # VTK's own keys: stereo, wire frames
        for key, act in self.actions().items():
            plotter.add_key_event(key, act)
        window.on_screen = True
        plotter.show(title=f"warpfluid: {window.scene.title}")

    def actions(self) -> dict[str, Callable[[], None]]:
        """Return what every key does, by VTK's name of the key."""
        window = self.window
        views = enumerate(window.scene.volumes.angles_deg[:9], 1)
        return {
            **{key: lambda part=part: window.toggle(part) for key, part in KEYS.items()},
            **{str(i): lambda angle=angle: window.look_from(angle) for i, angle in views},
            "space": lambda: setattr(self, "playing", not self.playing),
            "Left": lambda: self._go(-1),
            "Right": lambda: self._go(1),
            "Up": lambda: window.expose(STOP),
            "Down": lambda: window.expose(-STOP),
            "Prior": lambda: window.lift_slice(LIFT),
            "Next": lambda: window.lift_slice(-LIFT),
            "c": self._recolour,
            "r": lambda: window.look_from(*window.start),
            "q": window.plotter.close,
        }

    def _go(self, step: int) -> None:
        self.playing = False
        self._show(self.window.index + step)

    def _show(self, index: int) -> None:
        self.window.show_frame(index)
        if self._slider:
            self._slider.GetRepresentation().SetValue(self.window.index)

    def _tick(self, _step: int) -> None:
        if self.playing:
            self._show(self.window.index + 1)

    def _slide(self, value: float) -> None:
        if round(value) != self.window.index:
            self.playing = False
            self.window.show_frame(round(value))

    def _recolour(self) -> None:
        names = list(RAMPS)
        self.window.recolour(names[(names.index(self.window.look) + 1) % len(names)])
