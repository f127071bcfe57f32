"""A scene as pyvista draws it, in a window or into a picture."""

from collections.abc import Callable, Collection

import numpy as np

from warpfluid.errors import describe
from warpfluid.footage.origin import find_footage
from warpfluid.options import PreviewOptions
from warpfluid.options.preview import PARTS
from warpfluid.preview import parts
from warpfluid.preview.scene import SOLID_COLOURS, Scene
from warpfluid.preview.summing import summed_volume

SKY, GROUND = "#1b2029", "#090b0f"
ELEVATION_DEG = 15.0
ZOOM = 1.2  # what is shown is round only in the worst case


class Window:
    """A scene in pyvista.

    Args:
        scene: What is shown.
        options: Which parts, and how large.
        off_screen: Draw pictures only.
        say: Called with a line where a part cannot be shown.
    """

    def __init__(
        self,
        scene: Scene,
        options: PreviewOptions | None = None,
        *,
        off_screen: bool = False,
        say: Callable[[str], object] = print,
    ):
        import pyvista

        options = options or PreviewOptions()
        self.scene, self.say, self.on_screen = scene, say, False
        self.shown, self.look, self.exposure = set(options.parts), scene.look, scene.exposure
        self.slice_height, self.index = 0.35, scene.frames.index(scene.middle)
        self.start = (scene.angle_deg, ELEVATION_DEG if scene.elevation_deg is None else scene.elevation_deg)
        self._names: dict[str, list[str]] = {}
        self._lacking: set[str] = set()
        self._fields: tuple[int, dict[str, np.ndarray]] = (-1, {})
        self._footage = None
        self.plotter = pyvista.Plotter(off_screen=off_screen, window_size=options.window_size, lighting="three lights")
        self.plotter.set_background(GROUND, top=SKY)
        self.density = scene.volumes.density(self.frame)
        self.draw()
        self.look_from(*self.start)

    @property
    def frame(self) -> int:
        """Number of the frame that is shown."""
        return self.scene.frames[self.index]

    def show_frame(self, index: int) -> None:
        """Show another frame, counted from the first; past the last comes the first."""
        self.index = index % len(self.scene.frames)
        self.density = self.scene.volumes.density(self.frame)
        self.draw()

    def toggle(self, part: str) -> None:
        """Show a part, or hide it."""
        self.shown ^= {part}
        self.draw([part])

    def expose(self, stops: float) -> None:
        """Make the volume brighter by some stops."""
        self.exposure += stops
        self.draw(["volume"])

    def recolour(self, look: str) -> None:
        """Show the volume in the colours of another ramp."""
        self.look = look
        self.draw(["volume"])

    def lift_slice(self, share: float) -> None:
        """Move the level slice by a share of the height."""
        self.slice_height = min(max(self.slice_height + share, 0.0), 1.0)
        self.draw(["slices"])

    def look_from(self, angle_deg: float, elevation_deg: float = 0.0) -> None:
        """Put the camera somewhere, so far that everything is seen."""
        camera, middle = self.plotter.camera, parts.box_middle(self.density.shape)
        camera.parallel_projection = True
        camera.focal_point = middle
        camera.position = middle + 4 * max(self.density.shape) * parts.facing(angle_deg, elevation_deg)[0]
        camera.up = (0, 1, 0)
        self.plotter.reset_camera()
        camera.zoom(ZOOM)
        if self.on_screen:
            self.plotter.render()

    def draw(self, which: Collection[str] = PARTS) -> None:
        """Draw parts anew: those that are shown; others vanish."""
        self.plotter.suppress_rendering = True  # or every part would draw the whole volume again
        for part in which:
            for name in self._names.pop(part, ()):
                self.plotter.remove_actor(name, reset_camera=False)
            if part in self.shown and part not in self._lacking:
                self._names[part] = self._attempt(part)
        title = f"{self.scene.title}   frame {self.frame}   {self.look}   {self.exposure:+.2f} stops"
        self.plotter.add_text(title, position="upper_left", font_size=9, color=parts.WORD_COLOUR, name="title")
        self.plotter.suppress_rendering = False
        if self.on_screen:
            self.plotter.render()

    def picture(self) -> np.ndarray:
        """Return what is seen, uint8, shape (rows, columns, 3)."""
        self.plotter.render()
        return np.asarray(self.plotter.screenshot(return_img=True))[..., :3]

    def _attempt(self, part: str) -> list[str]:
        """Draw a part; return the names of its actors, none if the files lack what it needs."""
        try:
            return getattr(self, f"_add_{part}")()
        except (ValueError, OSError) as error:
            self._lacking.add(part)
            self.say(f"no {part}: {describe(error)}")
            return []

    def _add_volume(self) -> list[str]:
        actor = summed_volume(self.density, self.look, white=255 / 2**self.exposure, quick=self.on_screen)
        self.plotter.add_actor(actor, name="volume", reset_camera=False)
        return ["volume"]

    def _add_slices(self) -> list[str]:
        lit = self.density[self.density > 0]
        top = float(np.quantile(lit, 0.999)) if lit.size else 1.0
        cut, colours = parts.slices(self.density, self.slice_height, top)
        self._add(cut, "slices", scalars="density", cmap=colours, lighting=False, show_scalar_bar=False)
        return ["slices"]

    def _add_arrows(self) -> list[str]:
        return self._add_motion(parts.arrows, "arrows", 0.9)

    def _add_streamlines(self) -> list[str]:
        return self._add_motion(parts.streamlines, "streamlines", 0.7)

    def _add_motion(self, make: Callable, name: str, opacity: float) -> list[str]:
        if self._fields[0] != self.frame:
            self._fields = (self.frame, self.scene.volumes.fields(self.frame, ["velocity"]))
        if "velocity" not in self._fields[1]:
            raise ValueError("the files hold no velocity; those of warpfluid simulate do")
        mesh = make(self.density, self._fields[1]["velocity"])
        if mesh is None:
            return []
        self._add(mesh, name, scalars="speed", cmap="cool", opacity=opacity, show_scalar_bar=False)
        return [name]

    def _add_pictures(self) -> list[str]:
        self._footage = self._footage or find_footage(self.scene.volumes.document)
        images = self._footage.images(self.frame) if self._footage else None
        if images is None:
            self._lacking.add("pictures")
            return []
        names = []
        for image, angle in zip(images, self._footage.angles_deg, strict=True):
            plane, texture = parts.picture(image, angle, self.density.shape)
            names.append(f"picture {angle:g}")
            self._add(plane, names[-1], texture=texture, lighting=False)
        return names

    def _add_bodies(self) -> list[str]:
        names = []
        for number, solid in enumerate(self.scene.solids(self.frame, self.density.shape)):
            names.append(f"body {number}")
            looks = {"color": SOLID_COLOURS[solid.kind], "specular": 0.3, "smooth_shading": True}
            self._add(parts.solid(solid.vertices, solid.triangles), names[-1], split_sharp_edges=True, **looks)
        return names

    def _add_box(self) -> list[str]:
        shape = self.density.shape
        self._add(parts.outline(shape), "box", color=parts.LINE_COLOUR, line_width=1, opacity=0.7, lighting=False)
        points, words = parts.view_marks(self.scene.volumes.angles_deg, shape)
        self.plotter.add_point_labels(
            points, words, name="views", font_size=13, text_color=parts.WORD_COLOUR, shape=None, point_size=8,
            point_color=parts.WORD_COLOUR, render_points_as_spheres=True, always_visible=True, reset_camera=False,
        )  # fmt: skip
        return ["box", "views-points", "views-labels"]

    def _add(self, mesh, name: str, **looks) -> None:
        self.plotter.add_mesh(mesh, name=name, reset_camera=False, **looks)
