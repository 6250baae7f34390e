"""scripts/make_performance.py fills the tables of docs/performance.md, and keeps those it has no numbers for."""
import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
sys.dont_write_bytecode = True
from make_performance import BLOCK, ENSEMBLE, FEATURES, FILES, GROWTH, HOST, SCENES, filled  # noqa: E402

PAGE = (ROOT / "docs/performance.md").read_text(encoding="utf-8")
NAMES = re.search(r"kStageNames\[\] = \{(.*?)\}", (ROOT / "generator/core/stage_times.cpp").read_text(), re.S)[1]
STAGES = [*re.findall(r'"(\w+)"', NAMES), "rest"]
ROW = {"beams": 512, "samples": 2392, "rays": 58368, "pings_per_s": 10.0, "pings_per_s_least": 9.5,
       "pings_per_s_most": 12.25, "core_ms_per_ping": 123.4, "mb_per_ping": 14.7, "physics_share": 0.345,
       "stages_ms": dict.fromkeys(STAGES, 2.5), "error": 1.6e-6, "error_worst_tenth": 9.7e-6}
MACHINE = {"threads": 2, "simd": "avx2", "copy_gb_s": 26.66, "disk_mb_s": 2853.7}
NOTHING = {"tables": {}, "machine": MACHINE}
SERIES = {"series": {"rows": {"full": ROW}}}
WHOLE = {"machine": MACHINE, "tables": {
    **SERIES, "files": {"rows": dict.fromkeys(FILES, ROW)}, "scenes": {"rows": dict.fromkeys(SCENES, ROW)},
    "features": {"rows": dict.fromkeys(FEATURES, ROW)}, "ensemble": {"rows": dict.fromkeys(ENSEMBLE, ROW)},
    **{name: {"rows": {str(n): {name: n, "pings_per_s": 30.0 * n} for n in (1, 2)},
              "exponents": {"core": {"all": 0.061, "last_two": None}}} for name in GROWTH}}}
CHECK = {"machine": {"device": "a device", "driver": "580.65", "toolkit": "13.0", "threads": 16, "processor": "a processor"},
         "figures": {name: {"what": name, "unit": unit, "wanted": wanted, "at_least": more, "value": value, "met": met}
                     for name, unit, wanted, more, value, met in [
                         ("full", "pings/s", 15000, True, 20123, True), ("sets", "", 1.5, True, 1.236, False),
                         ("scenes", "", 1e-5, False, None, None)]}}


class Performance(unittest.TestCase):
    def test_a_device_leaves_every_other_stage_to_the_host(self):
        host = [stage for group in HOST.values() for stage in group]
        self.assertEqual(sorted([*host, "synthesis", "world", "tables"]), sorted(STAGES))

    def test_a_table_without_numbers_stays(self):
        self.assertEqual(filled(PAGE, NOTHING, "a processor"), PAGE)
        some = {"tables": {**SERIES, "scenes": WHOLE["tables"]["scenes"], "rays": WHOLE["tables"]["rays"]}}
        only = filled(PAGE, {**NOTHING, **some}, "a processor")
        blocks = [{name: text for text, name in ((b[0], b[2]) for b in BLOCK.finditer(page))} for page in (PAGE, only)]
        self.assertEqual([name for name in blocks[0] if blocks[0][name] != blocks[1][name]], ["series"])

    def test_every_table_is_filled(self):
        text = filled(PAGE, WHOLE, "a processor")
        self.assertEqual(filled(text, WHOLE, "a processor"), text)
        for line in ["2 threads of a processor, AVX2; one core copies 26.7 GB/s; disk 2854 MB/s.",
                     "| `polar_shadow`: `polar`, shadow masks | 10 (9.5–12.2) | 36,000 | 123 | 14.7 | 34% |",
                     "| `random_debris`, 512 × 2392: default | 10 (9.5–12.2) | 36,000 | 123 | 14.7 | 34% |",
                     "| `trace` | 2.5 | 2.5 | 2.5 | 2.5 | 2.5 |",
                     "| `full` | 512 × 114 | 2.5 | 2.5 | 2.5 | 133 | 1.6e-06, 9.7e-06 |",
                     "| `azimuths_deg` | 2.5 | 2.5 | 2.5 | 2.5 | 2.5 | 2.5 | 1 |",
                     "| threads | 1 → 2 | 30 → 60 | 0.06, – |",
                     "| `speckle_wall`: moments alone | 10 | 2.5 | 2.5 | 123 |",
                     "| `series` | 7.5 | 7.5 | 5 | 10 | 2.5 | 10 | 42.5 | 4.25 | 1.47 |"]:
            self.assertIn(line + "\n", text)

    def test_the_table_of_a_device(self):
        text = filled(PAGE, CHECK, "")
        for line in ["a device, driver 580.65, CUDA 13.0, 16 threads of a processor:",
                     "| full | ≥ 15,000 | 20,123 pings/s | yes |", "| sets | ≥ 1.5 | 1.24 | no |",
                     "| scenes | ≤ 1e-05 | not measured | – |"]:
            self.assertIn(line + "\n", text)


if __name__ == "__main__":
    unittest.main()
