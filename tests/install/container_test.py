"""The recipe scripts/container/Dockerfile, built by podman and run as its first lines have it.

Where no registry answers, debootstrap makes the image debian:12, with ccache and this machine's cache, so that the
program is not compiled again. Skips where podman is not installed or cannot start containers here, and says
why. All of it, images too, is in a temporary folder. Run by ctest; by hand, as root:
    python3 -m unittest container_test
"""
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
RECIPE = ROOT / "scripts/container/Dockerfile"
MIRROR = os.environ.get("DEBIAN_MIRROR", "http://deb.debian.org/debian")
CACHE = pathlib.Path(os.environ.get("CCACHE_DIR", pathlib.Path.home() / ".cache/ccache"))
# Some machines allow no higher limits, and Debian's crun does not run under their control groups: runc does.
LIMITS = ("--ulimit", "nofile=1024:1024", "--ulimit", "nproc=4096:4096")
RUNC = shutil.which("runc", path="/usr/bin:/usr/sbin")
RUNTIMES = [[], ["--runtime", RUNC]] if RUNC else [[]]
SCENE = ("/usr/share/ensonify/scenes/seabed_and_target.yaml", "--pings", "0:1",
         "--set", "sonar.beams={count: 16, fov_deg: 40}", "--set", "sonar.rays={elevation: 8, min_per_cell: 8}")


def run(*command, **options):
    return subprocess.run([*map(str, command)], capture_output=True, text=True, encoding="utf-8", **options)


@unittest.skipUnless(shutil.which("podman"), "not installed: podman")
class Container(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-container-", dir="/var/tmp"))
        self.store = ["podman", "--root", self.folder / "images", "--runroot", self.folder / "run"]
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.addCleanup(run, "umount", "--lazy", self.folder / "images/overlay")
        self.addCleanup(run, *self.store, "rmi", "--all", "--force")

    def podman(self, *arguments, message=""):
        done = run(*self.store, *arguments)
        self.assertEqual(done.returncode, 0, message + done.stdout[-4000:] + done.stderr[-4000:])
        return done.stdout

    def make_base(self):
        """localhost/debian:12, where the registry's cannot be had."""
        if run(*self.store, "pull", "--quiet", "docker.io/library/debian:12").returncode == 0:
            return
        if not shutil.which("debootstrap", path=os.environ["PATH"] + ":/usr/sbin") or os.geteuid() != 0:
            self.skipTest("podman cannot start without a base image: no registry answers, and debootstrap needs "
                          "root and its package")
        base = self.folder / "base"
        made = run("/usr/sbin/debootstrap", "--variant=minbase", "--include=ccache", "bookworm", base, MIRROR)
        self.assertEqual(made.returncode, 0, made.stdout[-4000:])
        packed = self.folder / "base.tar"
        subprocess.run(["tar", "-C", base, "--exclude=./var/cache/apt/archives/*.deb", "-cf", packed, "."], check=True)
        shutil.rmtree(base)
        # ccache takes what another language's compiler has made for something else.
        language = ["--change", f"ENV LANG={os.environ['LANG']}"] if "LANG" in os.environ else []
        self.podman("import", *language, packed, "localhost/debian:12")

    def runtime(self):
        """Arguments with which podman runs a container here."""
        refusals = []
        for runtime in RUNTIMES:
            tried = run(*self.store, *runtime, "run", "--rm", "--network=none", *LIMITS, "debian:12", "true")
            if tried.returncode == 0:
                return runtime
            refusals.append(tried.stderr.strip().splitlines()[-1] if tried.stderr else "no message")
        self.skipTest(f"podman cannot start containers here: {'; '.join(refusals)}")

    def test_it_is_built_and_makes_a_data_set(self):
        self.make_base()
        runtime = self.runtime()
        cache = ["--volume", f"{CACHE}:/root/.cache/ccache"] if CACHE.is_dir() else []
        # What is committed, without builds and outputs of this folder.
        source = self.folder / "source"
        subprocess.run(["git", "clone", "-q", ROOT, source], check=True)
        self.podman("build", "--isolation=chroot", "--network=host", *cache, "--tag", "localhost/ensonify", "--file",
                    source / RECIPE.relative_to(ROOT), source)
        data = self.folder / "data"
        data.mkdir(mode=0o777)
        os.chown(data, 1000, 1000)
        container = [*runtime, "run", "--rm", "--network=none", *LIMITS, "--volume", f"{data}:/data", "--workdir",
                     "/data", "--user", "1000:1000", "localhost/ensonify"]
        self.podman(*container, "generate", *SCENE, "--output", "out")
        self.podman(*container, "verify", "out")
        images = list((data / "out").rglob("*.png"))
        self.assertTrue(images)
        self.assertEqual(images[0].stat().st_uid, 1000)
        compiler = run(*self.store, *runtime, "run", "--rm", "--network=none", *LIMITS, "--entrypoint", "sh",
                       "localhost/ensonify", "-c", "command -v c++")
        self.assertEqual((compiler.returncode, compiler.stdout), (127, ""), "the image holds a compiler")


if __name__ == "__main__":
    unittest.main()
