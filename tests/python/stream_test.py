"""Streams: order, bounded memory, failures, and clean ends."""
import json
import multiprocessing
import os
import signal
import subprocess
import sys
import tempfile
import textwrap
import time
import unittest
import warnings

import ensonify as en
from small_data import SCENES

SMALL = {"sonar.beams.count": 24, "sonar.rays.elevation": 16, "sonar.range_max_m": 4, "output.cartesian": False,
         "output.png": False}
DEBRIS = SCENES / "random_debris.yaml"


CROWDED = {"objects.bottle.count": {"uniform": [0, 400]}, "objects.bottle.place.on_failure": "skip_sequence",
           "trajectory.pings": 1}


def debris(**more):
    return en.Scenario.load(DEBRIS, set={**SMALL, **more})


def level_in_child(scenario, sent):
    try:
        sent.put(scenario.ping(1, 0, want=["level_db"]).polar.level_db.tobytes())
    except Exception as error:  # whatever it is, the parent is to see it
        sent.put(error)


class Streams(unittest.TestCase):
    def test_pings_come_in_order_whatever_the_threads(self):
        scenario = debris(**{"trajectory.pings": 3})
        levels = {}
        for threads in (1, 2, 5):
            pings = list(scenario.stream(sequences=[4, 1, 7], threads=threads, want=["level_db"]))
            self.assertEqual([(p.sequence.number, p.number) for p in pings],
                             [(s, p) for s in (4, 1, 7) for p in range(3)])
            levels[threads] = b"".join(p.polar.level_db.tobytes() for p in pings)
        self.assertEqual(levels[1], levels[2])
        self.assertEqual(levels[1], levels[5])

    def test_ranges_splits_and_pings_choose(self):
        scenario = debris(**{"trajectory.pings": 3})
        val = [n for n in range(40) if scenario.split(n) == "val"]
        self.assertTrue(2 < len(val) < 20)
        got = [(p.sequence.number, p.number) for p in
               scenario.stream(range(40), split="val", pings=(1, 2), want=["instance"])]
        self.assertEqual(got, [(n, 1) for n in val])
        got = [p.sequence.number for p in scenario.stream(list(range(40)), split="val", pings=(1, 2), want=[])]
        self.assertEqual(got, val)
        got = [(p.sequence.number, p.number) for p in scenario.stream(range(1, 8, 3), skipped=2, want=[])]
        self.assertEqual(got, [(1, 2)] + [(n, p) for n in (4, 7) for p in range(3)])
        # Beyond the number that the scenario gives.
        self.assertEqual(next(scenario.stream([10 ** 9], want=[])).sequence.number, 10 ** 9)

    def test_arrays_outlive_the_stream(self):
        pings = list(debris().stream(range(2), want=["level_db"]))
        arrays = [p.polar.level_db for p in pings]
        sums = [a.sum() for a in arrays]
        del pings
        self.assertEqual(sums, [a.sum() for a in arrays])
        arrays[0][:] = 0
        self.assertEqual(sums[1], arrays[1].sum())

    def test_memory_does_not_grow_with_the_stream(self):
        def resident_mb():
            with open("/proc/self/statm", encoding="ascii") as file:
                return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6

        marks = []
        for i, _ in enumerate(debris(**{"trajectory.pings": 1}).stream(range(75), threads=2, want=["level_db"])):
            if i % 25 == 24:
                marks.append(resident_mb())
        # A ping of these is 0.1 MB and a world 2 MB: 50 that are kept would show.
        self.assertLess(marks[-1] - marks[0], 30, marks)

    def test_pings_wait_ready_until_the_stream_is_closed(self):
        for pings in (1, 3):
            stream = debris(**{"trajectory.pings": pings}).stream(range(1000), threads=2, want=["level_db"], ahead=7)
            next(stream)
            while not stream._core.is_resting:
                time.sleep(0.01)
            self.assertEqual(stream.ready, 7)
            stream.close()
            self.assertEqual(list(stream), [])
            self.assertEqual(stream.ready, 0)

    def test_a_sequence_that_cannot_be_made_is_passed_over(self):
        crowded = debris(**CROWDED)
        stream = crowded.stream(range(6), want=["instance"])
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            made = [p.sequence.number for p in stream]
        self.assertTrue(0 < len(stream.failed) < 6, stream.failed)
        self.assertEqual(len(made) + len(stream.failed), 6)
        self.assertEqual(made, sorted(made))
        self.assertEqual(len([w for w in told if w.category is RuntimeWarning]), len(stream.failed))
        failed = min(set(range(6)) - set(made))
        with self.assertRaises(en.ScenarioError):
            crowded.ping(failed)
        # The first one is nothing special, whether the scenario counts the others or not.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for seed in range(12, 60):
                crowded = debris(seed=seed, sequences=1, **CROWDED)
                stream = crowded.stream(range(4), want=["instance"])
                made = [p.sequence.number for p in stream]
                self.assertEqual(len(made) + len(stream.failed), 4)
                if made and 0 not in made:
                    break
            self.assertNotIn(0, made)
            self.assertIn(f"sequence {made[0]} from above", crowded._repr_html_())

    def test_an_exception_in_the_loop_ends_the_threads(self):
        def threads():
            return len(os.listdir("/proc/self/task"))

        next(debris().stream(threads=3))
        before = threads()
        with self.assertRaises(ZeroDivisionError):
            for _ in debris().stream(range(1000), threads=3):
                1 / 0
        deadline = time.monotonic() + 600  # against hanging alone
        while threads() > before and time.monotonic() < deadline:
            time.sleep(0.05)
        self.assertLessEqual(threads(), before)

    def test_ctrl_c_ends_a_stream_and_a_data_set(self):
        for work in ("for ping in s.stream(range(10**6)): print(ping.number, flush=True)",
                     "en.generate(s, sys.argv[1], progress=lambda done, all: print(done, flush=True))"):
            program = textwrap.dedent(f"""
                import sys, ensonify as en
                s = en.Scenario.load({str(DEBRIS)!r}, set={{"sequences": 3000, "sonar.beams.count": 32}})
                print("begin", flush=True)
                {work}""")
            with self.subTest(work=work), tempfile.TemporaryDirectory() as folder:
                run = subprocess.Popen([sys.executable, "-c", program, folder + "/set"], stdout=subprocess.PIPE,
                                       stderr=subprocess.PIPE, text=True)
                self.assertEqual(run.stdout.readline(), "begin\n")
                run.stdout.readline()
                run.send_signal(signal.SIGINT)
                _, errors = run.communicate(timeout=600)
                self.assertIn("KeyboardInterrupt", errors)
                self.assertNotEqual(run.returncode, -signal.SIGSEGV, errors)
                self.assertNotIn("terminate called", errors)

    def test_a_fork_before_the_first_world_works_and_one_after_says_so(self):
        program = textwrap.dedent(f"""
            import multiprocessing, sys
            sys.path.insert(0, {os.path.dirname(os.path.abspath(__file__))!r})
            from stream_test import debris, level_in_child
            s, context = debris(), multiprocessing.get_context("fork")

            def child():
                sent = context.Queue()
                process = context.Process(target=level_in_child, args=(s, sent))
                process.start()
                got = sent.get(timeout=600)
                process.join(600)
                return got

            first = child()
            here = s.ping(1, 0, want=["level_db"]).polar.level_db.tobytes()
            print(first == here, type(child()).__name__)
            """)
        run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=1200)
        self.assertEqual(run.stdout, "True RuntimeError\n", run.stderr)

    @unittest.skipUnless("HOST_DEVICE" in os.environ, "built without the device that is the host")
    def test_a_device_makes_the_pings_or_one_warning_says_why_not(self):
        """Series of a device, whose memory they keep, also outlive their stream and scenario."""
        program = textwrap.dedent("""\
            import gc, json, sys, warnings
            import numpy as np
            import ensonify as en
            made = {}
            for device in (False, True):
                with warnings.catch_warnings(record=True) as caught:
                    warnings.simplefilter("always")
                    scene = en.Scenario.load(sys.argv[1], set=json.loads(sys.argv[2]), device=device)
                    series = [ping.series for ping in scene.stream(want=["series"])]
                    scene.ping(want=["series"])
                del scene
                gc.collect()
                made[device] = np.array(series)
            error = np.linalg.norm(made[True] - made[False]) / np.linalg.norm(made[False])
            print(json.dumps([float(error), [str(warning.message) for warning in caught]]))
            """)
        keys = json.dumps({**SMALL, "trajectory.pings": 3})
        for module, device, words in [("", "", None), ("", "free=1000", "cpu in place of cuda, the host itself: one"),
                                      ("none.so", "", "no device: CUDA: there is no none.so")]:
            with self.subTest(module=module, device=device):
                run = subprocess.run([sys.executable, "-c", program, SCENES / "two_cylinders.yaml", keys],
                                     capture_output=True, text=True, timeout=600,
                                     env={**os.environ, "ENSONIFY_HOST_DEVICE": device,
                                          "ENSONIFY_CUDA_MODULE": module or os.environ["HOST_DEVICE"]})
                self.assertEqual(run.returncode, 0, run.stderr)
                error, warned = json.loads(run.stdout)
                if words is None:
                    self.assertGreater(error, 0)
                    self.assertLess(error, 1e-4)
                    self.assertEqual(warned, [])
                else:
                    self.assertEqual(error, 0)
                    self.assertEqual(len(warned), 1)
                    self.assertIn(words, warned[0])

    def test_a_spawned_process_makes_the_same(self):
        scenario = debris()
        here = scenario.ping(1, 0, want=["level_db"]).polar.level_db.tobytes()
        context = multiprocessing.get_context("spawn")
        sent = context.Queue()
        process = context.Process(target=level_in_child, args=(scenario, sent))
        process.start()
        self.assertEqual(sent.get(timeout=600), here)
        process.join(600)


if __name__ == "__main__":
    unittest.main()
