"""A camera and navigation as instruments of a rig: the same images and tables as beside a sonar alone, on clocks of
their own, and what the commands and the reader make of them.

ENSONIFY is the program.
"""
import json
import re
import sys

import numpy as np
from program import ROOT, hashes, run, scratch
from rig_test import PAIR, SONAR, RigCase, times

from ensonify_dataset import DatasetError, SonarDataset

sys.path.append(str(ROOT / "tests/export"))
from mcap_messages import matrix  # noqa: E402
from mcap_records import Reader, pose_values  # noqa: E402

MOUNT = "mount: {position_m: [0.1, 0.2, -0.1], rotation_deg: [4, 6, 3]}"
CAMERA = f"{{{MOUNT}, width_px: 40, height_px: 30, fov_deg: 70}}"
SENSORS = "{imu: {rate_hz: 100, gyroscope: {angle_random_walk_deg_sqrth: 0.3}}, dvl: {rate_hz: 8, range_max_m: 20}}"
EYE = f"  - {{name: eye, camera: {CAMERA}, ping_rate_hz: 10}}\n"
TRIO = (PAIR[:PAIR.index("  - {name: left")] + f"""  - {{name: ear, sonar: {SONAR}, mount: {{position_m: [0, 0.4, 0]}}}}, time_offset_s: 0.05}}
{EYE}  - {{name: nav, navigation: {SENSORS}}}
""" + PAIR[PAIR.index("scattering:"):].replace(
    "pings: 4", "pings: 4, poses: [{time_s: 0}, {time_s: 2, position_m: [0.4, 0, 0.1], rotation_deg: [0, 0, 9]}]")
    .replace("png: false", "png: false, camera: {flow: true}"))


MADE = []  # the folder of the rig, once the first test has made it


def alone(more, rate_hz=5, pings=4):
    """The scenario without a rig."""
    head, rest = TRIO[:TRIO.index("rig:")], TRIO[TRIO.index("scattering:"):]
    text = head + f"sonar: {SONAR}, {MOUNT}}}\n" + rest.replace("ping_rate_hz: 5, pings: 4", f"ping_rate_hz: {rate_hz}, pings: {pings}")
    return (text if "camera" in more else text.replace(", camera: {flow: true}", "")) + more + "\n"


def files(folder, part):
    return {name: value for name, value in hashes(folder).items() if f"/{part}/" in name}


def messages_of(case, folder):
    return Reader(case).read((folder / "000000.mcap").read_bytes())


class Instruments(RigCase):
    def setUp(self):
        super().setUp()
        if not MADE:
            MADE.append(self.make(TRIO, name=scratch() / "trio"))
        self.out = MADE[0]
        self.scenario.write_text(TRIO)

    def test_images_and_tables_are_those_beside_a_sonar(self):
        camera = self.make(alone(f"camera: {CAMERA}", 10, 8), name="camera")
        seen = files(self.out / "eye", "camera")
        self.assertEqual(len(seen), 2 * 8 * 5)
        self.assertEqual(seen, files(camera, "camera"))
        sensors = self.make(alone(f"navigation: {SENSORS}"), name="sensors")
        for table in ("imu", "dvl", "imu_truth"):
            ours, theirs = ((folder / f"sequences/000001/navigation/{table}.csv").read_text().splitlines()
                            for folder in (self.out / "nav", sensors))
            self.assertEqual(ours[:len(theirs)], theirs)
            # The sensors work to the end of the run, not to the last ping.
            self.assertLess(0.8 - 1 / 8, float(ours[-1].split(",")[0]))
            self.assertLess(float(ours[-1].split(",")[0]), 0.8)

    def test_data_sets_have_what_their_instruments_have(self):
        rig = json.loads((self.out / "rig.json").read_text())["instruments"]
        self.assertEqual([(entry["name"], entry["kind"]) for entry in rig],
                         [("ear", "sonar"), ("eye", "camera"), ("nav", "navigation")])
        data = {name: SonarDataset(self.out / name) for name in ("ear", "eye", "nav")}
        np.testing.assert_allclose(times(self.out / "eye"), 2 * [k / 10 for k in range(8)], atol=1e-12)
        for name, parts in (("ear", ["first_return_m.npy", "polar", "timeseries"]), ("eye", ["camera"]), ("nav", ["navigation"])):
            found = {path.name for path in (self.out / name / "sequences/000000").iterdir()}
            common = {"sequence.json", "poses.csv", "poses.tum", "objects.csv", "boxes.csv", "annotations.jsonl"}
            axes = {"azimuth_rad.npy", "range_m.npy"} if name == "ear" else set()
            self.assertEqual(found, common | axes | set(parts))
            info = data[name].sequence(0).info
            self.assertEqual([(one["id"], one["name"]) for one in info["instances"]],
                             [(one["id"], one["name"]) for one in data["ear"].sequence(0).info["instances"]])
            self.assertEqual(data[name].classes, data["ear"].classes)
            self.assertEqual((info.get("instrument", "sonar"), "sonar" in info), ({"ear": "sonar", "eye": "camera",
                                                                                  "nav": "navigation"}[name], name == "ear"))
            again = self.make((self.out / name / "scenario.yaml").read_text(), name=f"{name} again")
            self.assertEqual(files(again, parts[-1]), files(self.out / name, parts[-1]))

    def test_pixels_find_each_other_through_the_world(self):
        image, ping = SonarDataset(self.out / "eye")[0, 0].camera, SonarDataset(self.out / "ear")[0, 0]
        with self.assertRaisesRegex(DatasetError, "a camera of a rig"):
            image.to_sonar()
        points = image.position_m @ image.pose.rotation.T + image.pose.position_m
        place = image.to_sonar(ping)
        np.testing.assert_allclose(place.range_m, np.linalg.norm(points - ping.pose.position_m, axis=-1), rtol=1e-6)
        rows, columns = np.nonzero(image.instance == 2)
        self.assertGreater(len(rows), 20)
        pixels, seen = image.from_sonar(*(part[rows, columns] for part in place[1:]), ping)
        np.testing.assert_allclose(pixels, np.stack([columns, rows], axis=-1), atol=1e-3)
        self.assertTrue(seen.all())

    def test_ranges_of_pings_part_the_rows(self):
        part = self.make(TRIO, "--pings", "1:3", "--sequences", "0:1", name="part")
        np.testing.assert_allclose(times(part / "eye"), [0.2, 0.3, 0.4, 0.5])
        whole, some = ((folder / "nav/sequences/000000/navigation/imu.csv").read_text().splitlines()[1:]
                       for folder in (self.out, part))
        self.assertEqual(some, [row for row in whole if 0.2 <= float(row.split(",")[0]) + 1e-9 < 0.6])

    def test_exports(self):
        def export(name, form):
            done = run("export", self.out / name, "-o", self.folder / f"{name} {form}", "--format", form)
            return done, self.folder / f"{name} {form}"

        for name, form in (("eye", "nerfstudio"), ("eye", "colmap"), ("eye", "kitti"), ("eye", "tum"), ("nav", "tum")):
            self.assertEqual(export(name, form)[0].returncode, 0, (name, form))
        for name, form in (("eye", "coco"), ("nav", "nerfstudio"), ("eye", "mcap"), ("nav", "hdf5")):
            self.assertRegex(export(name, form)[0].stderr, f"lacks what --format {form} needs")
        tables = {key: [round(float(line.split(",")[0]) * 1e9) for line in
                        (self.out / f"nav/sequences/000000/navigation/{key}.csv").read_text().splitlines()[1:]]
                  for key in ("imu", "dvl")}
        for name in ("ear", "nav"):
            done, out = export(name, "mcap")
            self.assertEqual(done.returncode, 0, done.stderr)
            messages = messages_of(self, out)
            heard = {key: [time for topic, _, _, time, _ in messages if topic == key] for key in {m[0] for m in messages}}
            self.assertEqual(heard["/imu/data_raw"], tables["imu"])
            self.assertEqual(heard["/dvl/data"], tables["dvl"])
            self.assertEqual(heard["/tf"], [round(t * 1e9) for t in times(self.out / name)[:4]])
            self.assertEqual(heard.get("/sonar/levels", []), heard["/tf"] if name == "ear" else [])
        tf = {topic: [m["transforms"] for found, *_, m in messages_of(self, self.folder / "ear mcap") if found == topic]
              for topic in ("/tf", "/tf_static")}
        sonar = next(t for t in tf["/tf_static"][0] if t["child_frame_id"] == "sonar")
        for transforms, ping in zip(tf["/tf"], SonarDataset(self.out / "ear").sequence(0), strict=True):
            body, inner = (pose_values(t["transform"], "translation", "rotation") for t in (transforms[0], sonar))
            np.testing.assert_allclose(body[:3] + matrix(body[3:]) @ inner[:3], ping.pose.position_m, atol=1e-12)

    def test_a_sweep_over_instruments(self):
        sweep = self.folder / "sweep.yaml"
        sweep.write_text("ensonify_sweep: 1\nbase: small.yaml\n"
                         "axes:\n  - {key: instrument, values: [ear, eye, nav]}\n")
        done = run("sweep", sweep, "-o", self.folder / "runs", "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(run("verify", self.folder / "runs").returncode, 0)
        parts = ("timeseries", "camera", "navigation")
        found = [[files(folder, part) for part in parts] for folder in (self.folder / "runs/runs").iterdir()]
        self.assertEqual(len(found), 3)
        for name in ("ear", "eye", "nav"):
            self.assertIn([files(self.out / name, part) for part in parts], found)

    def test_bad_instruments_are_refused_before_anything_is_written(self):
        hull = ("objects:\n", "objects:\n  - {name: hull, class: hull, material: m, shape: {sphere: {radius_m: 0.15}}, "
                "pose: {position_m: [0.1, 0.2, -0.1]}}\n")
        resting = TRIO[:TRIO.index(", poses: [")] + "}\n" + TRIO[TRIO.index("noise:"):]
        for text, old, new, error in (
                (TRIO, "scattering:", f"camera: {CAMERA}\nscattering:", "camera: cannot be combined with rig"),
                (TRIO, "scattering:", f"navigation: {SENSORS}\nscattering:", "navigation: cannot be combined with rig"),
                (TRIO, "name: nav, ", f"name: nav, camera: {CAMERA}, ", "rig.2: .*sonar, camera and navigation"),
                (TRIO, f"navigation: {SENSORS}", "ping_rate_hz: 3", "rig.2: .*sonar, camera and navigation"),
                (TRIO, "fov_deg: 70}", "fov_deg: 70, surface_z_m: -0.5}", "rig.1.camera.mount.position_m: .*not below"),
                (TRIO, "width_px: 40", "width_px: -1", "rig.1.camera.width_px"),
                (TRIO, "rate_hz: 100", "rate_hz: 0", "rig.2.navigation.imu.rate_hz"),
                (TRIO, "ping_rate_hz: 10}", "time_offset_s: 0.9}", "rig.1.time_offset_s: eye has no ping"),
                (resting, *hull, "rig.1.camera.mount: the camera is .*inside hull")):
            self.assertIn(old, text)
            self.scenario.write_text(text.replace(old, new))
            out = self.folder / "refused"
            done = run("generate", self.scenario, "-o", out)
            self.assertEqual(done.returncode, 2, (error, done.stderr))
            self.assertRegex(done.stderr, "(?m)^" + re.escape(str(self.scenario)) + r":\d+:\d+: " + error)
            self.assertFalse(out.exists(), error)


if __name__ == "__main__":
    import unittest

    unittest.main()
