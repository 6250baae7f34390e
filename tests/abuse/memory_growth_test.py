"""Memory over many pings: what is taken after the first 400 is what is taken before the last, and a
quarter of the pings takes as much at most, finishing included: tables are written through buffers of
fixed size, which few pings do not fill.

PINGS: how many (1,600; 10,000 where the long tests run).
"""
import os
import pathlib
import time

from abused import Case, run, start

PINGS = int(os.environ.get("PINGS", "1600"))
WARM = 400

SMALL = f"""ensonify: 1
name: long
seed: 3
sonar:
  preset: blueview_p900_90
  range_max_m: 2
  beams: {{count: 24, fov_deg: 40}}
  rays: {{elevation: 4, min_per_cell: 4}}
materials: {{m: {{reflectivity: 1e-3}}}}
objects:
  - {{name: room, class: room, material: m, shape: {{box: {{size_m: [7, 7, 2], inward_facing: true}}}}}}
  - {{name: ball, class: target, material: m, shape: {{sphere: {{radius_m: 0.3}}}}, pose: {{position_m: [1.5, 0, 0]}}}}
trajectory: {{ping_rate_hz: 5, pings: {PINGS}}}
noise: {{spectrum_level_db: 30}}
output: {{cartesian: {{height_px: 60}}}}
"""


def resident_kb(pid):
    """None once the process has gone."""
    try:
        lines = pathlib.Path(f"/proc/{pid}/status").read_text().splitlines()
    except OSError:
        return None
    return next((int(line.split()[1]) for line in lines if line.startswith("VmRSS:")), None)


def count_of(folder):
    """0 before it is there, and once it has gone."""
    try:
        return len(os.listdir(folder))
    except FileNotFoundError:
        return 0


class Growth(Case):
    text = SMALL

    def memory_of(self, output, *more):
        """[(pings done, resident kB)]"""
        records = output / ".work/sequences/000000"
        process = start("generate", self.scenario, "-o", output, "--quiet", "--threads", "2", *more)
        samples = []
        while process.poll() is None:
            now = resident_kb(process.pid)
            done = count_of(records)
            if now and done:
                samples.append((done, now))
            time.sleep(0.02)
        said = process.communicate()[1]
        self.assertEqual(process.returncode, 0, said)
        return samples

    def highest_of(self, pings):
        """In kB, of three runs: the allocators of two threads add up to a megabyte to some of them, a leak to all."""
        peaks = []
        for run_number in range(3):
            process = start("generate", self.scenario, "-o", self.folder / f"{pings}_{run_number}", "--quiet",
                            "--threads", "2", "--set", f"trajectory.pings={pings}")
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
            self.assertEqual(process.returncode, 0, process.communicate()[1])
            peaks.append(usage.ru_maxrss)
        return peaks

    def test_memory_is_flat_after_the_first_pings(self):
        output = self.folder / "out"
        samples = self.memory_of(output)
        self.assertGreater(max(done for done, _ in samples), 0.9 * PINGS)
        early = mean([resident for done, resident in samples if WARM <= done <= 2 * WARM])
        late = mean([resident for done, resident in samples if PINGS - WARM <= done < PINGS])
        highest_of_few, highest = max(self.highest_of(PINGS // 4)), min(self.highest_of(PINGS))
        print(f"{PINGS} pings: {early / 1e3:.1f} MB after the first {WARM}, {late / 1e3:.1f} MB before the last; "
              f"highest {highest / 1e3:.1f} MB, of {PINGS // 4} pings {highest_of_few / 1e3:.1f} MB")
        self.assertLess(late, 1.02 * early)
        self.assertLess(highest, 1.02 * highest_of_few)
        self.assertEqual(run("verify", output).returncode, 0)


def mean(values):
    return sum(values) / len(values)


if __name__ == "__main__":
    import unittest

    unittest.main()
