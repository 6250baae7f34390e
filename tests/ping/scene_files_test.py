"""Meshes of the scene and height maps, read by readers of their own and held against closed forms."""
import json
import math
import shutil
import struct
import unittest

import numpy as np

import program

SONAR = """ensonify: 1
name: scene
seed: 5
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 6
  beams: {count: 24, fov_deg: 60}
  rays: {elevation: 24}
materials: {m: {reflectivity: 1e-2}, other: {reflectivity: 1e-3}}
"""
PATH = """trajectory:
  ping_rate_hz: 1
  pings: 2
  poses: [{time_s: 1, position_m: [0, 0, 0]}, {time_s: 2, position_m: [0.5, 1, 0], rotation_deg: [0, 20, 40]}]
"""
WORLD = SONAR + """objects:
  - {name: floor, class: bed, material: m, shape: {plane: {}}, pose: {position_m: [0, 0, -2], rotation_deg: [0, 5, 0]}}
  - {name: 'ball "1" ü', class: ball, material: other, shape: {sphere: {radius_m: 0.5}},
     pose: {position_m: [4, 0.5, -1]}}
  - name: ball 2
    class: ball
    material: m
    shape: {sphere: {radius_m: 0.5}}
    trajectory: {poses: [{time_s: 1, position_m: [3, -1, 0]}, {time_s: 2, position_m: [3, 1, 0]}]}
  - {name: post, class: post, material: m, shape: {box: {size_m: [0.5, 0.5, 3]}},
     pose: {position_m: [4, 2, -0.5], rotation_deg: [10, 20, 30]}}
output: {world: true, height_map: {spacing_m: 0.1}}
""" + PATH
PLANE_DEG = 5


def read_ply(path):
    """Vertices [count, 3], faces [count, 3], instances and classes of the faces."""
    data = path.read_bytes()
    head, body = data.split(b"end_header\n", 1)
    elements = [line.split() for line in head.decode().splitlines() if line.startswith("element")]
    counts = {name: int(count) for _, name, count in elements}
    vertices = np.frombuffer(body, "<f8", 3 * counts["vertex"]).reshape(-1, 3)
    face = np.dtype([("n", "u1"), ("corners", "<i4", 3), ("instance", "<u2"), ("class", "u1")])
    faces = np.frombuffer(body, face, counts["face"], vertices.nbytes)
    assert len(body) == vertices.nbytes + faces.nbytes
    assert (faces["n"] == 3).all()
    return vertices, faces


class Glb:
    """A binary glTF file by its specification, 2.0."""

    def __init__(self, path):
        data = path.read_bytes()
        magic, version, length = struct.unpack_from("<4sII", data)
        assert (magic, version, length) == (b"glTF", 2, len(data))
        size, kind = struct.unpack_from("<I4s", data, 12)
        assert kind == b"JSON" and size % 4 == 0
        self.json = json.loads(data[20 : 20 + size])
        rest, kind = struct.unpack_from("<I4s", data, 20 + size)
        assert kind == b"BIN\0"
        self.binary = data[28 + size :]
        assert rest == len(self.binary) == self.json["buffers"][0]["byteLength"]

    def array(self, index):
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        width = {"VEC3": 3, "SCALAR": 1}[accessor["type"]]
        kind = {5126: "<f4", 5125: "<u4"}[accessor["componentType"]]
        array = np.frombuffer(self.binary, kind, accessor["count"] * width, view["byteOffset"])
        assert array.nbytes == view["byteLength"]
        if "min" in accessor:
            np.testing.assert_array_equal(array.reshape(-1, width).min(0), np.float32(accessor["min"]))
            np.testing.assert_array_equal(array.reshape(-1, width).max(0), np.float32(accessor["max"]))
        return array.reshape(-1, width) if width > 1 else array

    def matrix(self, node):
        x, y, z, w = node.get("rotation", [0, 0, 0, 1])
        matrix = np.eye(4)
        matrix[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                          [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                          [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
        matrix[:3, 3] = node.get("translation", [0, 0, 0])
        return matrix

    def objects(self):
        """For each object its node, and the corners of its triangles in the frame of the scene [triangles, 3, 3]."""
        (root,) = self.json["scenes"][self.json["scene"]]["nodes"]
        root = self.json["nodes"][root]
        for child in root["children"]:
            node = self.json["nodes"][child]
            (primitive,) = self.json["meshes"][node["mesh"]]["primitives"]
            places = self.array(primitive["attributes"]["POSITION"]).astype(float)
            matrix = self.matrix(root) @ self.matrix(node)
            places = places @ matrix[:3, :3].T + matrix[:3, 3]
            yield node, places[self.array(primitive["indices"]).reshape(-1, 3)]


class Scene(program.Case):
    def world(self):
        return program.made(WORLD)

    def generate(self, scenario, *options):
        path = self.folder / "scene.yaml"
        path.write_text(scenario)
        out = self.folder / f"set{len(list(self.folder.iterdir()))}"
        result = program.run("generate", path, "-o", out, "--quiet", *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        result = program.run("verify", out)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        return out

    def sequence(self, scenario, *options):
        return self.generate(scenario, *options) / "sequences/000000"

    def heights(self, folder):
        """The map, and x and y of its points, from sequence.json."""
        grid = json.loads((folder / "sequence.json").read_text())["height_map"]
        heights = np.load(folder / "height_map.npy")
        self.assertEqual(heights.shape, (grid["rows"], grid["columns"]))
        self.assertEqual(heights.dtype, np.float32)
        x = grid["x_west_m"] + np.arange(grid["columns"]) * grid["spacing_m"]
        y = grid["y_north_m"] - np.arange(grid["rows"]) * grid["spacing_m"]
        return heights, *np.meshgrid(x, y)


class Meshes(Scene):
    """What Chamfer distances are measured against, and what viewers show."""

    def test_both_files_hold_the_same_surfaces(self):
        folder = self.world() / "sequences/000000"
        vertices, faces = read_ply(folder / "world.ply")
        glb = Glb(folder / "world.glb")
        instances = {i["id"]: i for i in json.loads((folder / "sequence.json").read_text())["instances"]}
        seen = []
        for node, corners in glb.objects():
            told = node["extras"]
            instance = instances[told["instance"]]
            self.assertEqual([told["class"], told["class_id"], told["material"], node["name"]],
                             [instance["class"], instance["class_id"], instance["material"], instance["name"]])
            self.assertEqual(told["moves"], instance["name"] == "ball 2")
            own = faces[faces["instance"] == told["instance"]]
            self.assertEqual(set(own["class"]), {told["class_id"]})
            # glTF: y up. The world: (x, -z, y) of it.
            x, y, z = np.moveaxis(corners, -1, 0)
            np.testing.assert_allclose(vertices[own["corners"]], np.stack([x, -z, y], -1), atol=2e-6)
            seen.append(told["instance"])
        self.assertEqual(seen, sorted(instances))
        self.assertEqual(len(faces), sum(len(c) for _, c in glb.objects()))

    def test_equal_shapes_share_a_mesh(self):
        glb = Glb(self.world() / "sequences/000000/world.glb")
        meshes = {node["name"]: node["mesh"] for node, _ in glb.objects()}
        self.assertEqual(meshes['ball "1" ü'], meshes["ball 2"])
        self.assertEqual(len(glb.json["meshes"]), 3)

    def test_objects_are_where_they_are_at_the_first_ping(self):
        vertices, faces = read_ply(self.generate(WORLD, "--pings", "1:2") / "sequences/000000" / "world.ply")
        ball = vertices[faces["corners"][faces["instance"] == 3].ravel()]
        np.testing.assert_allclose(np.linalg.norm(ball - [3, 1, 0], axis=1), 0.5, atol=1e-6)

    def test_a_plane_reaches_as_far_as_the_sonar(self):
        vertices, faces = read_ply(self.world() / "sequences/000000/world.ply")
        corners = vertices[np.unique(faces["corners"][faces["instance"] == 1])]
        normal = np.array([math.sin(math.radians(PLANE_DEG)), 0, math.cos(math.radians(PLANE_DEG))])
        np.testing.assert_allclose((corners - [0, 0, -2]) @ normal, 0, atol=1e-6)
        for sonar in ([0, 0, 0], [0.5, 1, 0]):
            height = (np.array(sonar) - [0, 0, -2]) @ normal
            reach = math.sqrt(6**2 - height**2)
            self.assertLessEqual(corners[:, 1].min(), sonar[1] - reach + 1e-6)
            self.assertGreaterEqual(corners[:, 1].max(), sonar[1] + reach - 1e-6)

    def test_meshes_are_those_of_the_file(self):
        (self.folder / "part.obj").write_text(
            "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
        scenario = SONAR + """objects:
  - {name: part, material: m, shape: {mesh: {file: part.obj}}, pose: {position_m: [3, 0, 0]}}
output: {world: true}
"""
        vertices, faces = read_ply(self.sequence(scenario) / "world.ply")
        self.assertEqual({tuple(v) for v in vertices}, {(3, 0, 0), (4, 0, 0), (3, 2, 0), (3, 0, 3)})
        self.assertEqual(len(faces), 4)

    def test_the_bytes_do_not_depend_on_threads(self):
        many, one = self.world(), self.generate(WORLD, "--threads", "1")
        self.assertEqual(program.hashes(many), program.hashes(one))

    def test_damage_is_found(self):
        names = ("world.ply", "world.glb", "height_map.npy")
        out = shutil.copytree(self.world(), self.folder / "damaged")
        for name in names:
            path = out / "sequences/000000" / name
            path.write_bytes(path.read_bytes()[:-1])
        result = program.run("verify", out)
        self.assertEqual(result.returncode, 1)
        for name in names:
            self.assertIn(f"sequences/000000/{name}: ", result.stdout + result.stderr)


class HeightMaps(Scene):
    """Heights against closed forms, in float32: 1e-6 m are eight of its steps at 1 m."""

    OUTPUT = "output: {height_map: {spacing_m: 0.1}}\n"

    def test_a_ball_over_a_tilted_plane(self):
        heights, x, y = self.heights(self.world() / "sequences/000000")
        expected = -2 - x * math.tan(math.radians(PLANE_DEG))
        for ball in ((4, 0.5, -1), (3, -1, 0)):
            rest = 0.5**2 - (x - ball[0]) ** 2 - (y - ball[1]) ** 2
            top = ball[2] + np.sqrt(np.maximum(rest, 0))
            # The edge of a ball is vertical: what lies at it counts neither as ball nor as ground.
            expected = np.where(rest > 1e-6, top, np.where(rest < -1e-6, expected, np.nan))
        checked = np.isfinite(expected) & (np.hypot(x - 4, y - 2) > 1.6)  # away from the post
        self.assertGreater(checked.sum(), 0.7 * checked.size)
        np.testing.assert_allclose(heights[checked], expected[checked], atol=1e-6)
        # The middle of its top is at 1.5 cos 10° cos 20° - 0.5.
        self.assertGreater(np.nanmax(heights[np.hypot(x - 4, y - 2) < 1]), 0.8)

    def test_terrain(self):
        cell, (rows, columns) = 0.02, (801, 901)
        along = (np.arange(columns) - (columns - 1) / 2) * cell
        north = ((rows - 1) / 2 - np.arange(rows)) * cell

        def height(x, y):
            return 0.2 * np.sin(x) * np.cos(2 * y)

        np.save(self.folder / "bed.npy", height(*np.meshgrid(along, north)))
        scenario = SONAR + """objects:
  - name: bed
    material: m
    shape: {heightfield: {file: bed.npy, cell_m: 0.02}}
    pose: {position_m: [0, 0, -2]}
""" + self.OUTPUT.replace("0.1", "0.07") + PATH
        heights, x, y = self.heights(self.sequence(scenario))
        # Triangles differ from the function by cell^2/8 (|fxx| + 2 |fxy| + |fyy|) at most.
        np.testing.assert_allclose(heights, -2 + height(x, y), atol=cell**2 / 8 * 0.2 * (1 + 4 + 4) + 1e-6)

    def test_the_grid_is_the_box_around_the_fans(self):
        _, x, y = self.heights(self.sequence(SONAR + "objects: []\n" + self.OUTPUT + PATH))
        half, tilt, yaw = math.radians(30), math.radians(20), math.radians(40)
        places = [(0, 0), (0.5, 1)]
        fan = np.array(np.meshgrid(np.linspace(-half, half, 601), np.linspace(-math.radians(10), math.radians(10), 41)))
        head = json.loads(next(self.folder.glob("set*/sequences/000000/sequence.json")).read_text())
        fan[1] *= head["sonar"]["elevation"]["fan_rad"] / math.radians(20)
        ahead, port = np.cos(fan[1]) * np.cos(fan[0]), np.cos(fan[1]) * np.sin(fan[0])
        places += list(zip((6 * ahead).ravel(), (6 * port).ravel()))
        level = math.cos(tilt) * ahead + math.sin(tilt) * np.sin(fan[1])
        turned = (math.cos(yaw) * level - math.sin(yaw) * port, math.sin(yaw) * level + math.cos(yaw) * port)
        places += list(zip(0.5 + 6 * turned[0].ravel(), 1 + 6 * turned[1].ravel()))
        low, high = np.min(places, 0), np.max(places, 0)
        # The fan's outline is taken at 65 azimuths: 6 m (0.016/2)^2 / 2 = 0.2 mm at most.
        for points, least, most in ((x, low[0], high[0]), (y, low[1], high[1])):
            self.assertTrue(-0.1 < points.min() - least < 2e-4, (points.min(), least))
            self.assertTrue(-2e-4 < points.max() - most < 0.1, (points.max(), most))
            np.testing.assert_allclose(points / 0.1, np.round(points / 0.1), atol=1e-9)

    def test_nothing_is_nan(self):
        scenario = SONAR + """objects:
  - {name: ball, material: m, shape: {sphere: {radius_m: 0.5}}, pose: {position_m: [3, 0, 0]}}
  - {name: far, material: m, shape: {plane: {}}, pose: {position_m: [0, 0, -7]}}
""" + self.OUTPUT
        heights, x, y = self.heights(self.sequence(scenario))
        inside = np.hypot(x - 3, y) < 0.499
        self.assertTrue(np.isfinite(heights[inside]).all())
        self.assertTrue(np.isnan(heights[np.hypot(x - 3, y) > 0.501]).all())

    def test_what_is_higher_than_the_sonar_reaches_is_no_hole(self):
        scenario = SONAR + """objects:
  - {name: floor, material: m, shape: {plane: {}}, pose: {position_m: [0, 0, -2]}}
  - {name: post, material: m, shape: {box: {size_m: [0.5, 0.5, 20]}}, pose: {position_m: [3, 0, 2]}}
""" + self.OUTPUT
        heights, x, y = self.heights(self.sequence(scenario))
        post = (np.abs(x - 3) < 0.249) & (np.abs(y) < 0.249)
        self.assertGreater(post.sum(), 10)
        np.testing.assert_allclose(heights[post], 12, atol=1e-5)
        np.testing.assert_allclose(heights[(np.abs(x - 3) > 0.251) | (np.abs(y) > 0.251)], -2, atol=1e-6)

    def test_a_room_is_open_from_above(self):
        scenario = SONAR + """objects:
  - {name: room, material: m, shape: {box: {size_m: [20, 20, 4], inward_facing: true}}}
""" + self.OUTPUT
        heights, _, _ = self.heights(self.sequence(scenario))
        np.testing.assert_allclose(heights, -2, atol=1e-6)

    def test_a_map_too_fine_is_refused(self):
        (self.folder / "scene.yaml").write_text(WORLD)
        result = program.run("generate", self.folder / "scene.yaml", "-o", self.folder / "out", "--set",
                             "output.height_map.spacing_m=0.0001")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("output.height_map.spacing_m: gives", result.stderr)
        self.assertFalse((self.folder / "out").exists())


if __name__ == "__main__":
    unittest.main()
