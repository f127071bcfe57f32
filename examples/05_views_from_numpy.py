"""
From NumPy arrays to a .vdb file
================================

Everything the command line does is a function. Pictures may come from anywhere, as arrays in the way files hold
them: (rows, columns) or (rows, columns, channels), top row first.
"""

# %%
# Two pictures, made here from a formula: a torch that leans to the right, seen from the front and from the side.

import numpy as np
from gallery import folder

import warpfluid as wf

rows, columns = np.mgrid[0:60, 0:40]
height = 1 - rows / 59


def torch(lean: float) -> np.ndarray:
    """Return a picture of a flickering torch, uint8."""
    across = (columns - 19.5 - lean * 8 * height) / (7 * (1.1 - height))
    flicker = 1 + 0.5 * np.sin(9 * across + 14 * height) * np.sin(20 * height + 3 * lean)
    return np.clip(200 * np.exp(-(across**2)) * flicker * (height < 0.9), 0, 255).astype(np.uint8)


views = wf.Views.from_pictures([torch(1.0), torch(0.0)], angles_deg=[0, 90])
print("images (view, u, v):", views.images.shape, "at", views.angles_deg)

# %%
# A preview: fewer iterations. ``progress`` is called after each of them.

options = wf.ReconstructOptions(iterations=4)
result = wf.reconstruct(views, options, progress=lambda i, energy: print(f"iteration {i}: {energy:.3g}"), device="cpu")

# %%
# ``density`` has the axes of files, (x, y, z). Blender wants z up.

path = folder() / "torch.0001.vdb"
wf.write_vdb(path, {"density": result.density}, voxel_size=0.01, up="z")
back = wf.read_vdb(path)
print(f"wrote {path}: {path.stat().st_size / 1000:.0f} kB")
assert np.array_equal(back.grids["density"], result.density)

# %%
# NumPy users may prefer .npz. A film needs no graphics library.

wf.write_npz(folder() / "torch.0001.npz", result.density, voxel_size=0.01, frame=1)
wf.write_turntable(folder() / "torch.webp", result.volume, rate=12, pictures=24)
