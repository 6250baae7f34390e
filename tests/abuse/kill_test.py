"""Runs, rigs and sweeps that are killed at random moments and started again: every byte is that of an
undisturbed run, and nothing is left over.

KILLS: how many each (10). Moments are drawn from KILL_SEED, or from the clock; it is told where a
comparison fails. scripts/kill_test.sh runs 200.
"""
import os
import pathlib
import random
import shutil
import signal
import subprocess
import time

from abused import PROGRAM, Case, contents, run, start

KILLS = int(os.environ.get("KILLS", "10"))
SEED = int(os.environ.get("KILL_SEED", str(time.time_ns() % 1_000_000)))

SWEEP = """ensonify_sweep: 1
base: scenario.yaml
set: {sequences: 1, trajectory.pings: 3}
axes:
  - {key: sonar.range_max_m, values: [3, 3.5, 4]}
  - {key: noise.spectrum_level_db, values: [20, 30]}
"""


RIG = """ensonify: 1
name: rig
sequences: 2
rig:
  - name: ear
    sonar: {frequency_hz: 500e3, bandwidth_hz: 10e3, source_level_db: 200, range_min_m: 1, range_max_m: 6,
            beams: {count: 24, fov_deg: 48, receive_width_deg: 1.5}, elevation: {width_deg: 20}, rays: {elevation: 8}}
    ping_rate_hz: 10
  - {name: eye, camera: {width_px: 40, height_px: 30, fov_deg: 60}, time_offset_s: 0.05}
  - {name: nav, navigation: {imu: {rate_hz: 100}, dvl: {rate_hz: 10, range_max_m: 20}}}
scattering: {speckle: surface}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: room, class: room, material: m, shape: {box: {size_m: [9, 9, 3], inward_facing: true}}}
  - {name: ball, class: ball, material: m, shape: {sphere: {radius_m: 0.3}}, pose: {position_m: [{uniform: [2, 3]}, 0, 0]}}
trajectory: {ping_rate_hz: 5, pings: 4}
noise: {spectrum_level_db: 20}
"""

SLOW_TO_BUILD = "{heightfield: {size_m: [200, 200], cell_m: 0.1, roughness: {rms_m: 0.1, exponent: 3.2, outer_scale_m: 15}}}"


def at_random(draw, longest_s, command):
    """Starts the command, kills it at some moment; whether it lived then."""
    process = start(*command)
    # Half of them early, where starting, finding and locking are.
    time.sleep(draw.uniform(0, longest_s * draw.choice([0.1, 0.9])))
    process.send_signal(signal.SIGKILL)
    process.communicate()
    return process.returncode == -signal.SIGKILL


class Kills(Case):
    def check_kills(self, output, command, end):
        """`end` makes the rest and returns what is there."""
        started = time.monotonic()
        expected = end()
        longest = time.monotonic() - started
        draw = random.Random(SEED)
        kills = rounds = 0
        while kills < KILLS:
            shutil.rmtree(output)
            # Five and then the end: otherwise the kills would stop where nothing is left to do.
            for _ in range(min(5, KILLS - kills)):
                kills += at_random(draw, longest, command)
            self.assertEqual(end(), expected, f"KILL_SEED={SEED}, after {kills} kills")
            rounds += 1
        print(f"{kills} kills in {rounds} rounds, {len(expected)} files compared in each")

    def test_a_run_killed_at_random_moments(self):
        output = self.folder / "out"

        def end():
            self.generate(output)
            return contents(output)

        self.check_kills(output, ["generate", self.scenario, "-o", output, "--quiet"], end)
        self.assertEqual(run("verify", output).returncode, 0)

    def test_a_rig_killed_at_random_moments(self):
        scenario = self.folder / "rig.yaml"
        scenario.write_text(RIG)
        output = self.folder / "out"
        command = ["generate", scenario, "-o", output, "--quiet"]

        def end():
            done = run(*command)
            self.assertEqual(done.returncode, 0, done.stderr)
            return contents(output)

        self.check_kills(output, command, end)
        self.assertEqual(run("verify", output).returncode, 0)

    def test_a_sweep_killed_at_random_moments(self):
        sweep = self.folder / "sweep.yaml"
        sweep.write_text(SWEEP)
        output = self.folder / "out"

        def end():
            for more in ([], ["--finalize"]):
                done = run("sweep", sweep, "-o", output, "--quiet", *more)
                self.assertEqual(done.returncode, 0, done.stderr)
            return contents(output)

        self.check_kills(output, ["sweep", sweep, "-o", output, "--quiet"], end)

    def test_signals_finish_the_ping_in_hand(self):
        """Pings of many rays: a signal in the midst of one must wait for it, lose none and end with 130."""
        output = self.folder / "out"
        dear = ["--sequences", "0:1", "--set", "sonar.rays={elevation: 40, azimuth: 50}"]
        expected = self.undisturbed(*dear)
        command = ["generate", self.scenario, "-o", output, "--quiet", "--threads", "1", *dear]
        signal.signal(signal.SIGHUP, signal.SIG_DFL)  # tests may run under nohup, which is inherited
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            before = self.records(output)
            process = start(*command)
            while process.poll() is None and self.records(output) <= before:
                time.sleep(0.001)
            process.send_signal(number)
            said = process.communicate()[1]
            self.assertEqual(process.returncode, 130, said)
            self.assertIn("repeat the command to resume", said)
            self.assertGreater(self.records(output), before)
            self.assertFalse(list(output.glob(".work/tmp/*")), "left over")
        # Under nohup a closed terminal is no reason to stop.
        before = self.records(output)
        process = subprocess.Popen(["nohup", PROGRAM, *map(str, command)], stderr=subprocess.DEVNULL)
        while process.poll() is None and self.records(output) <= before:
            time.sleep(0.001)
        process.send_signal(signal.SIGHUP)
        self.assertEqual(process.wait(), 0)
        self.assertEqual(contents(output), expected)

    def test_a_signal_before_the_first_ping(self):
        """While the world is built, there is nothing to finish: at once, with 130, and nothing is written."""
        for number in (signal.SIGINT, signal.SIGTERM):
            output = self.folder / "never"
            process = start("generate", self.scenario, "-o", output, "--quiet", "--set", f"objects.1.shape={SLOW_TO_BUILD}")
            self.addCleanup(process.kill)
            while process.poll() is None and not self.catches(process.pid, number):
                time.sleep(0.001)
            process.send_signal(number)
            said = process.communicate()[1]
            self.assertEqual(process.returncode, 130, said)
            self.assertFalse(output.exists())

    @staticmethod
    def catches(pid, number):
        status = pathlib.Path(f"/proc/{pid}/status").read_text().split("SigCgt:")[1].split()[0]
        return int(status, 16) >> (number - 1) & 1

    @staticmethod
    def records(output):
        # os.walk bears folders that go away meanwhile.
        made = sum(name.endswith(".json") for _, _, names in os.walk(output / ".work/sequences") for name in names)
        return made + 100 * len(list(output.glob("sequences/*/sequence.json")))


if __name__ == "__main__":
    import unittest

    unittest.main()
