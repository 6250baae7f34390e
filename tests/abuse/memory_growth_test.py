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


def status_of(pid):
    """(resident, highest) in kB; None once the process has gone."""
    try:
        lines = pathlib.Path(f"/proc/{pid}/status").read_text().splitlines()
    except OSError:
        return None
    values = dict(line.split(":", 1) for line in lines if ":" in line)
    if "VmRSS" not in values:
        return None
    return tuple(int(values[key].split()[0]) for key in ("VmRSS", "VmHWM"))


def count_of(folder):
    """0 before it is there, and once it has gone."""
    try:
        return len(os.listdir(folder))
    except FileNotFoundError:
        return 0


class Growth(Case):
    text = SMALL

    def memory_of(self, output, *more):
        """[(pings done, resident kB, highest kB)]"""
        records = output / ".work/sequences/000000"
        process = start("generate", self.scenario, "-o", output, "--quiet", "--threads", "2", *more)
        samples = []
        while process.poll() is None:
            now = status_of(process.pid)
            done = count_of(records)
            if now and done:
                samples.append((done, *now))
            time.sleep(0.02)
        said = process.communicate()[1]
        self.assertEqual(process.returncode, 0, said)
        return samples

    def test_memory_is_flat_after_the_first_pings(self):
        output = self.folder / "out"
        highest_of_few = self.memory_of(self.folder / "few", "--set", f"trajectory.pings={PINGS // 4}")[-1][2]
        samples = self.memory_of(output)
        self.assertGreater(max(done for done, _, _ in samples), 0.9 * PINGS)
        early = mean([resident for done, resident, _ in samples if WARM <= done <= 2 * WARM])
        late = mean([resident for done, resident, _ in samples if PINGS - WARM <= done < PINGS])
        highest = samples[-1][2]
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
