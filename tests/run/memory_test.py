"""What `check` announces of memory against what `generate` took at most, as the kernel counts it, and what is refused
because it cannot fit.

ENSONIFY is the program. Run by ctest, without sanitizers; by hand:
    ENSONIFY=build/release/ensonify PYTHONPATH=scripts:tests/cli python3 -m unittest memory_test
"""
import functools
import math
import os
import pathlib
import re
import resource
import shutil
import subprocess
import unittest

import program
from program import PROGRAM

HEAD = """ensonify: 1
name: memory
materials: {m: {reflectivity: 1e-3}}
trajectory: {ping_rate_hz: 5, pings: 4}
"""

ROOM = HEAD + """
sonar: {preset: paper_table1, bandwidth_hz: 29900, range_max_m: 20, rays: {elevation: 60}}
objects:
  - {name: room, class: room, material: m, shape: {box: {size_m: [40, 40, 6], inward_facing: true}}}
"""

MESH = HEAD + """
sonar: {preset: paper_table1, bandwidth_hz: 29900, range_max_m: 20, beams: {count: 64, fov_deg: 64}, rays: {elevation: 16}}
objects:
  - {name: floor, class: floor, material: m, shape: {mesh: {file: floor.obj}}, pose: {position_m: [0, 0, -3]}}
output: {cartesian: {height_px: 100}}
"""

# What threads and the libraries of some outputs map when they start.
STARTED = 200_000_000


def within(most_bytes):
    """As ulimit -v."""
    return lambda: resource.setrlimit(resource.RLIMIT_AS, (int(most_bytes), int(most_bytes)))


@functools.cache
def mapped_bytes():
    """What the program and its libraries map before they hold anything, which differs between systems."""
    for most_bytes in range(40_000_000, 2_000_000_000, 20_000_000):
        if program.run("--version", preexec_fn=within(most_bytes)).returncode == 0:
            return most_bytes
    raise AssertionError("does not start")


def floor(side):
    """2 (side - 1)^2 triangles, as OBJ."""
    at = range(side)
    lines = [
        f"v {i * 40 / side - 20:.3f} {j * 40 / side - 20:.3f} {0.1 * math.sin(i * j):.3f}"
        for i in at
        for j in at
    ]
    for i in at[:-1]:
        for j in at[1:]:
            a, b = i * side + j, (i + 1) * side + j
            lines += [f"f {a} {b} {b + 1}", f"f {a} {b + 1} {a + 1}"]
    return "\n".join(lines) + "\n"


class Announced(program.Case):
    def setUp(self):
        super().setUp()
        # `check` and `generate` take a thread for each processor that they may use.
        allowed = os.sched_getaffinity(0)
        self.addCleanup(os.sched_setaffinity, 0, allowed)
        os.sched_setaffinity(0, sorted(allowed)[:2])

    def check_announced(self, text, *overrides):
        scenario = self.folder / "memory.yaml"
        scenario.write_text(text)
        changes = [word for override in overrides for word in ("--set", override)]
        said = subprocess.run(
            [PROGRAM, "check", scenario, *changes], capture_output=True, text=True, check=True
        ).stdout
        number, unit = re.search(r"peak memory: about ([\d.]+) (MB|GB)", said).groups()
        announced = float(number) * {"MB": 1e6, "GB": 1e9}[unit]
        # A run takes the most only if its pings hold their most at the same time, which the scheduler
        # decides; the announcement is of the most, so the largest of several runs is compared with it.
        most = 0
        for attempt in range(5):
            out = self.folder / f"out{attempt}"
            # Little more than what was announced suffices, and is not refused.
            limits = within(1.3 * announced + mapped_bytes() + STARTED) if attempt == 0 else None
            most = max(most, self.taken(scenario, out, changes, limits))
            shutil.rmtree(out)
            self.assertLess(most, 1.15 * announced, f"took {most}, announced {announced}")
            if announced < 1.5 * most:
                return
        self.fail(f"took {most} at most, announced {announced}")

    def taken(self, scenario, out, changes, limits=None):
        """The most that one run held, in bytes."""
        told = out.with_suffix(".txt")
        with told.open("w") as stream:
            made = subprocess.Popen([PROGRAM, "generate", scenario, "-o", out, "--quiet", *changes],
                                    stderr=stream, preexec_fn=limits)
            _, made.returncode, usage = os.wait4(made.pid, 0)
        self.assertEqual(made.returncode, 0, told.read_text())
        self.assertNotRegex(told.read_text(), "in place of|may not suffice")
        return usage.ru_maxrss * 1024


class Memory(Announced):
    def test_statistics(self):
        self.check_announced(ROOM, "output={statistics: true, pings: false}", "trajectory.pings=20")

    def test_pictures(self):
        self.check_announced(ROOM)

    def test_packed_sequences(self):
        self.check_announced(ROOM, "output.one_file_per=sequence", "output.layers=true")

    def test_large_mesh(self):
        (self.folder / "floor.obj").write_text(floor(340))
        self.check_announced(MESH)


BED = HEAD + """
sonar: {preset: sonoptix_echo_hf, bandwidth_hz: 25000, range_max_m: 30, beams: {fov_deg: 60}, mount: {rotation_deg: [0, 25, 0]}}
objects:
  - {name: bed, class: bed, material: m, shape: {plane: {}}, pose: {position_m: [0, 0, -2]}}
  - {name: ball, class: ball, material: m, shape: {sphere: {radius_m: 1}}, pose: {position_m: [6, 0, -1]}}
"""
SEABED = "objects.0.shape={heightfield: {size_m: [200, 200], cell_m: 0.03, roughness: {rms_m: 0.05, outer_scale_m: 5}}}"

# What costs most, how much memory is there beyond what the program maps, and the settings.
REFUSED = {
    "sonar.range_max_m": (5e9, "sonar.range_max_m=31000"),
    "sonar.beams.count": (2e9, "sonar.beams.count=65536"),
    "sonar.rays.elevation": (8e9, "sonar.rays={elevation: 8192, azimuth: 64}"),
    "sonar.rays.azimuth": (8e9, "sonar.rays={elevation: 64, azimuth: 8192}"),
    "sonar.range_max_m, or no output.channels": (
        1.2e9, "sonar.range_max_m=1900", "sonar.receiver={mode: array, elements: 4096}",
        "output={channels: true, polar: false, cartesian: false, png: false}"),
    "objects.0.shape.heightfield.cell_m": (4e9, SEABED),
    "output.sdf.voxel_m": (1e9, "output.sdf.voxel_m=0.004"),
    "output.height_map.spacing_m": (5e7, "output.height_map.spacing_m=0.004"),
    "output.cartesian.height_px": (2e9, "output.cartesian.height_px=16384"),
    # Samples of many pings, and of several signals.
    "sonar.range_max_m, or no output.statistics": (
        5e8, "sonar.range_max_m=800", "output={statistics: true, pings: false}"),
    "sonar.range_max_m, or no output.layers": (
        1.2e9, "sonar.range_max_m=3000", "sonar.rays.min_per_cell=0", "noise={spectrum_level_db: 30}",
        "output={layers: true, polar: false, cartesian: false, png: false}"),
}


class Refused(program.Case):
    """What cannot fit ends with 5 before anything large is made, and the message names the key that costs most."""

    def refuse(self, key, most_bytes, scenario, *overrides):
        key, _, spared = key.partition(", or ")
        for words in (["check", scenario], ["generate", scenario, "-o", self.folder / "out"]):
            told = self.folder / "told.txt"
            with told.open("w") as stream:
                made = subprocess.Popen([PROGRAM, *words, "--threads", "2", *program.settings(*overrides)],
                                        stdout=stream, stderr=stream, preexec_fn=within(mapped_bytes() + most_bytes))
                _, made.returncode, usage = os.wait4(made.pid, 0)
            message = told.read_text()
            self.assertEqual(os.waitstatus_to_exitcode(made.returncode), 5, message)
            self.assertEqual(message.count("\n"), 1, message)
            self.assertRegex(message, rf"{re.escape(key)}: .* take at least [\d.]+ [MG]B of memory with one thread")
            self.assertRegex(message, r"\(ulimit -v\); expected (at least|at most|less)")
            self.assertIn(spared, message)
            self.assertLess(usage.ru_utime + usage.ru_stime, 1)
            self.assertLess(usage.ru_maxrss, 200_000)
        self.assertFalse((self.folder / "out").exists())

    def test_what_cannot_fit(self):
        scenario = self.folder / "bed.yaml"
        scenario.write_text(BED)
        for key, (most_bytes, *overrides) in REFUSED.items():
            with self.subTest(key):
                self.refuse(key, most_bytes, scenario, *overrides)

    def test_the_place_of_the_key(self):
        scenario = self.folder / "bed.yaml"
        scenario.write_text(BED.replace("range_max_m: 30", "range_max_m: 31000"))
        self.refuse("bed.yaml:6:69: sonar.range_max_m", 5e9, scenario)

    def test_a_control_group(self):
        groups = pathlib.Path("/sys/fs/cgroup/memory")  # of the first kind
        limit = "memory.limit_in_bytes"
        if not groups.exists():
            groups, limit = pathlib.Path("/sys/fs/cgroup"), "memory.max"
        group = groups / f"ensonify-test-{os.getpid()}"
        try:
            group.mkdir()
            self.addCleanup(group.rmdir)
            (group / limit).write_text("2000000000")
        except OSError as error:
            self.skipTest(f"no control group can be made: {error}")
        scenario = self.folder / "bed.yaml"
        scenario.write_text(BED)
        done = program.run("check", scenario, "--set", "sonar.range_max_m=31000",
                           preexec_fn=lambda: (group / "cgroup.procs").write_text(str(os.getpid())))
        self.assertEqual(done.returncode, 5, done.stderr)
        self.assertRegex(done.stderr, r"range_max_m: .* but 2.0 GB is available; expected at most")


class Lowered(program.Case):
    def test_fewer_threads_make_the_same(self):
        scenario = self.folder / "room.yaml"
        scenario.write_text(ROOM)
        words = ("--threads", 12, "--quiet", "--set", "trajectory.pings=12", "--set", "output.layers=true")
        outs = [self.folder / "all", self.folder / "few"]
        program.run("generate", scenario, "-o", outs[0], *words, check=True)
        done = program.run("generate", scenario, "-o", outs[1], *words, preexec_fn=within(mapped_bytes() + 4e8))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stderr, r"warning: \d+ threads? in place of 12, which need about .* \(ulimit -v\)")
        self.assertEqual(*[program.hashes(out) for out in outs])


class RunsOut(program.Case):
    def test_one_line_and_a_status(self):
        """Memory that ends at any moment: of the program, of the world, of its pings."""
        scenario = self.folder / "room.yaml"
        scenario.write_text(ROOM)
        ended = set()
        for more_bytes in range(0, 280_000_000, 40_000_000):
            out = self.folder / f"out{more_bytes}"
            done = program.run("generate", scenario, "-o", out, "--threads", 2, "--quiet",
                               preexec_fn=within(mapped_bytes() + more_bytes))
            ended.add(done.returncode)
            errors = [line for line in done.stderr.splitlines() if not line.startswith("warning: ")]
            self.assertEqual(len(errors), int(done.returncode != 0), done.stderr)
        self.assertEqual(ended, {0, 5})


if __name__ == "__main__":
    unittest.main()
