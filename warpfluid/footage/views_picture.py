"""A picture of the views standing around the box, drawn without OpenGL.

Each view's picture hangs behind the box, as its camera throws it there; the camera is marked on the ring. The
glow inside the box is the geometric mean of what the views see of each point.
"""

import numpy as np

from warpfluid.views import Views

SIZE = (1280, 800)  # pixels
SHARPER = 2  # drawn so many times larger, then reduced
ELEVATION_DEG = 24.0
SCREEN_DISTANCE = 0.82  # of the box's width, from its middle to a picture
CROWDED_DEG = 60  # pictures closer than this hang one behind the other, this much farther:
STAGGER = 0.26
RING_RADIUS = 1.2
MARGIN = 0.075  # of the picture's size
GLOW_WIDTH = 72  # points across the box
SKY, GROUND = (23, 27, 36), (9, 11, 15)
PAPER = (35, 41, 54)
LIGHT = np.array([1.0, 0.93, 0.82])  # a lamp's white, so that grey pictures glow
GLOW = np.array([1.0, 0.62, 0.30])
GLOW_WORDS = (
    "glow: a guess before the run, its depth made up",
    "glow: a guess before the run, where all views see light",
)
LINES = (120, 132, 156)
WORDS = (196, 204, 220)
COLOURS = ((255, 178, 72), (86, 204, 242), (240, 120, 160), (130, 220, 130), (190, 150, 255))
AXES = {"x": (255, 96, 92), "y": (120, 214, 110), "z": (96, 150, 255)}


def draw_views(views: Views) -> np.ndarray:
    """Return a picture of the views around the box, uint8, shape (rows, columns, 3)."""
    from PIL import Image

    scene = _Scene(views)
    canvas = _backdrop(scene.width, scene.height)
    for index in scene.far_to_near():
        _hang_picture(canvas, views, index, scene)
    _add_glow(canvas, views, scene)
    picture = Image.fromarray((canvas.clip(0, 1) * 255).astype(np.uint8))
    _draw_lines(picture, views, scene)
    return np.asarray(picture.resize(SIZE, Image.Resampling.LANCZOS))


class _Scene:
    """Where points of space fall in the picture: an orthographic camera above the ring."""

    def __init__(self, views: Views):
        self.angles_deg = views.angles_deg
        self.width, self.height = SIZE[0] * SHARPER, SIZE[1] * SHARPER
        self.tall = views.size[1] / views.size[0]  # the box is one wide and deep
        self.eye_deg = _best_eye(views.angles_deg)
        self.scale, self.middle = 1.0, np.zeros(2)
        low, high = self._extent()
        room = np.array([self.width, self.height]) * (1 - 2 * MARGIN)
        self.scale = float((room / (high - low)).min())
        self.middle = (low + high) / 2

    def __call__(self, points) -> np.ndarray:
        """Return columns and rows of points (..., x y z)."""
        x, y, z = np.moveaxis(np.asarray(points, float), -1, 0)
        eye, lift = np.radians(self.eye_deg), np.radians(ELEVATION_DEG)
        right = np.cos(eye) * x + np.sin(eye) * z
        near = np.cos(eye) * z - np.sin(eye) * x
        flat = np.stack([right, near * np.sin(lift) - y * np.cos(lift)], axis=-1)
        return (flat - self.middle) * self.scale + (self.middle != 0).any() * self._centre

    @property
    def _centre(self) -> np.ndarray:
        return np.array([self.width, self.height]) / 2

    def distance(self, angle_deg: float) -> float:
        """Return how far behind the middle a view's picture hangs; every second of a crowd farther."""
        ordered = sorted(self.angles_deg)
        crowded = min(np.diff(ordered), default=180.0) < CROWDED_DEG
        return SCREEN_DISTANCE + STAGGER * (crowded and ordered.index(angle_deg) % 2)

    def screen(self, angle_deg: float) -> np.ndarray:
        """Return the corners of a view's picture: bottom left, bottom right, top right, top left."""
        right, towards = _directions(angle_deg)
        foot = -self.distance(angle_deg) * towards - [0, self.tall / 2, 0]
        up = np.array([0, self.tall, 0])
        return np.array([foot - right / 2, foot + right / 2, foot + right / 2 + up, foot - right / 2 + up])

    def ring(self, angle_deg, radius: float = RING_RADIUS) -> np.ndarray:
        """Return where on the ground a camera of this angle stands."""
        angle = np.radians(np.asarray(angle_deg, float))
        ground = np.full(angle.shape, -self.tall / 2)
        return np.stack([-radius * np.sin(angle), ground, radius * np.cos(angle)], axis=-1)

    def far_to_near(self) -> list[int]:
        """Return the views in the order to paint their pictures."""
        depth = [self.distance(a) * np.cos(np.radians(a - self.eye_deg)) for a in self.angles_deg]
        return sorted(range(len(depth)), key=lambda i: -depth[i])

    def _extent(self) -> tuple[np.ndarray, np.ndarray]:
        corners = [self.screen(angle) for angle in self.angles_deg]
        points = self(np.concatenate([*corners, self.ring(np.arange(0, 360, 5), RING_RADIUS + 0.12)]))
        return points.min(axis=0), points.max(axis=0)


def _directions(angle_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the picture's right and the direction towards the viewer."""
    c, s = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    return np.array([c, 0, s]), np.array([-s, 0, c])


def _best_eye(angles_deg: tuple[float, ...]) -> float:
    """Return the angle that sees all pictures least edge-on, a little aside as no artist likes symmetry."""
    around = np.arange(-180.0, 180.0, 1.0)
    facing = np.cos(np.radians(around[:, None] - np.array(angles_deg))).min(axis=1)
    return float(around[facing.argmax()]) - (8.0 if len(angles_deg) > 1 else -28.0)


def _backdrop(width: int, height: int) -> np.ndarray:
    """Return a soft dark gradient, lighter behind the box."""
    rows, columns = np.mgrid[0:height, 0:width].astype(np.float32)
    away = np.hypot((columns / width - 0.5) * 1.2, rows / height - 0.42)
    share = np.exp(-((away / 0.45) ** 2))[..., None]
    return ((1 - share) * np.array(GROUND) + share * np.array(SKY)).astype(np.float32) / 255


def _hang_picture(canvas: np.ndarray, views: Views, index: int, scene: _Scene) -> None:
    """Paint one view's picture on its screen behind the box."""
    from scipy import ndimage

    corners = scene(scene.screen(views.angles_deg[index]))
    low = np.floor(corners.min(axis=0)).astype(int).clip(0)
    high = np.ceil(corners.max(axis=0)).astype(int) + 1
    rows, columns = np.mgrid[low[1] : high[1], low[0] : high[0]]
    edges = np.stack([corners[1] - corners[0], corners[3] - corners[0]], axis=1)
    if abs(np.linalg.det(edges)) < 1:  # seen edge-on
        return
    spots = np.stack([columns - corners[0][0], rows - corners[0][1]], axis=-1) @ np.linalg.inv(edges).T
    inside = ((spots >= 0) & (spots <= 1)).all(axis=-1)
    where = [spots[inside][:, axis] * views.size[axis] - 0.5 for axis in (0, 1)]
    light = ndimage.map_coordinates(views.images[index] / views.white, where, order=1, mode="nearest")
    part = canvas[low[1] : high[1], low[0] : high[0]]
    paper = 0.25 * part[inside] + 0.75 * np.array(PAPER) / 255
    part[inside] = paper + light.clip(0, 1)[:, None] ** 0.9 * (LIGHT - paper)


def _add_glow(canvas: np.ndarray, views: Views, scene: _Scene) -> None:
    """Add a first guess of the fluid, inside the box."""
    from scipy import ndimage

    n = GLOW_WIDTH
    heights = max(2, round(n * scene.tall))
    across, up = (np.arange(n) + 0.5) / n - 0.5, (np.arange(heights) + 0.5) / heights - 0.5
    x, z, y = np.meshgrid(across, across, up * scene.tall, indexing="ij")
    points = np.stack([x, y, z], axis=-1)
    images, angles_deg = views.images, views.angles_deg
    if len(images) == 1:
        images, angles_deg = [images[0], _bell(images[0])], (angles_deg[0], angles_deg[0] + 90)
    light = np.ones(x.shape)
    for image, angle_deg in zip(images, angles_deg, strict=True):
        u = ((points @ _directions(angle_deg)[0] + 0.5) * image.shape[0]).astype(int)
        v = ((y / scene.tall + 0.5) * image.shape[1]).astype(int).clip(0, image.shape[1] - 1)
        seen = (u >= 0) & (u < image.shape[0])
        light *= np.where(seen, image[u.clip(0, image.shape[0] - 1), v], 0) ** (1 / len(images))
    columns, rows = np.moveaxis(scene(points).astype(int), -1, 0)
    glow = np.bincount((rows * scene.width + columns).ravel(), light.ravel(), minlength=scene.width * scene.height)
    cell = scene.scale / n
    glow = ndimage.gaussian_filter(glow.reshape(scene.height, scene.width).astype(np.float32), 0.7 * cell)
    bright = np.percentile(glow[glow > 0], 99.5) if (glow > 0).any() else 1.0
    canvas += 1.1 * (1 - np.exp(-1.6 * glow / max(bright, 1e-9)))[..., None] * GLOW


def _bell(image: np.ndarray) -> np.ndarray:
    """Return a side for one view: as wide as the front and as bright, but a soft bell."""
    weight = image.sum(axis=1) + 1e-9
    places = np.arange(len(image))
    middle = np.average(places, weights=weight)
    spread = 0.8 * np.sqrt(np.average((places - middle) ** 2, weights=weight)) + 1
    bell = np.exp(-0.5 * ((places - (len(image) - 1) / 2) / spread) ** 4)
    return bell[:, None] * image.max(axis=0)


def _draw_lines(picture, views: Views, scene: _Scene) -> None:
    """Draw the ring, the box, the frames of the pictures, the cameras, the axes and the words."""
    from PIL import ImageDraw

    pen = ImageDraw.Draw(picture, "RGBA")
    ring = scene(scene.ring(np.arange(0, 361, 2)))
    pen.line([tuple(p) for p in ring], fill=(*LINES, 150), width=SHARPER)
    for tick in range(0, 360, 15):
        ends = scene(np.stack([scene.ring(tick), scene.ring(tick, RING_RADIUS + (0.05 if tick % 45 == 0 else 0.025))]))
        pen.line([tuple(p) for p in ends], fill=(*LINES, 130), width=SHARPER)
    for index, angle_deg in enumerate(views.angles_deg):
        _draw_view(pen, scene, angle_deg, COLOURS[index % len(COLOURS)])
    _draw_box(pen, scene)
    _draw_axes(pen, scene)
    u, v = views.size
    lines = (GLOW_WORDS[len(views.images) > 1], f"box {u} x {v} x {u} voxels")
    for text, row, colour in zip(lines, (76, 40), (GLOW, np.array(WORDS) / 255), strict=True):
        shade = (*(255 * colour).astype(int).tolist(), 190)
        pen.text((scene.width - 40, scene.height - row), text, font=_font(15), fill=shade, anchor="rs")


def _draw_view(pen, scene: _Scene, angle_deg: float, colour: tuple[int, int, int]) -> None:
    """Draw the frame of a picture, its camera on the ring, and the angle at both."""
    corners = scene(scene.screen(angle_deg))
    pen.line([tuple(p) for p in [*corners, corners[0]]], fill=(*colour, 210), width=SHARPER + 1)
    right, towards = _directions(angle_deg)
    spot = scene.ring(angle_deg)
    camera = scene(np.array([spot - 0.16 * towards, spot + 0.05 * right, spot - 0.05 * right]))
    pen.polygon([tuple(p) for p in camera], fill=(*colour, 255))
    middle = np.array([0, -scene.tall / 2, 0])
    for start in np.arange(0.08, 0.94, 0.06):  # a dashed line of sight, on the ground
        dash = scene(np.stack([spot + (middle - spot) * start, spot + (middle - spot) * (start + 0.03)]))
        pen.line([tuple(p) for p in dash], fill=(*colour, 130), width=SHARPER)
    label = f"{angle_deg:g}°"
    place = scene((scene.screen(angle_deg)[2] + scene.screen(angle_deg)[3]) / 2)
    pen.text((place[0], place[1] - 14), label, font=_font(20), fill=(*colour, 255), anchor="ms")
    place = scene(scene.ring(angle_deg, RING_RADIUS + 0.13))
    pen.text(tuple(place), label, font=_font(16), fill=(*colour, 255), anchor="mm")


def _draw_box(pen, scene: _Scene) -> None:
    """Draw the twelve edges of the box, those at the back fainter."""
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    corners = signs * [0.5, scene.tall / 2, 0.5]
    lift = np.radians(ELEVATION_DEG)
    towards = _directions(scene.eye_deg)[1] * np.cos(lift) + np.array([0, np.sin(lift), 0])
    hidden = int((corners @ towards).argmin())
    for a in range(8):
        for b in range(a + 1, 8):
            if (signs[a] != signs[b]).sum() == 1:
                strength = 60 if hidden in (a, b) else 170
                line = [tuple(p) for p in scene(corners[[a, b]])]
                pen.line(line, fill=(*WORDS, strength), width=SHARPER)


def _draw_axes(pen, scene: _Scene) -> None:
    """Draw the directions of x, y and z in the lower left corner."""
    corner = np.array([0.075 * scene.width, 0.87 * scene.height])
    origin = scene([0, 0, 0])
    for axis, (name, colour) in enumerate(AXES.items()):
        arm = (scene(np.eye(3)[axis]) - origin) / scene.scale * 0.055 * scene.width
        pen.line([tuple(corner), tuple(corner + arm)], fill=(*colour, 255), width=2 * SHARPER)
        pen.text(tuple(corner + 1.28 * arm), name, font=_font(18), fill=(*colour, 255), anchor="mm")


def _font(size: int):
    from PIL import ImageFont

    return ImageFont.load_default(size * SHARPER)
