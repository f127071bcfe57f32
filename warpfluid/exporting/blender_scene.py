"""Open exported volumes in Blender: a scene with material, camera and light.

    blender --python open_in_blender.py
    blender -b --python open_in_blender.py -- --render fire.png --frame 24

It stands beside the volumes that ``warpfluid export --format blender`` wrote, and reads ``export.json`` there. After
``--`` it takes ``--look fire|smoke|explosion|plain``, ``--frame N``, ``--size WIDTHxHEIGHT``, ``--samples N``,
``--front`` (the view of the footage's front camera, without a lens), ``--motion-blur`` (along the velocity),
``--render FILE`` (one picture), ``--animation FILE`` (all frames; ``fire.####.png``) and ``--save FILE.blend``.
It needs nothing but Blender, from 3.0 on.
"""

import argparse
import json
import math
import os
import sys

import bpy
from mathutils import Quaternion, Vector

HERE = os.path.dirname(os.path.abspath(__file__))
WHITE = 255.0  # ray sum that is white
THICK = 12.0  # optical depth of the thickest ray of smoke
FLAME = ((0.0, (0.4, 0.02, 0.0)), (0.3, (1.0, 0.14, 0.01)), (0.65, (1.0, 0.34, 0.04)), (1.0, (1.0, 0.58, 0.16)))
SKIES = {"fire": 0.0, "plain": 0.0, "explosion": 0.015, "smoke": 0.03}
FLAME_VOXELS = 9.0  # of full flame in a row are white
BRIGHT = 1.5  # colours are darker than white
LENS_MM, SENSOR_MM = 50.0, 36.0


def main():
    """Build the scene, and render it if asked to."""
    choices = read_choices(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else [])
    with open(os.path.join(HERE, "export.json"), encoding="utf-8") as file:
        record = json.load(file)
    clear()
    look = choices.look or look_of(record)
    volume = add_volume(record)
    volume.data.materials.append(make_material(record, look))
    low, high = box_of(record)
    add_camera(low, high, choices)
    add_lights(low, high, look)
    for body in record["bodies"]:
        add_body(body, record)
    set_up_render(record, look, choices)
    if choices.save:
        bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(choices.save))
    if choices.render:
        bpy.context.scene.render.filepath = os.path.abspath(choices.render)
        bpy.ops.render.render(write_still=True)
    if choices.animation:
        bpy.context.scene.render.filepath = os.path.abspath(choices.animation)
        bpy.ops.render.render(animation=True)


def read_choices(arguments):
    """Read what follows ``--``."""
    parser = argparse.ArgumentParser(prog="open_in_blender.py", add_help=False)
    parser.add_argument("--look", choices=("fire", "smoke", "explosion", "plain"))
    parser.add_argument("--frame", type=int)
    parser.add_argument("--size", default="")
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--front", action="store_true", help="look along the front view of the footage, without lens")
    parser.add_argument("--motion-blur", action="store_true", help="blur along the velocity")
    parser.add_argument("--render")
    parser.add_argument("--animation")
    parser.add_argument("--save")
    return parser.parse_args(arguments)


def look_of(record):
    """Return the look that was asked for, or that the volumes suggest."""
    asked = record["options"]["look"]
    if asked != "auto":
        return asked
    if any("flame" in facts["grids"] for facts in record["frames"].values()):
        return "explosion"
    return "smoke" if record.get("look") == "smoke" else "fire"


def clear():
    """Leave nothing of the scene that Blender starts with."""
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)


def add_volume(record):
    """Add the sequence as one object."""
    frames = sorted(int(frame) for frame in record["frames"])
    facts = record["frames"][str(frames[0])]
    data = bpy.data.volumes.new("volume")
    data.filepath = os.path.join(HERE, facts["file"])
    if len(frames) > 1:
        data.is_sequence = True
        data.frame_start, data.frame_offset = frames[0], frames[0] - 1
        data.frame_duration = frames[-1] - frames[0] + 1
        data.sequence_mode = "CLIP"
    if hasattr(data, "velocity_grid") and any(record["velocity"] in f["grids"] for f in record["frames"].values()):
        data.velocity_grid, data.velocity_unit = record["velocity"], "SECOND"
    volume = bpy.data.objects.new("volume", data)
    # Before 5.0 Blender took a voxel's index for its corner, which is its centre: this moves the volume to its place.
    if bpy.app.version < (5, 0, 0):
        volume.location = [-facts["voxel_size"] / 2] * 3
    bpy.context.collection.objects.link(volume)
    return volume


def make_material(record, look):
    """Make light and smoke of the grids; nothing shines or dims where they are zero."""
    material = bpy.data.materials.new(look)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    output, shader = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNodeVolumePrincipled")
    output.location, shader.location = (600, 0), (300, 0)
    links.new(shader.outputs["Volume"], output.inputs["Volume"])
    shader.inputs["Density Attribute"].default_value = ""
    shader.inputs["Density"].default_value = 0.0
    shader.inputs["Blackbody Intensity"].default_value = 0.0
    if "Temperature Attribute" in shader.inputs:
        shader.inputs["Temperature Attribute"].default_value = ""
    voxel, brightest, full = measures(record)
    if look in ("smoke", "explosion"):
        thick = (THICK if look == "smoke" else THICK / 2) / (max(brightest, 1e-30) * voxel)
        density = attribute(nodes, "density", -600, -200)
        links.new(scaled(nodes, links, density, thick, -300, -200, "smoke"), shader.inputs["Density"])
        shade = 0.9 if look == "smoke" else 0.2
        shader.inputs["Color"].default_value = (shade, shade, shade, 1)
        shader.inputs["Anisotropy"].default_value = 0.3
    if look != "smoke":
        add_glow(material, shader, look, voxel, full)
    return material


def add_glow(material, shader, look, voxel, full):
    """Make light of the flame of an explosion, or of the density."""
    nodes, links = material.node_tree.nodes, material.node_tree.links
    grid = "flame" if look == "explosion" else "density"
    most = max(full.get(grid, 1.0), 1e-30)
    value = attribute(nodes, grid, -600, 200)
    gain = 1 / ((WHITE if grid == "density" else FLAME_VOXELS * most) * voxel)
    gain *= 1.0 if look == "plain" else BRIGHT
    light = scaled(nodes, links, value, gain, -300, 200, "light")
    if grid == "flame":  # hot gas shines far more than warm gas
        light = scaled(nodes, links, light, scaled(nodes, links, value, 1 / most, -300, 50, "heat"), 0, 100, "glow")
    links.new(light, shader.inputs["Emission Strength"])
    shader.inputs["Emission Color"].default_value = (1, 1, 1, 1)
    if look != "plain":
        links.new(
            flame_colours(nodes, links, value, most if grid == "density" else 1.3 * most),
            shader.inputs["Emission Color"],
        )


def measures(record):
    """Return the voxel size, the brightest ray sum and the full value of every grid."""
    frames = list(record["frames"].values())
    full = {}
    for facts in frames:
        for name, value in facts["full"].items():
            full[name] = max(full.get(name, 0.0), value)
    return frames[0]["voxel_size"], max(facts["brightest_ray"] for facts in frames), full


def attribute(nodes, name, x, y):
    """Return the values of a grid."""
    node = nodes.new("ShaderNodeAttribute")
    node.attribute_name, node.label, node.location = name, name, (x, y)
    return node.outputs["Fac"]


def scaled(nodes, links, value, factor, x, y, label):
    """Return a value times a number, which the user may change, or times another value."""
    node = nodes.new("ShaderNodeMath")
    node.operation, node.label, node.location = "MULTIPLY", label, (x, y)
    links.new(value, node.inputs[0])
    if isinstance(factor, float):
        node.inputs[1].default_value = factor
    else:
        links.new(factor, node.inputs[1])
    return node.outputs[0]


def flame_colours(nodes, links, value, full):
    """Return a flame's colour: deep red where it is thin, pale yellow where it is full."""
    ramp = nodes.new("ShaderNodeValToRGB")
    ramp.location = (-100, 450)
    stops = ramp.color_ramp.elements
    while len(stops) < len(FLAME):
        stops.new(0.5)
    for i, (position, colour) in enumerate(FLAME):
        stop = stops[i]
        stop.position, stop.color = position, (*colour, 1)
    links.new(scaled(nodes, links, value, 1 / full, -300, 450, "colour"), ramp.inputs["Fac"])
    return ramp.outputs["Color"]


def box_of(record):
    """Return the corners of the box over all frames, z up."""
    lows, highs = [], []
    for facts in record["frames"].values():
        size, (x, y, z) = facts["voxel_size"], facts["origin"]
        wide, tall, deep = (n * size for n in facts["shape"])
        x, y, z = x - size / 2, y - size / 2, z - size / 2
        lows.append((x, -z - deep, y))
        highs.append((x + wide, -z, y + tall))
    low = Vector([min(corner[axis] for corner in lows) for axis in range(3)])
    return low, Vector([max(corner[axis] for corner in highs) for axis in range(3)])


def add_camera(low, high, choices):
    """Look at the box from the front; with ``--front`` as the footage's front camera does, without a lens."""
    data = bpy.data.cameras.new("camera")
    camera = bpy.data.objects.new("camera", data)
    bpy.context.collection.objects.link(camera)
    scene, middle, sides = bpy.context.scene, (low + high) / 2, high - low
    scene.camera = camera
    camera.rotation_euler = (math.pi / 2, 0, 0)
    wide, tall = (int(n) for n in choices.size.split("x")) if choices.size else size_for(sides, choices.front)
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = wide, tall, 100
    reach = sides.length * 4
    if choices.front:
        data.type, data.ortho_scale = "ORTHO", max(sides.x, sides.z)
        camera.location = middle + Vector((0, -reach / 2, 0))
    else:
        data.lens, data.sensor_width = LENS_MM, SENSOR_MM
        half = SENSOR_MM / 2 / LENS_MM  # of the wider side of the picture, a unit away
        across, up = half * min(1, wide / tall), half * min(1, tall / wide)
        far = max(sides.x / 2 / across, sides.z / 2 / up) * 1.1 + sides.y / 2
        camera.location = middle + Vector((0, -far, 0))
        reach += far
    data.clip_end = reach * 2


def size_for(sides, exact):
    """Return pixels that fit the box: no more than 1080 high."""
    tall = 1080 if not exact else max(2, round(1080 * min(1, sides.z / sides.x)))
    return max(2, round(tall * max(0.5, sides.x / sides.z) / 2) * 2), tall


def add_lights(low, high, look):
    """Add a key light from the upper left and a soft one from the right."""
    middle, size = (low + high) / 2, (high - low).length
    if look in ("fire", "plain"):
        return
    for name, way, power, colour in (
        ("key", (-1.0, -0.5, 1.0), 9.0, (1.0, 0.95, 0.88)),
        ("fill", (1.2, -0.6, 0.2), 0.6, (0.6, 0.75, 1.0)),
    ):
        data = bpy.data.lights.new(name, "SUN")
        data.energy, data.color, data.angle = power if look == "smoke" else power / 3, colour, 0.05
        light = bpy.data.objects.new(name, data)
        light.location = middle + Vector(way).normalized() * size
        light.rotation_euler = (-Vector(way)).to_track_quat("-Z", "Y").to_euler()
        bpy.context.collection.objects.link(light)


def add_body(body, record):
    """Add a rigid body with its way."""
    mesh = bpy.data.meshes.new(body["name"])
    mesh.from_pydata([(x, -z, y) for x, y, z in body["vertices"]], [], body["triangles"])
    thing = bpy.data.objects.new(body["name"], mesh)
    thing.rotation_mode = "QUATERNION"
    bpy.context.collection.objects.link(thing)
    for frame, ((x, y, z), (a, b, c, w)) in body["poses"].items():
        thing.location, thing.rotation_quaternion = (x, -z, y), Quaternion((w, a, -c, b))
        thing.keyframe_insert("location", frame=int(frame))
        thing.keyframe_insert("rotation_quaternion", frame=int(frame))


def set_up_render(record, look, choices):
    """Choose engine, frames, background and tone."""
    scene, frames = bpy.context.scene, sorted(int(frame) for frame in record["frames"])
    scene.render.engine = "CYCLES"
    scene.cycles.samples = choices.samples
    # Not every Blender can denoise, and it smears wisps.
    for name, value in (("volume_max_steps", 4096), ("volume_step_rate", 1.0), ("use_denoising", False)):
        if hasattr(scene.cycles, name):
            setattr(scene.cycles, name, value)
    scene.frame_start, scene.frame_end = frames[0], frames[-1]
    scene.frame_set(choices.frame if choices.frame is not None else frames[len(frames) // 2])
    scene.render.fps = max(1, round(record["fps"]))
    scene.render.fps_base = scene.render.fps / record["fps"]
    scene.render.use_motion_blur = choices.motion_blur
    scene.view_settings.view_transform = record["tone"] if look == "plain" else "Standard"
    world = bpy.data.worlds.new("world")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (SKIES[look], SKIES[look], 1.2 * SKIES[look], 1)
    scene.world = world
    for suffix, kind in ((".exr", "OPEN_EXR"), (".png", "PNG")):
        if (choices.render or choices.animation or "").endswith(suffix):
            scene.render.image_settings.file_format = kind


main()
