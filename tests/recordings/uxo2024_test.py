"""scripts/uxo2024_log.py on a synthetic copy of a recording's layout: the log that it rebuilds is imported as the
log that the copy was made from."""
import csv
import struct
import subprocess
import sys
import unittest

import numpy as np

import write_logs
from cases import ROOT, Case

SCRIPT = ROOT / "scripts/uxo2024_log.py"


class Uxo2024(Case):
    def copied(self, frames):
        """The layout of frames of a log."""
        recording = self.folder / "recording"
        (recording / "aris_raw").mkdir(parents=True)
        rows = []
        for index, frame in enumerate(frames):
            beams = 128
            samples = (len(frame) - 1024) // beams
            image = b"P5\n# frame\n%d %d\n255\n" % (beams, samples) + frame[1024:]
            (recording / "aris_raw" / f"{index:04}.pgm").write_bytes(image)
            row = {name: struct.unpack_from("<" + kind, frame, offset)[0]
                   for name, (offset, kind) in write_logs.FRAME.items()}
            rows.append({**row, "WindowStart": 1.5, "WindowLength": 3.0, "SampleRate": 0.0, "GoTime": 7})
        with open(recording / "aris_frame_meta.csv", "w", newline="") as file:
            writer = csv.DictWriter(file, list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)
        return recording

    def test_the_log_is_that_of_the_images(self):
        rng = np.random.default_rng(4)
        frames = [write_logs.aris_frame(rng.integers(0, 256, (40, 128)), FrameIndex=k, FrameTime=10**15 + 125000 * k,
                                        sonarTimeStamp=10**15 + 125000 * k, Pitch=-12.5, Roll=1.25, Heading=30.0 + k,
                                        Depth=1.5) for k in range(3)]
        recording = self.copied(frames)
        subprocess.run([sys.executable, SCRIPT, recording, self.folder / "rebuilt.aris"], check=True)
        original = self.imported(write_logs.aris(frames), "original.aris", out="original")
        rebuilt = self.imported((self.folder / "rebuilt.aris").read_bytes(), "rebuilt.aris", out="rebuilt")
        self.assertEqual(len(rebuilt), 3)
        for a, b in zip(original, rebuilt):
            np.testing.assert_array_equal(a.recorded, b.recorded)
            np.testing.assert_array_equal(a.sequence.azimuth_rad, b.sequence.azimuth_rad)
            np.testing.assert_array_equal(a.sequence.range_m, b.sequence.range_m)
            np.testing.assert_array_equal(a.pose.quaternion_wxyz, b.pose.quaternion_wxyz)
            self.assertEqual(a.time_s, b.time_s)

        (recording / "aris_raw/0001.pgm").unlink()
        subprocess.run([sys.executable, SCRIPT, recording, self.folder / "fewer.aris"], check=True)
        self.assertEqual(len(self.imported((self.folder / "fewer.aris").read_bytes(), out="fewer")), 2)

        (recording / "aris_raw/0002.pgm").write_bytes(b"P5\n128 39\n255\n" + bytes(128 * 39))
        refused = subprocess.run([sys.executable, SCRIPT, recording, self.folder / "x.aris"], capture_output=True,
                                 text=True)
        self.assertEqual(refused.returncode, 1)
        self.assertIn("39 rows", refused.stderr)
        self.assertFalse((self.folder / "x.aris").exists())


if __name__ == "__main__":
    unittest.main()
