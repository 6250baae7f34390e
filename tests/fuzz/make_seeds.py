#!/usr/bin/python3
"""make_seeds.py PROGRAM FOLDER: what the fuzzers start from, one folder for each.

Scenarios, sweeps and meshes are those of the repository; a data set is made with PROGRAM and its
importer; tables and grids are small ones of each format. Which byte stands for what is told at the
top of each fuzz_*.cpp.
"""
import hashlib
import io
import json
import pathlib
import pickle
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tests" / "recordings"))
import write_logs as logs  # noqa: E402

SCENARIO = """ensonify: 1
name: seed
sonar:
  preset: blueview_p900_90
  range_max_m: 3
  beams: {count: 8, fov_deg: 40}
  rays: {elevation: 4, min_per_cell: 4}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: ball, class: target, material: m, shape: {sphere: {radius_m: 0.4}}, pose: {position_m: [2, 0, 0]}}
trajectory: {ping_rate_hz: 5, pings: 2}
output: {amodal: true}
"""

OVERRIDES = """sonar.range_max_m=7
sonar.preset=tritech_gemini_720is
sonar.beams={count: 12, fov_deg: 30}
objects.0.name=other
objects.0.shape={box: {size_m: [1, 2, 3]}}
objects.0.pose.position_m=[{uniform: [1, 2]}, 0, 0]
objects=[]
materials.steel.reflectivity={log_uniform: [1e-4, 1e-1]}
trajectory.pings=1
environment={water: {sound_speed_m_s: 1480}}
output.shadow=false
seed=18446744073709551615
"""

TABLES = {
    0: "frequency_hz,amplitude,phase_deg\n890e3,0.2,0\n900e3,1,30\n910e3,0.1,-20\n",
    1: "grazing_deg,strength_db\n0,-60\n45,-25\n90,-10\n",
    2: "depth_m,sound_speed_m_s\n0,1500\n10,1490\n200,1510\n",
    3: "time_s,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n1,1,0,0,0.7071,0,0,0.7071\n",
    4: "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0.7071 0.7071\n",
}

OBJ_PLY = """ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
3 0 1 2
"""

STL = "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid s\n"
GLTF = '{"asset": {"version": "2.0"}, "buffers": [{"byteLength": 4, "uri": "data:;base64,AAAA"}]}'
ASC = "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9999\n1 2 3\n4 5 -9999\n"


EUROC = """#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []
1403636580838555648,4,-1.5,"0.5",1,0,0,0
1403636581838555648,5,-1.5,0.5,1,0,0,0
"""


def npy(array):
    stream = io.BytesIO()
    numpy.save(stream, array)
    return stream.getvalue()


def png(depth, channels=1):
    """A grey picture of 3 x 2."""
    row = bytes(3 * channels * depth // 8)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", 3, 2, depth, {1: 0, 2: 4, 3: 2, 4: 6}[channels], 0, 0, 0)
    data = zlib.compress((b"\0" + row) * 2)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def binary_ply():
    head = OBJ_PLY.replace("ascii", "binary_little_endian").split("end_header")[0] + "end_header\n"
    return head.encode() + struct.pack("<9fB3i", 0, 0, 0, 1, 0, 0, 0, 1, 0, 3, 0, 1, 2)


def binary_stl():
    return bytes(80) + struct.pack("<I12fH", 1, *([0] * 12), 0)


def wire_density():
    """One brick, as world/import/wire.h has it."""
    samples = 9**3
    return b"".join(
        [
            struct.pack("<QI", 0x327966696E6F736E, 2),
            struct.pack("<12d", 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0),
            struct.pack("<d", 0.1),
            struct.pack("<3i3i", 0, 0, 0, 1, 1, 1),
            struct.pack("<Qi", 1, 0),
            struct.pack(f"<Q{samples}f", samples, *([0.5] * samples)),
        ]
    )


# The section of a beam, whose corners on lines and notches are all there is to cutting ears.
FACE = [(-15, -15), (15, -15), (15, -12), (2, -12), (2, 12), (15, 12),
        (15, 15), (-15, 15), (-15, 12), (-2, 12), (-2, -12), (-15, -12)]


def quantized_glb():
    data = struct.pack("<12h", 0, 0, 0, 0, 9, 0, 0, 0, 0, 9, 0, 0)
    text = json.dumps({
        "asset": {"version": "2.0"}, "extensionsRequired": ["KHR_mesh_quantization"], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5122, "count": 3, "type": "VEC3"},
                      {"bufferView": 0, "componentType": 5121, "normalized": True, "count": 3, "type": "VEC2"}],
        "bufferViews": [{"buffer": 0, "byteLength": 24, "byteStride": 8}], "buffers": [{"byteLength": 24}]}).encode()
    text += b" " * (-len(text) % 4)
    return (b"glTF" + struct.pack("<IIII", 2, 28 + len(text) + len(data), len(text), 0x4E4F534A) + text
            + struct.pack("<II", len(data), 0x004E4942) + data)


def wire_mesh(importer, mesh, reflectivity="material"):
    words = [importer, str(4 << 30), "60", "mesh", str(mesh), "1", "face", reflectivity, "colors"]
    return subprocess.run(words, check=True, stdout=subprocess.PIPE).stdout


def data_set(program):
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "seed.yaml").write_text(SCENARIO)
        out = folder / "out"
        subprocess.run([program, "generate", folder / "seed.yaml", "-o", out, "--quiet"], check=True)
        manifest = (out / "dataset.json").read_text()
        sequence = out / "sequences" / "000000"
        parts = [(sequence / name).read_bytes()
                 for name in ("sequence.json", "annotations.jsonl", "poses.csv", "objects.csv")]
        digest = hashlib.sha256(parts[0]).hexdigest()
        assert digest in manifest
        return b"\0".join([manifest.replace(digest, "*" * 64).encode(), *parts])


def recordings():
    """Small logs of each kind."""
    counts = numpy.arange(2 * 48, dtype=numpy.uint8).reshape(2, 48)
    yield "aris", logs.aris([logs.aris_frame(counts, PingMode=1, TheSystemType=2, Heading=30)] * 2)
    for kind, version, gains in ((numpy.uint8, 1, None), (numpy.uint16, 2, [1, 9]), (numpy.uint32, 2, None)):
        message = logs.oculus_message(counts[:, :4].astype(kind), [-300, -50, 70, 300], gains, version)
        yield f"stream{version}_{kind.__name__}", message * 2
        yield f"items{version}_{kind.__name__}", logs.oculus([logs.oculus_item(message, 1.5)] * 2)
        if kind is not numpy.uint32:
            image = logs.projected_image(counts[:, :4].astype(kind), [-0.3, 0, 0.1, 0.3], [1, 2], 1000, version == 2)
            yield f"mcap_{kind.__name__}", logs.mcap([image] * 2, chunked=version == 1)
            info = logs.sonar_info(2, version, 0.25, -10)
            yield f"mcap_info{version}_{kind.__name__}", logs.mcap([image], chunked=False, infos=[info])
            yield f"mcap_zstd_{kind.__name__}", logs.mcap([image], compression="zstd")
            raw = logs.raw_image(counts[:, :4].astype(kind), [-0.3, 0, 0.1, 0.3], 3e4, 5, 1000, version == 2)
            yield f"mcap_raw_{kind.__name__}", logs.mcap([raw] * 2, chunked=version == 1, kind="RawSonarImage")
        yield f"zlib{version}_{kind.__name__}", logs.oculus([logs.oculus_item(message, 1.5, compressed=True)])


def pickles():
    """One frame of a set of neusis by every protocol, and its description."""
    state = {"ImagingSonar": numpy.arange(12, dtype=numpy.float32).reshape(3, 4) / 12, "PoseSensor": numpy.eye(4), "t": 0.5}
    for protocol in (2, 3, 4, 5):
        yield f"pickle{protocol}", pickle.dumps(state, protocol)
    yield "pickle_fortran", pickle.dumps({"ImagingSonar": numpy.asfortranarray(state["ImagingSonar"])}, 4)
    yield "neusis_config", (b'{"agents": [{"sensors": [{"sensor_type": "ImagingSonar", "Hz": 4, "configuration": '
                            b'{"Azimuth": 60, "RangeMin": 0, "RangeMax": 3, "RangeBins": 3, "AzimuthBins": 4}}]}]}')


def jpegs(program):
    """Images of a render."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "seed.yaml").write_text(SCENARIO)
        subprocess.run([program, "generate", folder / "seed.yaml", "-o", folder / "out", "--quiet", "--pings", "0:1"], check=True)
        words = ["--every-sample", "40", "--view", "polar", "--quiet"]
        for quality in (10, 95):
            name = ["--name", str(quality), "--jpeg-quality", str(quality)]
            subprocess.run([program, "render", folder / "out", *name, *words], check=True)
            yield f"jpeg{quality}", (folder / f"out/renders/{quality}/sequences/000000/000000_polar.jpg").read_bytes()


def seeds(program):
    """(fuzzer, name, bytes)"""
    importer = pathlib.Path(program).with_name("ensonify_import")
    for file in sorted([*ROOT.glob("scenes/*.yaml"), *ROOT.glob("configs/sonars/*.yaml")]):
        yield "scenario", file.name, file.read_bytes()
    yield "scenario", "seed", SCENARIO.encode()
    for number, line in enumerate(OVERRIDES.splitlines()):
        yield "override", str(number), line.encode()
    for file in sorted(ROOT.glob("configs/sweeps/*.yaml")):
        text = file.read_text()
        at = text.index("base:")
        yield "sweep", file.name, (text[:at] + "base: base.yaml" + text[text.index("\n", at):]).encode()
    texts = [(0, OBJ_PLY.encode()), (0, binary_ply()), (1, STL.encode()), (1, binary_stl()), (2, GLTF.encode())]
    for number, (kind, data) in enumerate(texts):
        yield "mesh", f"file{number}", bytes([kind]) + data
    yield "mesh", "quantized", b"\5" + quantized_glb()
    yield "mesh", "face", b"\6" + bytes(x % 256 for x, y in FACE for x in (x, y, 0))
    with tempfile.TemporaryDirectory() as folder:
        mesh = pathlib.Path(folder) / "m.stl"
        mesh.write_text(STL)
        yield "mesh", "wire_mesh", b"\4" + wire_mesh(importer, mesh)
        mesh = pathlib.Path(folder) / "m.obj"
        mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n")
        yield "mesh", "wire_uv", b"\4" + wire_mesh(importer, mesh, "texture")
    yield "mesh", "wire_density", b"\3" + wire_density()
    for kind in ("f4", "f8", "u2"):
        yield "grid", f"npy_{kind}", b"\0" + npy(numpy.arange(6, dtype=kind).reshape(2, 3))
    for depth in (8, 16):
        yield "grid", f"png_{depth}", b"\1" + png(depth)
        for channels in range(1, 5):
            yield "grid", f"image_{depth}_{channels}", b"\3" + png(depth, channels)
    yield "grid", "asc", b"\2" + ASC.encode()
    for kind, text in TABLES.items():
        yield "table", str(kind), bytes([kind]) + text.encode()
    yield "table", "euroc", b"\3" + EUROC.encode()
    yield "table", "repeated", b"\4" + b"1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n"
    for number, kind in enumerate(("f4", "c8", "u2", "u1")):
        yield "npy", kind, bytes([number, 4]) + npy(numpy.zeros((3, 2), dtype=kind))
        yield "npy", f"{kind}_long", bytes([number, 1]) + npy(numpy.zeros(5, dtype=kind))
    yield "dataset", "seed", data_set(program)
    for name, data in recordings():
        yield "recording", name, data
    for name, data in (*pickles(), *jpegs(program)):
        yield "recording", name, data


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    for fuzzer, name, data in seeds(program):
        (folder / fuzzer).mkdir(parents=True, exist_ok=True)
        (folder / fuzzer / name).write_bytes(data)


if __name__ == "__main__":
    main()
