"""Input from strangers that is made to hurt: refused with 2 in a few seconds of the processor, with the file's name,
in little memory, and nothing is written.
"""
import hashlib
import json
import os
import shutil
import struct
import subprocess
import tempfile
import zlib

from abused import PROGRAM, Case, run

SCENE = """ensonify: 1
sonar: {{preset: blueview_p900_90, range_max_m: 4, beams: {{count: 16, fov_deg: 40}}, rays: {{elevation: 4}}}}
materials: {{m: {{reflectivity: 1e-3}}}}
objects:
  - {{name: thing, material: m, shape: {shape}, pose: {{position_m: [3, 0, 0]}}}}
trajectory: {{ping_rate_hz: 5, pings: 1}}
"""
LIMIT_KB = 1_000_000
LIMIT_S = 10
# Sanitized programs are slower and larger than what is promised of them.
SANITIZED = bool(os.environ.get("SANITIZED"))


def ply(faces, data=b"", kind="binary_little_endian", vertices=3):
    return (f"ply\nformat {kind} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n"
            f"property float z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
            ).encode() + data


def npy(shape, data=b""):
    head = f"{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}"
    head += " " * (117 - len(head)) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head.encode() + data


def png(width, height, rows=b""):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


TRIANGLE = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
GLTF_BILLIONS = json.dumps({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "buffers": [{"byteLength": 4_000_000_000, "uri": "data:application/octet-stream;base64,AAAA"}],
    "bufferViews": [{"buffer": 0, "byteLength": 4_000_000_000}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 300_000_000, "type": "VEC3"},
                  {"bufferView": 0, "componentType": 5125, "count": 1_000_000_000, "type": "SCALAR"}],
}).encode()
MESHES = {
    "billions.ply": ply(4_000_000_000, TRIANGLE),
    "wrap.ply": ply(2**64 // 13 + 1, TRIANGLE),
    "vertices.ply": ply(1, TRIANGLE, vertices=3_000_000_000),
    "text.ply": ply(4_000_000_000, b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", kind="ascii"),
    "list.ply": ply(1, TRIANGLE + b"\xff" + struct.pack("<3i", 0, 1, 2)),
    "index.ply": ply(1, TRIANGLE + b"\x03" + struct.pack("<3i", 0, 1, 2_000_000_000)),
    "negative.ply": ply(1, TRIANGLE + b"\x03" + struct.pack("<3i", 0, 1, -7)),
    "billions.stl": bytes(80) + struct.pack("<I", 4_294_967_295) + bytes(50),
    "solid.stl": b"solid " + b"facet normal 0 0 1\nouter loop\n" * 20_000,
    "index.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4000000000\n",
    "numbers.obj": b"v 1e999 nan inf\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "billions.gltf": GLTF_BILLIONS,
    "deep.gltf": b'{"asset":' + b"[" * 200_000 + b"]" * 200_000 + b"}",
    "cycle.gltf": b'{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"children":[1]},{"children":[0]}]}',
    "short.glb": b"glTF" + struct.pack("<II", 2, 4_294_967_295) + struct.pack("<II", 4_294_967_280, 0x4E4F534A),
}
GRIDS = {
    "huge.npy": npy("(40000, 40000)"),
    "wrap.npy": npy("(4294967296, 4294967296)"),
    "many.npy": npy("(" + "2, " * 30 + ")"),
    "huge.png": png(2_000_000, 2_000_000),
    "bomb.png": png(8000, 8000, bytes(8000 * 2 * 8000 + 8000)[: 100_000_000]),
    "huge.asc": b"ncols 100000\nnrows 100000\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n",
    "minus.asc": b"ncols -3\nnrows -2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n",
}
VDB = bytes.fromhex("20424456") + b"\0" * 4 + struct.pack("<III", 224, 9, 0) + b"\1" + b"0" * 36


class Hostile(Case):
    def refuse(self, *expected, words=None):
        """The command ends with 2, names what is expected, and takes as little time of the processor and memory as is
        promised. What it starts counts; what else the machine does, does not."""
        output = self.folder / "out"
        words = words or ["generate", self.scenario, "-o", output]
        with tempfile.TemporaryFile("w+") as heard:
            process = subprocess.Popen([PROGRAM, *map(str, words)], stdout=subprocess.DEVNULL, stderr=heard)
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
            heard.seek(0)
            told = heard.read()
        self.assertEqual(process.returncode, 2, told[-2000:])
        for text in expected:
            self.assertIn(text, told)
        if not SANITIZED:
            self.assertLess(usage.ru_utime + usage.ru_stime, LIMIT_S)
            self.assertLess(usage.ru_maxrss, LIMIT_KB)
        self.assertFalse(output.exists())

    def test_meshes_that_claim_too_much(self):
        for name, data in MESHES.items():
            with self.subTest(name=name):
                (self.folder / name).write_bytes(data)
                self.scenario.write_text(SCENE.format(shape=f"{{mesh: {{file: {name}}}}}"))
                self.refuse(name)

    def test_grids_that_claim_too_much(self):
        for name, data in GRIDS.items():
            with self.subTest(name=name):
                (self.folder / name).write_bytes(data)
                cell = "" if name.endswith(".asc") else ", cell_m: 0.1"
                grid = f"{{heightfield: {{file: {name}{cell}}}}}"
                self.scenario.write_text(SCENE.format(shape=grid))
                self.refuse(name)

    def test_openvdb_files(self):
        for name, data in {"head.vdb": VDB, "tail.vdb": VDB + b"\xff" * 5000, "empty.vdb": b"",
                           "counts.vdb": VDB + struct.pack("<I", 2**32 - 1) * 50}.items():
            with self.subTest(name=name):
                (self.folder / name).write_bytes(data)
                self.scenario.write_text(SCENE.format(shape=f"{{level_set: {{file: {name}}}}}"))
                self.refuse(name)

    def test_texts_made_to_hurt(self):
        bombs = {
            "aliases": "a: &a [x]\n" + "".join(f"b{i}: &b{i} [{', '.join([f'*b{i - 1}' if i else '*a'] * 20)}]\n" for i in range(12)),
            "deep": "a: " + "[" * 100_000,
            "deep_maps": "".join(" " * i + "a:\n" for i in range(3000)),
            "long_key": "? " + "k" * 1_000_000 + "\n: 1\n",
            "many": "objects:\n" + "  - {}\n" * 500_000,
            "large": "#" + " " * 17_000_000,
            "nulls": "ensonify: 1\n\0\0\0",
            "merges": "a: &a {x: 1}\n" + "".join(f"b{i}: &b{i} {{<<: [{', '.join([f'*b{i - 1}' if i else '*a'] * 20)}]}}\n" for i in range(12)),
        }
        for name, text in bombs.items():
            # One reader of YAML serves both.
            commands = [("generate", "yaml")] + [("sweep", "sweep.yaml")] * (name in ("aliases", "deep", "large"))
            for command, ending in commands:
                with self.subTest(name=name, command=command):
                    file = self.folder / f"{name}.{ending}"
                    file.write_text(text)
                    self.refuse(file.name, words=[command, file, "-o", self.folder / "out"])

    def test_sizes_that_no_machine_has(self):
        base = SCENE.format(shape="{sphere: {radius_m: 0.3}}")
        self.scenario.write_text(base)
        for key, value in {"sonar.beams.count": "100000000", "sonar.rays.elevation": "100000000", "trajectory.pings": "1e18",
                           "sonar.range_max_m": "1e9", "output.cartesian": "{height_px: 1000000000}", "sequences": "10000000000",
                           "output.sdf": "{voxel_m: 1e-9}"}.items():
            with self.subTest(key=key):
                self.refuse(key.split(".")[0], words=["generate", self.scenario, "-o", self.folder / "out", "--set", f"{key}={value}"])


class DataSets(Case):
    """A data set from a stranger, whose manifest lists what is not in its folder."""

    def seal(self, folder, manifest):
        text = json.dumps(manifest)
        (folder / "dataset.json").write_text(text)
        (folder / "dataset.sha256").write_text(hashlib.sha256(text.encode()).hexdigest() + "  dataset.json\n")

    def readers(self, folder):
        yield ["verify", folder], (1,)
        yield ["report", folder, "-o", self.folder / "page.html"], (1, 2, 4)
        yield ["figure", folder, "-o", self.folder / "figure.png"], (1, 2, 4)
        for form in ("yolo", "hdf5", "webdataset"):
            yield ["export", folder, "--format", form, "-o", self.folder / f"as.{form}"], (1, 2, 4)

    def test_listed_paths_that_leave_the_folder(self):
        good = self.folder / "good"
        self.generate(good, "--pings", "0:2", "--set", "sequences=1")
        secret = self.folder / "secret"
        secret.write_text("of mine")
        for path in ("../secret", str(secret), "sequences/../../secret", "./README.md", "", "sequences//000000/poses.csv"):
            with self.subTest(path=path):
                bad = self.folder / "bad"
                shutil.rmtree(bad, ignore_errors=True)
                shutil.copytree(good, bad)
                manifest = json.loads((bad / "dataset.json").read_text())
                manifest["files"][0]["path"] = path
                self.seal(bad, manifest)
                # One rule for paths reads the manifest for all commands; the first path goes through each of them.
                for words, statuses in list(self.readers(bad))[: 7 if path == "../secret" else 1]:
                    done = run(*words)
                    self.assertIn(done.returncode, statuses, f"{words}: {done.stderr}")
                    self.assertNotIn("of mine", done.stdout + done.stderr)
                    self.assertFalse((self.folder / "page.html").exists())
                self.generate(bad, "--overwrite", "--pings", "0:1", expect=2)
                self.assertEqual(secret.read_text(), "of mine")

    def test_names_in_a_page(self):
        evil = '</script><script>alert(1)</script><img src=x onerror=alert(2)>"\'&'
        self.scenario.write_text(self.scenario.read_text().replace("name: ball", f"name: {json.dumps(evil)}").replace("class: target", f"class: {json.dumps(evil)}"))
        folder = self.folder / "evil"
        self.generate(folder, "--pings", "0:2")
        page = self.folder / "page.html"
        self.assertEqual(run("report", folder, "-o", page).returncode, 0)
        text = page.read_text()
        for dangerous in ("<script>alert", "<img src=x", "onerror=alert(2)>\""):
            self.assertNotIn(dangerous, text)
        svg = self.folder / "f.svg"
        self.assertEqual(run("figure", folder, "-o", svg, "--quantity", "instance").returncode, 0)
        self.assertNotIn("<script", svg.read_text())
        self.assertNotIn("<img", svg.read_text())


if __name__ == "__main__":
    import unittest

    unittest.main()
