"""
Looks: what a volume's numbers mean
===================================

A volume holds amounts: density, heat, flame. A look says what they are as light, by ramps, so that one volume can be
soot, steam or a diagram. Theory first: a ray gathers light that is given off and scattered along it, weakened by what
is in front, L = ∫ T(s) (e(s) + σ(s) a(s) Lin(s)) ds with T(s) = exp(−∫ σ). The ramps are e, σ and a.
"""

# %%
# A small ball, denser and hotter in its middle; amounts are in the units of looks: 1 is full.

import numpy as np
from gallery import panel, save

from warpfluid.device import pick_device
from warpfluid.options import LightOptions, RenderOptions
from warpfluid.rendering.camera import orthographic
from warpfluid.rendering.display import quantize
from warpfluid.rendering.lamps import Lamps
from warpfluid.rendering.look_files import look_names, make_look
from warpfluid.rendering.looks import amount_of_one
from warpfluid.rendering.studio import Studio, make_studio

SIZE = 40
axis = np.linspace(-1.25, 1.25, SIZE)
x, z, y = np.meshgrid(axis, axis, axis, indexing="ij")
bumps = 0.12 * np.sin(7 * x + 2) * np.sin(6 * y) * np.sin(8 * z + 1)
ball = np.clip(6 * (1 - np.sqrt(x**2 + y**2 + z**2) + bumps), 0, 1).astype(np.float32)
hot = np.clip(1.6 - 1.4 * np.sqrt(x**2 + (y + 0.2) ** 2 + z**2), 0, 1.6).astype(np.float32) * ball
fields = {"density": 2 * ball * np.float32(amount_of_one("density", SIZE)), "temperature": hot}

# %%
# All looks of the package. What a look wants and the volume lacks, density stands in for.

device, lamps = pick_device("cpu"), Lamps(LightOptions())


def picture(studio: Studio) -> np.ndarray:
    """Return the ball, seen from the front."""
    seen = studio.shoot(studio.light(fields, 1), orthographic(ball.shape, size=(160, 160)), 1)
    return quantize(studio.screen(seen, 1))


row = {name: picture(make_studio(RenderOptions(look=name), lamps, name, device)) for name in look_names()}
save("08_looks.png", panel(row))

# %%
# A look of one's own: sulphur. Blue flames by temperature, thin yellow smoke.

sulphur = make_look(
    {
        "color": {"stops": [[0, [0.95, 0.85, 0.3]]]},
        "emission": {"input": "temperature", "stops": [[0.3, 0], [0.7, [0.1, 0.3, 3]], [1, [2, 3, 9]]]},
        "opacity": {"stops": [[0, 0], [1, 1.5]]},
    },
    "sulphur",
)
mine = picture(Studio(options=RenderOptions(), lamps=lamps, look=sulphur, ramp="gray", device=device))
print(f"sulphur: brightest pixel {mine.max(axis=(0, 1))}")
save("08_sulphur.png", mine)
