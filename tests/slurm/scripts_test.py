"""What scripts/slurm does without a cluster: Slurm's commands and the program are played. SCRIPTS is scripts/."""
import os
import pathlib
import shutil
import tempfile
import unittest

from slurm_test import SCRIPTS, run


class Scripts(unittest.TestCase):
    def setUp(self):
        self.here = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-scripts-"))
        self.addCleanup(shutil.rmtree, self.here, ignore_errors=True)

    def test_says_how_to_run_on_one_machine(self):
        for tool in ("bash", "dirname", "sed"):
            os.symlink(shutil.which(tool), self.here / tool)
        result = run(SCRIPTS / "submit.sh", "a.yaml", "out", env={"PATH": str(self.here)})
        self.assertEqual(result.returncode, 4, result.stderr)
        self.assertIn("ensonify sweep a.yaml -o out", result.stderr)

    def write(self, name, text):
        (self.here / name).write_text("#!/bin/bash\n" + text)
        (self.here / name).chmod(0o755)

    def start_task(self):
        """task.sh with Slurm's commands played; its exit status and whether it asked to be requeued."""
        asked = self.here / "asked"
        asked.unlink(missing_ok=True)
        self.write("squeue", "echo RUNNING")
        self.write("scontrol", f'echo "$@" >{asked}')
        (self.here / "out.slurm").mkdir(exist_ok=True)
        result = run(
            SCRIPTS / "task.sh", self.here / "program", "a.yaml", self.here / "out", "2",
            env={"PATH": f"{self.here}:{os.environ['PATH']}",
                 "SLURM_ARRAY_JOB_ID": "7", "SLURM_ARRAY_TASK_ID": "1",
                 "SLURM_ARRAY_TASK_COUNT": "1", "SLURM_CPUS_PER_TASK": "6"},
        )
        self.said = result.stdout
        return result.returncode, asked.exists() and asked.read_text()

    def test_gives_up_after_three_starts_that_brought_nothing(self):
        folder = self.here / "out" / "runs" / ("0" * 16)
        folder.mkdir(parents=True)
        listed = 'if [ "$3" = --list ]; then echo "0000000000000000 1 2"; exit; fi\n'
        self.write("program", listed + "kill -KILL $$")
        again = (0, "requeue 7_1\n")
        self.assertEqual([self.start_task() for _ in range(4)], [again] * 3 + [(1, False)])
        # What makes progress is started as often as it takes.
        self.write("program", listed + f"mktemp {folder}/XXXX >/dev/null; kill -KILL $$")
        self.assertEqual([self.start_task() for _ in range(6)], [again] * 6)
        # So is a study, whose moments grow in one file of one size.
        moments = folder / ".work" / "sequences" / "000000" / "moments.bin"
        moments.parent.mkdir(parents=True)
        self.write("program", listed + f"sleep 0.01; echo 1 >{moments}; kill -KILL $$")
        self.assertEqual([self.start_task() for _ in range(6)], [again] * 6)
        # A temporary file is no progress.
        other = folder / ".work" / "tmp"
        other.mkdir()
        self.write("program", listed + f"mktemp {other}/XXXX >/dev/null; kill -KILL $$")
        self.assertIn((1, False), [self.start_task() for _ in range(5)])

    def test_names_shard_and_threads_itself(self):
        """By Slurm's variables a lone task of a second array would be all of the sweep."""
        self.write("program", 'echo "$@"')
        self.start_task()
        self.assertIn(f"sweep a.yaml -o {self.here}/out --shard 1/2 --threads 6\n", self.said)

    def test_keeps_the_programs_exit_status(self):
        for status in (0, 2, 3, 5):
            self.write("program", f"exit {status}")
            self.assertEqual(self.start_task(), (status, False))


if __name__ == "__main__":
    unittest.main()
