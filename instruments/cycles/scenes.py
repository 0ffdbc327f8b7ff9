"""Renders plates and truths of depth of field by Blender Cycles.

    python scenes.py FOLDER SCENE...

Needs bpy 4.5 from PyPI (Python 3.11). Writes FOLDER/SCENE_plate.exr, a pinhole's picture with its depth in metres along the axis;
FOLDER/SCENE_truth.exr, the same camera with its aperture open; and FOLDER/SCENE.json, the camera. Surfaces emit their own light and reflect
none, so that nothing but the aperture differs. Scenes: grass, hair, street, lamps, leaves.
"""

import json
import math
import random
import sys
from pathlib import Path

import bpy
from mathutils import Vector

WIDTH, HEIGHT = 480, 270
SENSOR_MM = 36.0


class Stage:
    """An empty scene with a camera at the origin that looks along +y, z up."""

    def __init__(self, focal_mm, f_number, focus_m, blades=0):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.scene = scene = bpy.context.scene
        scene.render.engine = "CYCLES"
        scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
        scene.cycles.max_bounces = 0
        scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
        scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BLACKMAN_HARRIS", 1.5
        scene.view_settings.view_transform = "Raw"
        scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
        scene.render.image_settings.color_depth = "32"
        scene.view_layers[0].use_pass_z = True
        scene.world = bpy.data.worlds.new("sky")
        scene.world.use_nodes = True
        sky = scene.world.node_tree.nodes["Background"]
        sky.inputs["Color"].default_value = (0.18, 0.23, 0.3, 1)
        camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        scene.collection.objects.link(camera)
        scene.camera, self.camera = camera, camera.data
        camera.rotation_euler = (math.pi / 2, 0, 0)
        self.camera.sensor_width, self.camera.clip_end, self.camera.lens = SENSOR_MM, 1000, focal_mm
        dof = self.camera.dof
        dof.focus_distance, dof.aperture_fstop, dof.aperture_blades = focus_m, f_number, blades
        # Cycles has one corner above the middle; `--rotation 30` turns the corner of a hexagon there.
        dof.aperture_rotation = 0.0
        self.focal_px = focal_mm / SENSOR_MM * WIDTH

    def point(self, column, row, distance):
        """Returns the point seen in a pixel at a distance along the axis."""
        across, up = column - WIDTH / 2, HEIGHT / 2 - row
        return Vector((across * distance / self.focal_px, distance, up * distance / self.focal_px))

    def add(self, data, material):
        data.materials.append(material)
        thing = bpy.data.objects.new("thing", data)
        self.scene.collection.objects.link(thing)

    def polygon(self, corners, material):
        mesh = bpy.data.meshes.new("polygon")
        mesh.from_pydata(corners, [], [tuple(range(len(corners)))])
        self.add(mesh, material)

    def wall(self, distance, material):
        self.polygon([(x, distance, z) for x, z in ((-60, -30), (60, -30), (60, 30), (-60, 30))], material)

    def ground(self, height, material):
        self.polygon([(x, y, height) for x, y in ((-30, 0.5), (30, 0.5), (30, 80), (-30, 80))], material)

    def box(self, low, high, material):
        corner = [[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)]
        for side in ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)):
            self.polygon([corner[k] for k in side], material)

    def ball(self, middle, radius, material):
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4, radius=radius, location=middle)
        bpy.context.object.data.materials.append(material)

    def strand(self, points, radius, material):
        curve = bpy.data.curves.new("strand", "CURVE")
        curve.dimensions, curve.bevel_depth, curve.bevel_resolution = "3D", radius, 1
        spline = curve.splines.new("POLY")
        spline.points.add(len(points) - 1)
        for target, point in zip(spline.points, points):
            target.co = (*point, 1)
        self.add(curve, material)


def light(colour, other=None, pattern=None, scale=1.0, strength=1.0):
    """Returns a surface that emits a colour, or a pattern (Checker, Brick, Noise) of two."""
    material = bpy.data.materials.new("light")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    emission = tree.nodes.new("ShaderNodeEmission")
    emission.inputs["Strength"].default_value = strength
    tree.links.new(emission.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    one, two = (*colour, 1), (*(other or colour), 1)
    if pattern is None:
        emission.inputs["Color"].default_value = one
        return material
    texture = tree.nodes.new(f"ShaderNodeTex{pattern}")
    texture.inputs["Scale"].default_value = scale
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Object"], texture.inputs["Vector"])
    result = texture.outputs["Color"]
    if pattern == "Noise":
        mix = tree.nodes.new("ShaderNodeMix")
        mix.data_type = "RGBA"
        mix.inputs[6].default_value, mix.inputs[7].default_value = one, two
        tree.links.new(texture.outputs[0], mix.inputs[0])
        result = mix.outputs[2]
    else:
        texture.inputs["Color1"].default_value = one
        texture.inputs["Mortar" if pattern == "Brick" else "Color2"].default_value = two
        if pattern == "Brick":
            texture.inputs["Color2"].default_value = (*(0.6 * c for c in colour), 1)
    tree.links.new(result, emission.inputs["Color"])
    return material


def grass():
    """Blades of grass from 1.6 to 9.6 m, in focus at 4 m."""
    stage = Stage(50, 1.4, 4.0)
    stage.ground(-1.0, light((0.05, 0.1, 0.02), (0.3, 0.35, 0.1), "Noise", 3))
    stage.wall(40, light((0.5, 0.3, 0.2), (0.6, 0.6, 0.6), "Checker", 0.4))
    greens = [light((random.uniform(0.1, 0.3), random.uniform(0.3, 0.7), random.uniform(0.05, 0.15))) for _ in range(12)]
    for _ in range(700):
        y = 1.6 + 8 * random.random() ** 1.3
        x, height, lean = random.uniform(-0.5, 0.5) * y, random.uniform(0.35, 0.95), random.uniform(-0.25, 0.25)
        half = random.uniform(0.006, 0.014)
        left, right = [], []
        for k in range(6):
            up = k / 5
            middle, width = x + lean * up**2, half * (1 - 0.95 * up)
            left.append((middle - width, y, -1 + height * up))
            right.append((middle + width, y, -1 + height * up))
        stage.polygon(left + right[::-1], random.choice(greens))
    return stage


def hair():
    """Strands of hair at 3 m before a sharp wall at 22 m."""
    stage = Stage(50, 1.4, 22.0)
    stage.wall(22, light((0.7, 0.6, 0.3), (0.1, 0.2, 0.4), "Checker", 1.2))
    stage.ball((0, 3, -0.35), 0.22, light((0.5, 0.35, 0.28), (0.8, 0.6, 0.5), "Noise", 8))
    browns = [light(c) for c in ((0.12, 0.07, 0.04), (0.3, 0.18, 0.1), (0.5, 0.35, 0.2))]
    for _ in range(260):
        turn, length = random.uniform(0, math.pi), random.uniform(0.1, 0.35)
        root = Vector((0.22 * math.cos(turn), 3 + random.uniform(-0.1, 0.1), -0.35 + 0.22 * math.sin(turn)))
        along = Vector((math.cos(turn) + random.uniform(-0.4, 0.4), random.uniform(-0.2, 0.2), math.sin(turn) + random.uniform(-0.4, 0.4)))
        points = [root + along * (length * k / 5) - Vector((0, 0, 0.12 * (k / 5) ** 2)) for k in range(6)]
        stage.strand(points, 0.0022, random.choice(browns))
    return stage


def street():
    """Walls, poles, wires, balls and far lamps along a street, in focus at 6 m."""
    stage = Stage(35, 1.4, 6.0)
    stage.ground(-1.2, light((0.25, 0.25, 0.27), (0.18, 0.18, 0.2), "Checker", 1.5))
    stage.box((-12, 5, -1.2), (-3, 30, 8), light((0.5, 0.25, 0.2), (0.5, 0.5, 0.5), "Brick", 2))
    stage.box((3.2, 8, -1.2), (12, 40, 9), light((0.6, 0.55, 0.4), (0.2, 0.22, 0.3), "Checker", 1.3))
    stage.wall(60, light((0.5, 0.6, 0.8), (0.9, 0.9, 1), "Noise", 0.1))
    for y in (3, 6, 12, 20):
        stage.strand([(-2.2, y, -1.2), (-2.2, y, 4)], 0.05, light((0.03, 0.03, 0.03)))
    for k in range(5):
        stage.strand([(-2.2 + 0.1 * k, 2 + k, 2.2), (3.2, 12 + k, 2.5)], 0.012, light((0.02, 0.02, 0.02)))
    stage.ball((0.4, 6, -0.4), 0.5, light((0.8, 0.1, 0.1), (0.9, 0.8, 0.2), "Checker", 6))
    stage.ball((-0.6, 2.2, -0.5), 0.25, light((0.1, 0.2, 0.6), (0.5, 0.7, 0.9), "Noise", 6))
    stage.ball((1.5, 15, -0.3), 0.8, light((0.2, 0.6, 0.3), (0.9, 0.9, 0.9), "Checker", 4))
    for _ in range(14):
        y = random.uniform(14, 50)
        lamp = light((1, 0.8, 0.5), strength=random.choice([6, 20, 60]))
        stage.ball((random.uniform(-2, 3), y, random.uniform(-0.5, 3)), 0.005 * y, lamp)
    return stage


def lamps():
    """Small lamps from 5 to 28 m through an iris of six blades, beside a sharp box and a near pole."""
    stage = Stage(85, 1.4, 3.0, blades=6)
    stage.wall(30, light((0.02, 0.03, 0.06), (0.1, 0.1, 0.14), "Noise", 0.4))
    for _ in range(16):
        distance = random.choice([5, 8, 12, 20, 28])
        middle = stage.point(random.uniform(30, 450), random.uniform(25, 245), distance)
        colour = [random.uniform(0.4, 1) for _ in range(3)]
        lamp = light(colour, strength=random.choice([30, 100, 300, 1000]))
        stage.ball(middle, random.uniform(1, 2.5) * distance / stage.focal_px, lamp)
    stage.box((-0.25, 3, -0.6), (0.1, 3.3, 0.2), light((0.6, 0.2, 0.1), (0.9, 0.7, 0.3), "Checker", 12))
    stage.strand([stage.point(330, 0, 2.2), stage.point(300, 270, 2.2)], 0.012, light((0.2, 0.22, 0.2)))
    return stage


def leaves():
    """Large leaves and a twig at 0.9 to 1.4 m before a sharp wall at 5 m."""
    stage = Stage(50, 1.4, 5.0)
    stage.wall(5, light((0.55, 0.5, 0.45), (0.15, 0.15, 0.18), "Checker", 5))
    for _ in range(14):
        distance = random.uniform(0.9, 1.4)
        column, row, turn = random.uniform(0, WIDTH), random.uniform(0, HEIGHT) * 0.7, random.uniform(0, math.pi)
        length, width = random.uniform(40, 70), random.uniform(14, 24)
        outline = [(length * math.cos(a), width * math.sin(a) * (1 - 0.3 * math.cos(a))) for a in (k * math.pi / 16 for k in range(32))]
        corners = [stage.point(column + u * math.cos(turn) - v * math.sin(turn), row + u * math.sin(turn) + v * math.cos(turn), distance) for u, v in outline]
        stage.polygon(corners, light((0.1, random.uniform(0.25, 0.4), 0.06), (0.2, 0.5, 0.12), "Noise", 30))
    stage.strand([stage.point(0, 220, 1.1), stage.point(WIDTH, 40, 1.3)], 0.008, light((0.12, 0.08, 0.06)))
    return stage


def render(stage, name, folder, samples, is_open):
    stage.camera.dof.use_dof = is_open
    stage.scene.cycles.samples, stage.scene.cycles.seed = samples, int(is_open)
    stage.scene.render.filepath = str(folder / f"{name}_{'truth' if is_open else 'plate'}.exr")
    bpy.ops.render.render(write_still=True)


def main():
    folder = Path(sys.argv[1]).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    for name in sys.argv[2:]:
        random.seed(7)
        stage = {scene.__name__: scene for scene in (grass, hair, street, lamps, leaves)}[name]()
        dof = stage.camera.dof
        camera = {
            "focal_mm": stage.camera.lens,
            "f_number": dof.aperture_fstop,
            "focus_m": dof.focus_distance,
            "blades": dof.aperture_blades,
            "size": [WIDTH, HEIGHT],
            "pitch_um": 1000 * SENSOR_MM / WIDTH,
            # Radius of a disc in px per 1/m of vergence: half the aperture times the focal length in px.
            "px_per_vergence": stage.camera.lens / 1000 / dof.aperture_fstop / 2 * stage.focal_px,
        }
        (folder / f"{name}.json").write_text(json.dumps(camera))
        render(stage, name, folder, 256, False)
        render(stage, name, folder, 4096 if name == "lamps" else 1024, True)


main()
