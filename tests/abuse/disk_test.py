"""Places that cannot be written, files that go or change, and two processes at once."""
import os
import pathlib
import random
import shutil
import signal
import subprocess
import time
import unittest

from abused import FULL, PROGRAM, Case, contents, errors_in, mount, run, start

EXPORTS = ("yolo", "hdf5", "webdataset")


def is_readable_by_others(program):
    path = pathlib.Path(program).resolve()
    return all(folder.stat().st_mode & 0o001 for folder in path.parents) and path.stat().st_mode & 0o001


class Full(Case):
    """The disk is full, at any moment: told in words, no file cut short, and room lets it go on."""

    def check_fills_up(self, options_small, options_large):
        expected = self.undisturbed()
        disk = self.folder / "disk"
        mount(self, disk, options_small)
        output = disk / "out"
        failed = self.generate(output, "--ignore-free-space", expect=4)
        self.assertIn("No space left", failed.stderr)
        self.assertEqual(errors_in(failed), 1, failed.stderr)
        whole = {name: digest for name, digest in contents(output).items() if not name.startswith(".work/")}
        self.assertEqual({name: expected.get(name) for name in whole}, whole, "a file that is not whole")
        subprocess.run(["mount", "-o", f"remount,{options_large}", disk], check=True)
        self.generate(output)
        self.assertEqual(contents(output), expected)

    def test_no_bytes(self):
        for kilobytes in (200, 700, 1500):
            with self.subTest(kilobytes=kilobytes):
                self.check_fills_up(f"size={kilobytes}k", "size=100m")
            subprocess.run(["umount", "-l", self.folder / "disk"], check=False)

    def test_no_names(self):
        """Bytes enough, and no inode for another file, a temporary one neither."""
        self.check_fills_up("size=100m,nr_inodes=60", "nr_inodes=10000")

    def test_exports_pages_and_figures(self):
        source = self.whole()
        disk = self.folder / "disk"
        mount(self, disk, "size=40k")
        commands = [["export", source, "--format", form, "-o", disk / f"as.{form}"] for form in EXPORTS]
        commands += [["report", source, "-o", disk / "page.html"], ["figure", source, "-o", disk / "f.png"],
                     ["figure", source, "-o", disk / "f.webp"]]
        for command in commands:
            with self.subTest(command=command[0], form=command[-1]):
                done = run(*command)
                self.assertEqual(done.returncode, 4, done.stderr)
                self.assertRegex(done.stderr, "No space left|disk full")
                left = [path for path in disk.rglob("*") if path.is_file() and path.stat().st_size]
                self.assertFalse([path for path in left if path.suffix in (".html", ".png", ".webp", ".hdf5")], "half a file")
            for path in disk.iterdir():
                shutil.rmtree(path) if path.is_dir() else path.unlink()


class TooSmall(Case):
    """A disk that has no room for the data set is refused before anything is written."""

    def disk_for(self, share):
        """A disk with room for this share of the undisturbed data set."""
        files = [path for path in self.whole().rglob("*") if path.is_file()]
        blocks = sum(-(-path.stat().st_size // 4096) for path in files) + len(files) // 8  # and folders
        disk = self.folder / "disk"
        mount(self, disk, f"size={int(share * blocks) * 4096}")
        return disk

    def test_nothing_is_written_without_room(self):
        disk = self.disk_for(0.7)
        refused = self.generate(disk / "out", expect=4)
        self.assertRegex(refused.stderr, r"out: the data needs about [\d.]+ [kM]B of disk space, but only [\d.]+ [kM]B is")
        self.assertIn("--ignore-free-space", refused.stderr)
        self.assertEqual(list(disk.iterdir()), [])
        self.assertIn("which is too little", run("check", self.scenario, "-o", disk / "out").stdout)
        self.assertIn("No space left", self.generate(disk / "out", "--ignore-free-space", expect=4).stderr)

    def test_what_is_there_needs_no_room(self):
        expected = self.undisturbed()
        disk = self.disk_for(1.25)
        output = disk / "out"
        self.generate(output, "--sequences", "0:2")
        self.assertLess(os.statvfs(disk).f_bavail, os.statvfs(disk).f_blocks / 2)
        self.generate(output)
        self.assertEqual(contents(output), expected)
        # Complete: nothing is to be written.
        self.generate(output)
        # Other work in its place: what is removed for it makes room.
        self.generate(disk / "other", "--seed", "12", expect=4)
        self.assertFalse((disk / "other").exists())
        self.generate(output, "--seed", "12", "--overwrite")
        self.assertNotEqual(contents(output), expected)

    def test_a_part_needs_its_share(self):
        disk = self.disk_for(0.6)
        self.generate(disk / "out", expect=4)
        self.generate(disk / "out", "--shard", "0/3")
        shutil.rmtree(disk / "out")
        self.generate(disk / "out", "--sequences", "1:2")
        shutil.rmtree(disk / "out")
        self.generate(disk / "out", "--pings", "0:4")


class NotWritable(Case):
    def test_folder_of_another_user(self):
        output = self.folder / "mine"
        output.mkdir()
        self.scenario.chmod(0o644)
        self.folder.chmod(0o755)
        output.chmod(0o555)
        options = {}
        if os.geteuid() == 0:  # root is refused nothing
            if not is_readable_by_others(PROGRAM):
                self.skipTest("the program is in a folder that only root may read")
            options = {"user": 65534, "group": 65534}
        for target in (output, output / "new"):
            done = self.generate(target, expect=4, **options)
            self.assertIn("ermission denied", done.stderr)
            self.assertEqual(errors_in(done), 1, done.stderr)
        self.assertEqual(list(output.iterdir()), [])

    def test_read_only_file_system(self):
        disk = self.folder / "disk"
        mount(self, disk, "size=100m")
        output = disk / "out"
        self.generate(output, "--pings", "0:2")
        before = contents(output)
        subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
        done = self.generate(disk / "other", expect=4)
        self.assertIn("ead-only", done.stderr)
        # Done already: nothing is to be written, and it may be read.
        self.generate(output, "--pings", "0:2")
        self.assertEqual(run("verify", output).returncode, 0)
        self.assertEqual(contents(output), before)

    def test_names_as_long_as_names_may_be(self):
        """The temporary name of a file must not be what does not fit."""
        output = self.folder / ("n" * 255)
        self.generate(output)
        self.assertEqual(contents(output), self.undisturbed())
        done = self.generate(self.folder / ("n" * 256), expect=4)
        self.assertIn("too long", done.stderr)


class Damage(Case):
    text = FULL.replace("pings: 12", "pings: 30")

    def half_finished(self, output):
        """One sequence whole, and a second one up to the middle. A fast run or a slow test is repeated."""
        self.generate(output, "--sequences", "0:1")
        while True:
            process = start("generate", self.scenario, "-o", output, "--threads", "1")
            while process.poll() is None and len(list(output.glob("sequences/000001/polar/*"))) < 20:
                time.sleep(0.001)
            process.kill()
            process.communicate()
            if not (output / "sequences/000001/sequence.json").exists():
                return
            shutil.rmtree(output)
            self.generate(output, "--sequences", "0:1")

    def test_files_gone_or_cut_short_are_made_again(self):
        output = self.folder / "out"
        self.half_finished(output)
        files = sorted(path for path in output.glob("sequences/000001/*/*") if path.is_file())
        self.assertGreater(len(files), 20)
        for number, path in enumerate(random.Random(3).sample(files, 12)):
            if number % 3 == 0:
                path.unlink()
            else:
                os.truncate(path, path.stat().st_size // 2 if number % 3 == 1 else 0)
        self.generate(output)
        self.assertEqual(contents(output), self.undisturbed())
        self.assertEqual(run("verify", output).returncode, 0)


class Together(Case):
    text = FULL.replace("pings: 12", "pings: 30")

    def stopped(self, output, *more, until):
        """A run that is stopped in its midst, once files of this pattern are there. One that was too fast is repeated."""
        while True:
            process = start("generate", self.scenario, "-o", output, "--quiet", "--threads", "1", *more)
            self.addCleanup(process.kill)
            while process.poll() is None and not list(output.glob(until)):
                time.sleep(0.001)
            process.send_signal(signal.SIGSTOP)
            if process.poll() is None:
                return process
            self.assertEqual(process.returncode, 0, process.communicate()[1])
            shutil.rmtree(output)

    def test_the_same_work_twice_ends_correct(self):
        output = self.folder / "twice"
        both = [start("generate", self.scenario, "-o", output, "--quiet") for _ in range(2)]
        for process in both:
            said = process.communicate()[1]
            self.assertEqual(process.returncode, 0, said)
        self.assertEqual(contents(output), self.undisturbed())

    def test_other_work_is_refused(self):
        output = self.folder / "out"
        first = self.stopped(output, until="sequences/*/polar/*")
        for other in (["--seed", "12"], ["--set", "sonar.range_max_m=3"], ["--export-scatterers"],
                      ["--seed", "12", "--overwrite"]):
            done = self.generate(output, *other, expect=2)
            self.assertIn(str(output), done.stderr)
        first.send_signal(signal.SIGCONT)
        first.communicate()
        self.assertEqual(first.returncode, 0)
        self.assertEqual(contents(output), self.undisturbed())

    def test_the_same_work_with_more_sequences(self):
        """Whoever ends last, all sequences are there: a slow node with the old number does not take away the new ones."""
        output = self.folder / "grown"
        fewer = self.stopped(output, "--set", "sequences=2", until="sequences/000001/polar/*")
        self.generate(output)
        fewer.send_signal(signal.SIGCONT)
        said = fewer.communicate()[1]
        self.assertEqual(fewer.returncode, 0, said)
        self.assertEqual(contents(output), self.undisturbed())
        self.assertEqual(run("verify", output).returncode, 0)


if __name__ == "__main__":
    unittest.main()
