"""`ensonify export` from outside: what is refused, with which status, and that nothing is left behind."""
import hashlib
import re
import resource
import shutil
import signal
import subprocess
import unittest

import exported
from exported import run, scratch


def formats():
    return re.search(r"--format TEXT:\{([^}]*)\}", run("export", "--help").stdout)[1].split(",")


class Case(unittest.TestCase):
    def refuse(self, status, source, *options, out=None, expected=()):
        folder = scratch()
        out = out or folder / "out"
        before = sorted(out.parent.iterdir())
        result = run("export", source, "-o", out, *options)
        self.assertEqual(result.returncode, status, result.stderr)
        for part in expected:
            self.assertIn(part, result.stderr)
        self.assertEqual(sorted(out.parent.iterdir()), before, "something was left behind")

    def copy(self, name="set"):
        folder = scratch() / name
        shutil.copytree(exported.dataset(), folder)
        return folder


class Refusals(Case):
    def test_an_unknown_format_comes_with_the_nearest(self):
        self.refuse(2, exported.dataset(), "--format", "tumm", expected=["did you mean tum?", "index_mask"])

    def test_help_lists_every_format(self):
        text = run("export", "--help").stdout
        for name in formats():
            self.assertRegex(text, rf"\n  {name} +\w")

    def test_foreign_and_unfinished_folders(self):
        folder = scratch()
        self.refuse(2, folder, "--format", "tum", expected=["not a data set of ensonify"])
        self.refuse(2, folder / "gone", "--format", "tum", expected=["no such folder"])
        unfinished = self.copy()
        (unfinished / "dataset.sha256").unlink()
        self.refuse(2, unfinished, "--format", "tum", expected=["not finished", "generate"])

    def test_packed_sequences(self):
        packed = exported.dataset("--set", "output.one_file_per=sequence", "--set", "trajectory.pings=1")
        self.refuse(2, packed, "--format", "index_mask", expected=["output.one_file_per: ping"])

    def test_an_option_of_another_format(self):
        self.refuse(2, exported.dataset(), "--format", "tum", "--view", "polar", expected=["--view", "tum"])
        self.refuse(2, exported.dataset(), "--format", "tum", "--classes", "pole", expected=["--classes", "tum"])
        self.refuse(2, exported.dataset(), "--format", "index_mask", "--min-pixels", "3", expected=["--min-pixels"])
        self.refuse(2, exported.dataset(), "--format", "yolo", "--margin-px", "3", expected=["--margin-px"])
        self.refuse(2, exported.dataset(), "--format", "hdf5", "--pad", expected=["--stack"])
        self.refuse(2, exported.dataset(), "--format", "hdf5", "--one-file", expected=["--one-file", "--stack"])
        self.refuse(2, exported.dataset(), "--format", "yolo", "--view", "sideways")

    def test_a_choice_of_objects_that_the_data_set_does_not_have(self):
        for option in ("--classes", "--exclude"):
            self.refuse(2, exported.dataset(), "--format", "coco", option, "pole,bal",
                        expected=[option, '"bal"', "room, ball & net, pole"])
        self.refuse(2, exported.dataset(), "--format", "coco", "--split", "test", expected=["--split test"])
        self.refuse(2, exported.dataset(), "--format", "coco", "--min-visible", "1.5", expected=["--min-visible"])
        bare = exported.dataset("--set", "output.amodal=false", "--set", "trajectory.pings=1")
        self.refuse(2, bare, "--format", "coco", "--min-visible", "0.5", expected=["output.amodal: true"])

    def test_an_output_that_holds_something(self):
        folder = scratch() / "mine"
        folder.mkdir()
        (folder / "mine.txt").write_text("mine")
        self.refuse(2, exported.dataset(), "--format", "tum", out=folder, expected=["not empty"])
        self.assertEqual((folder / "mine.txt").read_text(), "mine")
        self.refuse(2, exported.dataset(), "--format", "hdf5", out=folder / "mine.txt",
                    expected=["already exists"])

    def test_an_output_in_the_data_set(self):
        source = self.copy()
        self.refuse(2, source, "--format", "tum", out=source / "tum", expected=["lies in the data set"])

    def test_an_empty_folder_is_taken(self):
        folder = scratch() / "empty"
        folder.mkdir()
        self.assertEqual(run("export", exported.dataset(), "--format", "tum", "-o", folder).returncode, 0)
        self.assertTrue((folder / "000000/sonar.txt").is_file())

    def test_a_folder_that_cannot_be_written(self):
        file = scratch() / "file"
        file.write_text("")
        result = run("export", exported.dataset(), "--format", "tum", "-o", file / "out")
        self.assertEqual(result.returncode, 4, result.stderr)

    def test_what_the_data_set_has_not(self):
        self.refuse(2, exported.dataset(), "--format", "ply", expected=["--export-scatterers"])
        bare = exported.dataset("--set", "output={timeseries: npy, polar: false, cartesian: false, png: false}")
        for name, advice in (("yolo", "output.png"), ("index_mask", "output.png"), ("mcap", "output.png"),
                             ("mot", "output.png"), ("sdpr", "output.png"), ("neusis", "output.polar"),
                             ("sonic", "output.polar")):
            self.refuse(2, bare, "--format", name, expected=[advice])


class Trouble(Case):
    """What goes wrong on the way ends with the contract's status and leaves nothing behind."""

    def test_a_full_disk(self):
        """Files are held to so many bytes; a write beyond fails as on a full disk."""
        def hold():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (200, 200))

        source = exported.dataset("--export-scatterers", "--set", "camera={fov_deg: 60, width_px: 16, height_px: 12}")
        # tum's files are small; a2fnet needs other outputs, and aris another sonar.
        for name in set(formats()) - {"tum", "a2fnet", "aris"}:
            with self.subTest(format=name):
                folder = scratch()
                margin = ["--margin-px", "99"] if name == "crops" else []  # its files are small
                result = subprocess.run([exported.PROGRAM, "export", source, "--format", name, "-o", folder / "out",
                                         *margin], capture_output=True, text=True, preexec_fn=hold)
                self.assertEqual(result.returncode, 4, result.stderr)
                self.assertIn(".out.part", result.stderr)
                self.assertEqual(list(folder.iterdir()), [])


class Damage(Case):
    """A damaged file ends the export with 4 and tells which."""

    def damage(self, change, *formats, expected=()):
        source = self.copy()
        change(source)
        for name in formats:
            self.refuse(4, source, "--format", name, expected=expected)

    def test_manifests(self):
        def flip(source):
            path = source / "dataset.json"
            path.write_text(path.read_text().replace('"seed": 13', '"seed": 14'))

        self.damage(flip, "tum", expected=["dataset.json", "verify"])

        def cut(source):
            path = source / "sequences/000001/sequence.json"
            path.write_bytes(path.read_bytes()[:-3])

        self.damage(cut, "tum", expected=["000001/sequence.json"])

    def test_tables(self):
        def cut(source):
            path = source / "sequences/000001/poses.csv"
            path.write_text("".join(path.read_text().splitlines(True)[:-1]))

        self.damage(cut, "tum", "yolo", expected=["000001/poses.csv", "ping 2"])

        def words(source):
            path = source / "sequences/000000/objects.csv"
            path.write_text(path.read_text().replace("0,1,0", "0,1,nowhere", 1))

        self.damage(words, "tum", expected=["objects.csv"])

    def test_files_of_a_ping(self):
        def gone(name):
            return lambda source: (source / "sequences/000001" / name).unlink()

        def short(name):
            def change(source):
                path = source / "sequences/000001" / name
                path.write_bytes(path.read_bytes()[:-9])

            return change

        self.damage(gone("png/000001_cartesian.png"), "coco", "yolo", "voc", "crops", "index_mask", "webdataset",
                    "mot", "pairs", expected=["000001_cartesian.png"])
        self.damage(short("polar/000002.exr"), "hdf5", "neusis", "sonic", "pairs", expected=["polar/000002.exr"])
        self.damage(short("timeseries/000002.npy"), "hdf5", "webdataset", "sonar_netcdf4", expected=["timeseries/000002.npy"])
        self.damage(short("polar/000002_instance.png"), "hdf5", "mcap", expected=["000002_instance.png"])
        self.damage(short("png/000002_polar.png"), "mcap", "sdpr", expected=["000002_polar.png"])

    def test_annotations(self):
        def runs(source):
            path = source / "sequences/000000/annotations.jsonl"
            path.write_text(path.read_text().replace('"counts":"', '"counts":"1', 1))

        self.damage(runs, "coco", "yolo", "voc", "crops", expected=["annotations.jsonl", "ping 0"])

    def test_a_link_out_of_the_data_set_is_not_followed(self):
        secret = scratch() / "secret.png"
        secret.write_bytes((exported.dataset() / "sequences/000000/png/000000_cartesian.png").read_bytes())

        def link(source):
            path = source / "sequences/000000/png/000000_cartesian.png"
            path.unlink()
            path.symlink_to(secret)

        self.damage(link, "yolo", "index_mask", expected=["not a file of this folder"])

    def test_a_manifest_that_names_a_file_outside(self):
        def leave(source):
            path = source / "dataset.json"
            path.write_text(path.read_text().replace('"path": "index.csv"', '"path": "../index.csv"'))
            digest = hashlib.sha256(path.read_bytes()).hexdigest()
            (source / "dataset.sha256").write_text(f"{digest}  dataset.json\n")

        self.damage(leave, "tum", expected=["outside its folder"])


if __name__ == "__main__":
    unittest.main()
