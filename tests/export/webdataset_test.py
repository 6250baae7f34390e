"""webdataset: shards by Python's tarfile, members against the files of the data set."""
import io
import json
import tarfile
import unittest

import numpy as np

import exported


def members(out):
    """{key: {extension: bytes}} and the shard of each key, shards in order."""
    items, shard_of = {}, {}
    for path in sorted(out.iterdir()):
        with tarfile.open(path, "r:") as tar:
            for info in tar:
                assert info.isfile() and (info.mtime, info.uid, info.gid) == (0, 0, 0), info
                assert (info.uname, info.gname) == ("", ""), info
                key, extension = info.name.split(".", 1)
                items.setdefault(key, {})[extension] = tar.extractfile(info).read()
                shard_of.setdefault(key, set()).add(path.name)
    return items, shard_of


class WebDataset(exported.Case):
    format_name = "webdataset"

    def check(self, view, *options):
        items, shard_of = members(exported.export("webdataset", *options, *exported.ALL_CLASSES))
        wanted = set()
        for sequence in exported.sequences():
            names = {i["id"]: i for i in sequence.head["instances"]}
            for ping in sequence.pings:
                key = f"{sequence.number:06}_{ping:06}"
                wanted.add(key)
                item = items[key]
                self.assertEqual(list(item), ["png", "instance.png", "semantic.png", "shadow.png", "npy", "json"])
                folder = sequence.folder
                self.assertEqual(item["png"], (folder / f"png/{ping:06}_{view}.png").read_bytes())
                self.assertEqual(item["instance.png"], (folder / f"{view}/{ping:06}_instance.png").read_bytes())
                self.assertEqual(item["shadow.png"], (folder / f"{view}/{ping:06}_shadow.png").read_bytes())
                self.assertEqual(item["semantic.png"], (folder / f"{view}/{ping:06}_semantic.png").read_bytes())
                np.testing.assert_array_equal(np.load(io.BytesIO(item["npy"])),
                                              sequence.npy(f"timeseries/{ping:06}.npy"))
                self.check_json(json.loads(item["json"]), sequence, ping, view, names)
                self.assertEqual({name.split("-")[0] for name in shard_of[key]}, {sequence.split})
        self.assertEqual(set(items), wanted)

    def check_json(self, found, sequence, ping, view, names):
        self.assertEqual([found[key] for key in ("sequence", "ping", "split", "view")],
                         [sequence.number, ping, sequence.split, view])
        self.assertEqual(found["time_s"], float(sequence.poses[ping]["time_s"]))
        pose = found["sonar_in_world"]
        self.assertEqual(pose["position_m"] + pose["quaternion_wxyz"], sequence.pose(ping))
        instance = sequence.png(view, ping, "_instance")
        self.assertEqual([found["height"], found["width"]], list(instance.shape))
        self.assertEqual([o["instance"] for o in found["objects"]], [i for i in np.unique(instance) if i])
        for o in found["objects"]:
            rows, columns = np.nonzero(instance == o["instance"])
            self.assertEqual(o["bbox"], [columns.min(), rows.min(), np.ptp(columns) + 1, np.ptp(rows) + 1])
            self.assertEqual(o["area"], len(rows))
            known = names[o["instance"]]
            self.assertEqual([o["name"], o["class"], o["class_id"]],
                             [known["name"], known["class"], known["class_id"]])

    def test_cartesian(self):
        self.check("cartesian")

    def test_polar(self):
        self.check("polar", "--view", "polar")

    def test_shards_are_no_larger_than_asked_for(self):
        big = ("--set", "sonar.beams.count=768", "--set", "sonar.rays.elevation=1")
        source = exported.dataset(*big)
        out = exported.export("webdataset", "--shard-size-mb", "2", source=source)
        names = sorted(path.name for path in out.iterdir())
        self.assertIn("val-000001.tar", names)
        for path in out.iterdir():
            # A tar file ends with zeros up to a multiple of 10 kB.
            self.assertLessEqual(path.stat().st_size, 2_000_000 + 20_480)
        items, shard_of = members(out)
        self.assertEqual(len(items), 6)
        self.assertTrue(all(len(shards) == 1 for shards in shard_of.values()), "a ping was cut")


if __name__ == "__main__":
    unittest.main()
