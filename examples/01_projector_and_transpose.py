"""
The projector and its transpose
===============================

A camera at angle t sees the voxel (x, z) at the column u = x cos t + z sin t, and an emissive fluid adds up along
the ray. Over all angles that is the matrix B of Eq. 1. It is never stored: ``Projector`` casts the rays.
"""

# %%
# Three lamps of different brightness make the geometry visible. Volumes have the axes (x, z, y).

import numpy as np
from gallery import panel, save, shown

import warpfluid as wf

size, height = 64, 32
volume = np.zeros((size, size, height), np.float32)
for x, z, y, light in ((52, 34, 16, 8), (32, 54, 6, 5), (12, 22, 24, 3)):
    volume[x - 2 : x + 3, z - 2 : z + 3, y - 2 : y + 3] = light

angles_deg = np.arange(180)
projector = wf.Projector(angles_deg, volume.shape, device="cpu")
images = projector @ volume
print("images (angle, u, v):", images.shape)

save(
    "01_lamps.png",
    panel({f"{angle} degrees": shown(images[angle], white=40, zoom=3) for angle in (0, 30, 60, 90)}),
)

# %%
# All views of a row together are a sinogram: every lamp draws a sine of its own. Here all rows are added up.

sinogram = images.sum(axis=2)
save("01_sinogram.png", panel({"column u over the angle, 0 to 179 degrees": shown(sinogram, white=200, zoom=3)}))

# %%
# The light of a row is the same in every view, because a voxel's footprint is a box of constant area. With the
# linear weights of Joseph it swings with the angle.

single = np.zeros((size, size, 1), np.float32)
single[40, 25] = 1
for footprint in ("box", "joseph"):
    light = wf.Projector(angles_deg, single.shape, footprint=footprint, device="cpu").project(single).sum(axis=(1, 2))
    print(f"{footprint:>6}: one voxel gives {light.min():.3f} to {light.max():.3f}")

# %%
# ``projector.T`` is the exact transpose: <B v, o> = <v, B^T o> for any v and o, up to the rounding of float32.
# Conjugate gradients rely on it.

rng = np.random.default_rng(0)
v, o = rng.random(volume.shape, np.float32), rng.random(images.shape, np.float32)
left = np.vdot((projector @ v).astype(np.float64), o)
right = np.vdot(v, (projector.T @ o).astype(np.float64))
print(f"<B v, o> = {left:.6f}, <v, B^T o> = {right:.6f}, difference {abs(left / right - 1):.1e}")

# %%
# The transpose smears every pixel back along its ray. From above, the lamps are where the smears cross.

smeared = projector.T @ images
above = {"the volume from above": volume.sum(axis=2), "back-projected": smeared.sum(axis=2)}
pictures = {name: shown(field[:, ::-1], "jet", white=field.max(), zoom=3) for name, field in above.items()}
save("01_backprojection.png", panel(pictures))
