"""What a scheduler, a shell or a container may take from a process that has to work all night: somebody
who listens, open streams, threads, descriptors, sizes of files.
"""
import os
import resource
import subprocess
import sys
import unittest

from abused import PROGRAM, Case, contents, errors_in, run

SANITIZED = bool(os.environ.get("SANITIZED"))


def limited(what, most):
    return lambda: resource.setrlimit(what, (most, most))


class Streams(Case):
    """Messages that nobody can hear are no reason to stop, and never land in a file of the data set."""

    def test_a_full_disk_under_the_log(self):
        with open("/dev/full", "w", encoding="ascii") as full:
            done = subprocess.run([PROGRAM, "generate", self.scenario, "-o", self.folder / "out"], stderr=full, check=False)
            self.assertEqual(done.returncode, 0)
            self.assertEqual(contents(self.folder / "out"), self.undisturbed())
            # What goes wrong keeps its status.
            for words, status in ((["check", self.folder / "nowhere.yaml"], 2), (["check", "--bogus"], 2), (["verify", self.folder], 2)):
                self.assertEqual(subprocess.run([PROGRAM, *words], stderr=full, check=False).returncode, status, words)

    def test_streams_that_are_closed(self):
        for closed in ((2,), (1, 2), (0, 1, 2)):
            with self.subTest(closed=closed):
                output = self.folder / f"out{len(closed)}"
                words = [PROGRAM, "generate", self.scenario, "-o", output]
                done = subprocess.run(words, preexec_fn=lambda: [os.close(stream) for stream in closed], check=False)
                self.assertEqual(done.returncode, 0)
                self.assertEqual(contents(output), self.undisturbed())
                self.assertEqual(run("verify", output).returncode, 0)

    def test_an_answer_that_is_lost_is_told(self):
        for words in (["check", self.scenario], ["--help"], ["--version"], ["presets"], ["generate", "--help"]):
            with self.subTest(words=words), open("/dev/full", "w", encoding="ascii") as full:
                done = subprocess.run([PROGRAM, *words], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
                self.assertEqual(done.returncode, 4)
                self.assertIn("standard output: cannot be written", done.stderr)


class Limits(Case):
    def test_sizes_of_files(self):
        expected = self.undisturbed()
        output = self.folder / "out"
        done = self.generate(output, expect=4, preexec_fn=limited(resource.RLIMIT_FSIZE, 20_000))
        self.assertIn("File too large", done.stderr)
        self.assertEqual(errors_in(done), 1, done.stderr)
        whole = {name: digest for name, digest in contents(output).items() if not name.startswith(".work/")}
        self.assertEqual({name: expected.get(name) for name in whole}, whole, "a file that is not whole")
        self.generate(output)
        self.assertEqual(contents(output), expected)

    def test_descriptors(self):
        for most in (64, 12):
            output = self.folder / f"out{most}"
            done = run("generate", self.scenario, "-o", output, "--quiet", preexec_fn=limited(resource.RLIMIT_NOFILE, most))
            self.assertIn(done.returncode, (0, 4), done.stderr)
            self.generate(output)
            self.assertEqual(contents(output), self.undisturbed())

    @unittest.skipIf(SANITIZED, "a sanitizer has threads of its own")
    @unittest.skipIf(os.geteuid() != 0, "becomes another user, who has no other thread")
    def test_threads(self):
        """The libraries' own start before the program does: the first number that lets them."""
        self.folder.chmod(0o777)
        self.scenario.chmod(0o644)
        told = ""
        for most in range(1, 40):
            words = [sys.executable, "-c",
                     "import os, resource, sys\n"
                     f"resource.setrlimit(resource.RLIMIT_NPROC, ({most}, {most}))\n"
                     "os.setgroups([]); os.setgid(64999); os.setuid(64999)\n"
                     "os.execv(sys.argv[1], sys.argv[1:])\n",
                     PROGRAM, "generate", self.scenario, "-o", self.folder / f"out{most}", "--quiet", "--threads", "6"]
            done = subprocess.run([*map(str, words)], capture_output=True, text=True, check=False)
            if "PermissionError" in done.stderr:
                self.skipTest("the program is in a folder that only root may read")
            if done.returncode == 0:
                break
            if done.returncode == 5:
                told = done.stderr
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("cannot start more threads; give fewer --threads", told)
        self.assertEqual(contents(self.folder / f"out{most}"), self.undisturbed())


if __name__ == "__main__":
    unittest.main()
