"""Sweeps on a real Slurm: cluster.sh starts one with two nodes on the loopback, in a private folder.

Protects what scripts/slurm promises: whatever is killed, the sweep becomes whole, in the bytes that one
process makes. Kills hit programs that are stopped after their first pings, however fast the machine
is. Skips where Slurm is not installed. ENSONIFY is the program, SCRIPTS the folder scripts/. Run by
ctest; by hand, as root or not:
    ENSONIFY=build/release/ensonify SCRIPTS=scripts python3 -m unittest slurm_test
"""
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from program import SMALL, hashes  # noqa: E402

PROGRAM = pathlib.Path(os.environ.get("ENSONIFY", "ensonify")).absolute()
SCRIPTS = pathlib.Path(os.environ.get("SCRIPTS", "scripts")).absolute() / "slurm"
HERE = pathlib.Path(__file__).parent.absolute()
PATH = os.environ["PATH"] + ":/usr/sbin"
MISSING = [
    name
    for name in ("munged", "slurmctld", "slurmd", "sbatch", "setsid")
    if not shutil.which(name, path=PATH)
]

SCENARIO = SMALL.replace("pings: 30", "pings: 80").replace("cartesian: {height_px: 100}", "cartesian: false, png: false")
SWEEP = """ensonify_sweep: 1
name: small
base: small_scene.yaml
axes: [{key: materials.m.reflectivity, name: wall, values: [1e-3, 2e-3, 3e-3, 4e-3]}]
"""


# Waits before it begins, where it is not a second start.
HELD = """#!/bin/sh
case " $* " in *" --threads "*) [ "${SLURM_RESTART_COUNT:-0}" -gt 0 ] || kill -STOP $$ ;; esac
exec %s "$@"
"""


def until(what, condition, seconds=600):
    """The limit ends what hangs, and is no measure: machines may be busy."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.02)
    raise AssertionError(f"never came: {what}")


def run(*command, **options):
    return subprocess.run([*map(str, command)], capture_output=True, text=True, **options)


def processes(**variables):
    """Process ids by variables of their environment."""
    wanted = {f"{name}={value}".encode() for name, value in variables.items()}
    found = []
    for folder in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            if wanted <= set((folder / "environ").read_bytes().split(b"\0")):
                found.append(int(folder.name))
        except OSError:
            pass  # ended meanwhile, or somebody else's
    return found


def command_of(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return b""


def stat_of(pid):
    """State, parent and what else /proc says."""
    return pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()


def parent(pid):
    return int(stat_of(pid)[1])


def send(number, pids):
    for pid in pids:
        try:
            os.kill(pid, number)
        except ProcessLookupError:
            pass


class Cluster(unittest.TestCase):
    alone = None

    @classmethod
    def setUpClass(cls):
        if MISSING:
            raise unittest.SkipTest(f"not installed: {', '.join(MISSING)}")
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-slurm-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        # Out of this process' tree: it must outlive a test that ctest kills, to clear up after it.
        cls.cluster = subprocess.Popen(
            ["setsid", "--fork", HERE / "cluster.sh", cls.folder / "cluster", "2"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )
        cls.addClassCleanup(cls.take_down)
        cls.conf = cls.folder / "cluster" / "slurm.conf"
        cls.environment = dict(os.environ, SLURM_CONF=str(cls.conf), PATH=PATH)
        for name in list(cls.environment):  # of a job that this test may be part of
            if re.match("(SLURM|SBATCH)_(?!CONF)", name):
                del cls.environment[name]
        if cls.cluster.stdout.readline() != "up\n":
            raise AssertionError("no cluster came up")

    @classmethod
    def take_down(cls):
        cls.cluster.stdin.close()
        cls.cluster.stdout.read()  # ends with the cluster
        cls.cluster.stdout.close()
        cls.cluster.wait()
        left = processes(SLURM_CONF=cls.conf)
        if left:
            raise AssertionError(f"left behind: {left}")

    def setUp(self):
        self.here = pathlib.Path(tempfile.mkdtemp(dir=self.folder))
        (self.here / "small_scene.yaml").write_text(SCENARIO)
        self.sweep = self.here / "small.yaml"
        self.sweep.write_text(SWEEP)
        self.out = self.here / "out"

    def slurm(self, *command):
        result = run(*command, env=self.environment)
        self.assertEqual(result.returncode, 0, f"{command}: {result.stdout}{result.stderr}")
        return result.stdout

    def submit(self, *options, program=PROGRAM):
        """Of submit.sh: the array's id, and what it said."""
        said = self.slurm(SCRIPTS / "submit.sh", self.sweep, self.out, "--program", program, *options,
                          "--", "--cpus-per-task=1", "--time=5")
        return re.search(r"array (\d+)", said)[1], said

    def state(self, job):
        return self.slurm("squeue", "-h", "-t", "all", "-j", job, "-o", "%T").strip()

    def wait_for_end(self):
        self.begin_alone()  # meanwhile
        until("an empty queue", lambda: not self.slurm("squeue", "-h"))

    def begin_alone(self):
        """One process makes the sweep, once for all tests of a class."""
        if self.alone is None and self.sweep.read_text() == SWEEP:
            folder = self.folder / "alone"
            folder.mkdir()
            (folder / "small_scene.yaml").write_text(SCENARIO)
            (folder / "small.yaml").write_text(SWEEP)
            command = [PROGRAM, "sweep", folder / "small.yaml", "-o", folder / "out", "--quiet"]
            type(self).alone = subprocess.Popen(command)
            self.addClassCleanup(self.alone.wait)

    def logs(self, name="*"):
        return "".join(path.read_text() for path in sorted((self.here / "out.slurm").glob(name)))

    def ids(self, shard="0/1"):
        said = run(PROGRAM, "sweep", self.sweep, "--list", "--shard", shard).stdout
        return re.findall("^([0-9a-f]{16}) ", said, re.M)

    def submit_held(self, tasks):
        """The array's id, and process ids by task: each program stopped after its first pings."""
        held = self.here / "held"
        held.write_text(HELD % PROGRAM)
        held.chmod(0o755)
        job, _ = self.submit("--tasks", str(tasks), program=held)
        return job, {task: self.after_first_pings(job, task, tasks) for task in range(tasks)}

    def after_first_pings(self, job, task, tasks):
        folders = [self.out / "runs" / name for name in self.ids(f"{task}/{tasks}")]
        [pid] = until(f"task {task}", lambda: self.stopped_programs(job, task))

        def one_step():
            send(signal.SIGCONT, [pid])
            time.sleep(0.02)
            send(signal.SIGSTOP, [pid])
            until("a stop", lambda: stat_of(pid)[0] == "T")
            return any(any(folder.rglob("000000*.npy")) for folder in folders)

        until("first pings", one_step)
        self.assertFalse(all((folder / "dataset.sha256").exists() for folder in folders))
        return pid

    def stopped_programs(self, job, task):
        pids = processes(SLURM_CONF=self.conf, SLURM_ARRAY_JOB_ID=job, SLURM_ARRAY_TASK_ID=task)
        return [pid for pid in pids if b"--threads" in command_of(pid) and stat_of(pid)[0] == "T"]

    def kill_node(self, name):
        """Its daemon and all that runs there; first who could tell the controller of the others' end."""
        daemon = int((self.folder / "cluster" / f"slurmd-{name}.pid").read_text())
        jobs = processes(SLURM_CONF=self.conf, SLURMD_NODENAME=name)
        steps = {pid for pid in map(parent, jobs) if command_of(pid).startswith(b"slurmstepd")}
        self.assertTrue(jobs and steps)
        for pids in ([daemon], steps, jobs):
            send(signal.SIGKILL, pids)

    def finalize(self, sweep, out):
        result = run(PROGRAM, "sweep", sweep, "-o", out, "--finalize")
        self.assertEqual(result.returncode, 0, result.stderr)

    def check_same_as_one_process(self):
        self.assertEqual(self.alone.wait(), 0)
        alone = self.folder / "alone" / "out"
        self.finalize(alone.parent / "small.yaml", alone)
        expected, made = hashes(alone), hashes(self.out)
        self.assertGreater(len(expected), 4)
        self.assertEqual(made, expected, self.logs())


class Killed(Cluster):
    def test_killed_tasks_and_a_killed_node(self):
        job, held = self.submit_held(4)
        where = dict(
            line.split() for line in self.slurm("squeue", "-h", "-r", "-j", job, "-o", "%K %N").splitlines()
        )
        stay = [task for task in where if where[task] == "n0"]
        gone = [task for task in where if where[task] == "n1"]
        self.assertEqual((len(stay), len(gone)), (2, 2), where)
        self.kill_node("n1")
        # One program: its task queues itself again.
        send(signal.SIGKILL, [held[int(stay[0])]])
        # One whole task, its script too: it has failed, and is queued again by hand.
        lost = f"{job}_{stay[1]}"
        send(signal.SIGKILL, processes(SLURM_CONF=self.conf, SLURM_ARRAY_TASK_ID=stay[1]))
        until("a failed task", lambda: self.state(lost) == "FAILED")
        self.slurm("scontrol", "requeue", lost)
        self.wait_for_end()
        for task in range(4):
            self.assertIn(f"shard {task}/4, 1 threads, start 2", self.logs(f"{job}_{task}.log"))
        self.check_same_as_one_process()


class Ended(Cluster):
    def test_a_task_told_to_end_goes_on_later_and_a_cancelled_one_does_not(self):
        job, held = self.submit_held(2)
        kept = {path: path.stat().st_ino for name in self.ids("0/2")
                for path in (self.out / "runs" / name).rglob("0*.npy")}
        self.assertTrue(kept)
        self.slurm("scancel", "--batch", "--signal=TERM", f"{job}_0")
        self.slurm("scancel", f"{job}_1")
        send(signal.SIGCONT, held.values())
        self.wait_for_end()
        log = self.logs(f"{job}_0.log")
        self.assertIn("ended with 130", log)
        self.assertIn("shard 0/2, 1 threads, start 2", log)
        self.assertEqual({path: path.stat().st_ino for path in kept}, kept, "made again")
        self.assertNotIn("start 2", self.logs(f"{job}_1.log"))
        # The last step ran all the same, and says what is missing.
        self.assertTrue((self.out / "runs.csv").exists(), self.logs())
        self.assertIn("not all runs are there", self.logs("*_end.log"))
        # A lost task alone: still shard 1 of 2.
        self.slurm("sbatch", "--array=1", "--cpus-per-task=1", "--output", self.here / "out.slurm" / "alone.log",
                   SCRIPTS / "task.sh", PROGRAM, self.sweep, self.out, "2")
        self.wait_for_end()
        self.assertIn("shard 1/2, 1 threads, start 1", self.logs("alone.log"))
        self.finalize(self.sweep, self.out)
        self.check_same_as_one_process()


class Failed(Cluster):
    def test_a_failed_run_does_not_hold_back_the_rest(self):
        # Somebody else's folder in the place of a run.
        foreign = self.out / "runs" / self.ids()[2]
        foreign.mkdir(parents=True)
        (foreign / "letter.txt").write_text("not a data set")
        job, said = self.submit("--tasks", "9")  # four runs
        self.assertIn("4 runs in 4 tasks", said)
        self.wait_for_end()
        states = sorted(self.slurm("squeue", "-h", "-r", "-t", "all", "-j", job, "-o", "%T").split())
        self.assertEqual(states, ["COMPLETED"] * 3 + ["FAILED"], self.logs())
        self.assertTrue((self.out / "failed" / f"{foreign.name}.json").exists())
        self.assertIn(foreign.name, (self.out / "index.json").read_text())
        shutil.rmtree(foreign)
        self.submit()  # the same again takes up what is missing
        self.wait_for_end()
        self.check_same_as_one_process()


class Refused(Cluster):
    def test_what_cannot_run_is_not_submitted(self):
        self.sweep.write_text(SWEEP.replace("values", "valuse"))
        result = run(SCRIPTS / "submit.sh", self.sweep, self.out, "--program", PROGRAM, env=self.environment)
        self.assertEqual(result.returncode, 2)
        self.assertIn("valuse", result.stderr)
        self.sweep.write_text(SWEEP)
        for options in (["--tasks", "0"], ["--tasks"], ["--", "--array=3"], ["--", "-n4"]):
            result = run(SCRIPTS / "submit.sh", self.sweep, self.out, "--program", PROGRAM, *options,
                         env=self.environment)
            self.assertEqual(result.returncode, 2, options)
        self.assertEqual(self.slurm("squeue", "-h"), "")
        self.assertFalse(self.out.exists())

    def test_a_gpu_for_each_task_and_the_program_told_to_use_it(self):
        job, _ = self.submit("--tasks", "2", "--gpus")
        self.assertIn("gres:gpu:1", self.slurm("scontrol", "show", "job", job))
        self.wait_for_end()
        # The program does not do without it: where there is none in truth, it ends with 5.
        options = ["-o", self.here / "probe", "--backend", "cuda", "--quiet"]
        status = run(PROGRAM, "sweep", self.sweep, *options).returncode
        self.assertEqual(self.logs(f"{job}_*.log").count(f"ended with {status}"), 2, self.logs())

    def test_more_tasks_than_an_array_may_have(self):
        self.sweep.write_text(SWEEP + "seeds: 2\n")
        job, said = self.submit("--tasks", "8")  # MaxArraySize is 5 here
        self.slurm("scancel", job)
        self.assertIn("8 runs in 5 tasks", said)
        self.wait_for_end()


if __name__ == "__main__":
    unittest.main()
