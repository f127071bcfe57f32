"""
Our pictures beside those of a path tracer
==========================================

``warpfluid render`` takes seconds where a path tracer takes minutes, and pays with an approximation: light that is
scattered more than once is estimated. Here are fire, smoke and an explosion by both, with the same volume, lamps and
camera. It needs Blender (``blender`` in the path, or the variable ``WARPFLUID_BLENDER``), and some minutes.
"""

# %%
# Both get the same numbers: what the look makes of a volume is written as grids of extinction, albedo and glow, which
# the path tracer reads as they are.

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import warp as wp
from gallery import panel, save

from warpfluid.device import pick_device
from warpfluid.files.exr import read_exr
from warpfluid.files.vdb import write_vdb
from warpfluid.options import CameraOptions, LightOptions, RenderOptions
from warpfluid.rendering.display import quantize
from warpfluid.rendering.framing import cameras
from warpfluid.rendering.lamps import ABOVE, AMBIENT, BELOW, Lamps
from warpfluid.rendering.picture import Picture
from warpfluid.rendering.studio import make_studio
from warpfluid.rendering.turntable import in_a_row
from warpfluid.volumes import open_volumes

SIZE, SAMPLES, BOUNCES = (210, 280), 32, 12
VOXEL = 0.01
PROGRAM = os.environ.get("WARPFLUID_BLENDER", "blender")
CASES = {"fire": ("fire", "1-4", 4), "smoke": ("smoke", "1-48", 48), "explosion": ("explosion", "1-18", 18)}

CYCLES = """
import json, math, sys
import bpy

job = json.load(open(sys.argv[-1]))
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
bpy.ops.object.volume_import(filepath=job["volume"], align="WORLD")
if bpy.app.version < (5, 0, 0):  # which took the index of a voxel for its corner, not its centre
    bpy.context.object.location = [-job["voxel"] / 2] * 3
material = bpy.data.materials.new("fluid")
material.use_nodes = True
nodes, links = material.node_tree.nodes, material.node_tree.links
nodes.clear()
out, volume = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNodeVolumePrincipled")
for name in ("Density Attribute", "Color Attribute", "Temperature Attribute"):
    volume.inputs[name].default_value = ""
volume.inputs["Absorption Color"].default_value = (0, 0, 0, 1)
volume.inputs["Emission Strength"].default_value = 1
volume.inputs["Anisotropy"].default_value = job["anisotropy"]
for grid, socket in (("density", "Density"), ("albedo", "Color"), ("glow", "Emission Color")):
    attribute = nodes.new("ShaderNodeAttribute")
    attribute.attribute_name = grid
    links.new(attribute.outputs["Fac" if grid == "density" else "Color"], volume.inputs[socket])
links.new(volume.outputs[0], out.inputs["Volume"])
bpy.context.object.data.materials.append(material)
sun = bpy.data.objects.new("key", bpy.data.lights.new("key", "SUN"))
sun.data.energy, sun.data.color, sun.data.angle = job["strength"], job["color"], 0
x, y, z = job["direction"]
from mathutils import Vector
sun.rotation_mode = "QUATERNION"
sun.rotation_quaternion = Vector((x, -z, y)).to_track_quat("Z", "Y")
scene.collection.objects.link(sun)
scene.world = bpy.data.worlds.new("sky")
scene.world.use_nodes = True
tree = scene.world.node_tree
place, split, mix = (tree.nodes.new(f"ShaderNode{n}") for n in ("TexCoord", "SeparateXYZ", "MixRGB"))
half = tree.nodes.new("ShaderNodeMath")
half.operation, half.inputs[1].default_value, half.inputs[2].default_value = "MULTIPLY_ADD", 0.5, 0.5
tree.links.new(place.outputs["Generated"], split.inputs[0])
tree.links.new(split.outputs["Z"], half.inputs[0])
tree.links.new(half.outputs[0], mix.inputs[0])
mix.inputs[1].default_value, mix.inputs[2].default_value = (*job["below"], 1), (*job["above"], 1)
tree.links.new(mix.outputs[0], tree.nodes["Background"].inputs["Color"])
camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
camera.data.type, camera.data.ortho_scale = "ORTHO", job["scale"]
camera.location, camera.rotation_euler = (0, -5, job["middle"]), (math.pi / 2, 0, 0)
scene.collection.objects.link(camera)
scene.camera, scene.render.engine = camera, "CYCLES"
scene.cycles.samples = job["samples"]
scene.cycles.volume_bounces = scene.cycles.max_bounces = job["bounces"]
scene.cycles.volume_step_rate, scene.cycles.use_denoising, scene.cycles.transparent_max_bounces = 0.5, False, 64
scene.render.film_transparent = True
scene.render.resolution_x, scene.render.resolution_y = job["size"]
scene.view_settings.view_transform = "Raw"
settings = scene.render.image_settings
settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGBA", "32"
scene.render.filepath = job["out"]
bpy.ops.render.render(write_still=True)
"""


def baked(medium) -> dict[str, np.ndarray]:
    """Return a medium's extinction and glow [1/scene unit] and its albedo as grids (x, y, z)."""
    grids = {}
    for name, curve, unit in (
        ("density", medium.extinction, VOXEL),
        ("albedo", medium.albedo, 1.0),
        ("glow", medium.emission, VOXEL),
    ):
        if curve is None:
            found = np.zeros((*medium.shape, 3), np.float32)
        else:
            found = curve.at(medium.fields[curve.field].numpy()) / unit
            found *= medium.fields[curve.times].numpy().reshape(*medium.shape, 1) if curve.times else 1
        found = found[..., [0, 2, 1]] * [1, 1, -1] if found.ndim == 4 else found  # z up turns colours as if vectors
        grids[name] = np.ascontiguousarray(found.astype(np.float32).swapaxes(1, 2))
    met = (grids["density"] > 0) | (grids["glow"][..., 0] > 0)
    return {name: np.where(met.reshape(met.shape + (1,) * (grid.ndim - 3)), grid, 0) for name, grid in grids.items()}


def path_traced(folder: Path, medium, light: LightOptions) -> Picture:
    """Return Cycles' picture, in linear light."""
    width, depth, height = medium.shape
    origin = (-(width - 1) / 2 * VOXEL, 0.5 * VOXEL, -(depth - 1) / 2 * VOXEL)
    write_vdb(folder / "fluid.vdb", baked(medium), voxel_size=VOXEL, origin=origin, up="z")
    (sun,) = Lamps(light).at(1).suns
    sky = AMBIENT * np.array([float(part) for part in light.ambient_color.split(",")])
    job = {
        "volume": str(folder / "fluid.vdb"),
        "out": str(folder / "cycles.exr"),
        "voxel": VOXEL,
        "anisotropy": medium.anisotropy,
        "strength": float(max(sun.color)),
        "color": (sun.color / max(sun.color)).tolist(),
        "direction": list(sun.direction),
        "above": (ABOVE * sky).tolist(),
        "below": (BELOW * sky).tolist(),
        "scale": max(width / SIZE[0], height / SIZE[1]) * max(SIZE) * VOXEL,
        "middle": height / 2 * VOXEL,
        "size": SIZE,
        "samples": SAMPLES,
        "bounces": BOUNCES,
    }
    (folder / "job.json").write_text(json.dumps(job))
    (folder / "cycles.py").write_text(CYCLES)
    begin = [PROGRAM, "--background", "--factory-startup", "--python-exit-code", "1", "--python"]
    subprocess.run([*begin, folder / "cycles.py", "--", folder / "job.json"], check=True, capture_output=True)
    color = read_exr(folder / "cycles.exr")
    nothing = np.zeros(color.shape[:2], np.float32)
    return Picture(color, nothing, nothing, nothing, color)


# %%
# Every look with its own preset; ours on the left. Both are developed in the same way.

rows = []
for look, (preset, frames, frame) in CASES.items():
    folder = Path(tempfile.mkdtemp(prefix=f"warpfluid-{look}-"))
    source = sys.argv[2 + list(CASES).index(look)] if len(sys.argv) > 4 else str(folder / "run")
    if not Path(source).exists():
        flags = f"simulate --preset {preset} --size 48x64 --frames {frames} --no-turntable --quiet -o {source}"
        subprocess.run([sys.executable, "-m", "warpfluid", *flags.split()], check=True)
    light, device = LightOptions(), pick_device("cpu")
    studio = make_studio(RenderOptions(look=look, rolloff=0.6), Lamps(light), look, device)
    fields = open_volumes(source).fields(frame, studio.names)
    begin = time.perf_counter()
    lit = studio.light(fields, 1)
    (camera,) = cameras(CameraOptions(projection="orthographic"), lit.medium.shape, SIZE, 1)
    ours = studio.shoot(lit, camera, 1)
    took = time.perf_counter() - begin
    begin = time.perf_counter()
    theirs = path_traced(folder, lit.medium, light)
    wp.synchronize()
    seconds = f"{took:.1f} s", f"{time.perf_counter() - begin:.0f} s"
    pictures = [quantize(studio.screen(picture, 1)) for picture in (ours, theirs)]
    rows.append(panel(dict(zip((f"{look}, warpfluid {seconds[0]}", f"Cycles {seconds[1]}"), pictures, strict=True))))
    ratio = ours.color.sum() / theirs.color.sum()
    apart = np.abs(ours.color - theirs.color).mean() / theirs.color.mean()
    print(f"{look}: light {ratio:.2f} of the path tracer's, mean difference {apart:.0%} of its mean")
save("beside-cycles.png", in_a_row(rows))
